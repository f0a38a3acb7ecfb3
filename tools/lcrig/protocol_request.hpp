// SPDX-License-Identifier: Apache-2.0
// A protocol as a command line asks for it: by name or file, changed by -p.
#pragma once

#include <string>
#include <vector>

#include "daemon/control/messages.hpp"
#include "protocols/file/parse.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

struct ProtocolRequest {
  std::string typed;  // name or path
  LibraryFile file;  // its text has the meter's settings that -p gave
  std::string text_of_file;  // without them
  ParameterValues parameters;  // the others
};
// `assignments`: "name=value". Besides the protocol's parameters, `frequency_Hz` and `aperture`
// change the meter's settings of any protocol. Failure: usage, or no such protocol.
Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments);

// A protocol with values for its parameters. Failure: as file_refused and plan_refused.
struct BoundProtocol {
  Protocol protocol;
  Environment environment;
};
Outcome<BoundProtocol> bind_protocol(const Context& context, const ProtocolRequest& wanted);

// Refusals: of a file; of the values of parameters, or of what the protocol asks of a rig
// (`protocol`: as typed); of a bench.
Failure file_refused(const Error& error);
Failure plan_refused(const Context& context, const std::string& protocol, const Error& error);
Failure bench_refused(const Error& error, bool of_a_file);

// Refusal by the daemon to run or to plan. The daemon knows neither the path of the protocol's file
// nor which specimens have similar names.
Failure refused_run(const Context& context, Failure refused, const RunRequest& request,
                    const std::string& protocol, const std::vector<std::string>& assignments);

// The request to run or to plan. The daemon may not read our files, so it gets their texts. A
// specimen that is not known here may be one of its database.
Outcome<RunRequest> run_request(const LibraryPath& library, const std::string& protocol,
                                const std::vector<std::string>& assignments,
                                const std::string& specimen);

}  // namespace lcrig::cli
