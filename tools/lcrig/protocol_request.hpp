// SPDX-License-Identifier: Apache-2.0
// A protocol as the command line asks for it: by name or file, changed by -p. Many commands use it.
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
  LibraryFile file;  // its text includes the meter's settings from -p
  std::string text_of_file;  // without these settings
  ParameterValues parameters;  // the other -p
};
// `assignments`: "name=value". Besides the protocol's parameters, `frequency_Hz` and `aperture`
// change the meter's settings. Failure: usage, or no such protocol.
Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments);

// A protocol with values for its parameters. Failure: as file_refused and plan_refused.
struct BoundProtocol {
  Protocol protocol;
  Environment environment;
};
Outcome<BoundProtocol> bind_protocol(const Context& context, const ProtocolRequest& wanted);

// Failures for what was refused: a file; the values of parameters, or what the protocol asks of a
// rig (`protocol`: as typed).
Failure file_refused(const Error& error);
Failure plan_refused(const Context& context, const std::string& protocol, const Error& error);

// The daemon refused to run or to plan. It knows neither the path of the protocol's file nor
// specimens with similar names, so these are added here.
Failure refused_run(const Context& context, Failure refused, const RunRequest& request,
                    const std::string& protocol, const std::vector<std::string>& assignments);

// The request to run or to plan. The daemon may not be able to read our files, so it gets their
// texts. A specimen that is not known here may be in its database.
Outcome<RunRequest> run_request(const LibraryPath& library, const std::string& protocol,
                                const std::vector<std::string>& assignments,
                                const std::string& specimen);

}  // namespace lcrig::cli
