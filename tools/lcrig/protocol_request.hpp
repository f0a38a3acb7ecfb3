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
  LibraryFile file;  // its text has the meter's settings that -p gave
  ParameterValues parameters;  // the others
};
// `assignments`: "name=value". Besides the protocol's parameters, `frequency_Hz` and `aperture`
// change the meter's settings of any protocol. Failure: usage, or no such protocol.
Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments);

// What the daemon refused to run or to plan. It does not know which specimens have similar names.
Failure refused_run(const Context& context, Failure refused, const RunRequest& request);

// What the daemon is asked to run or to plan. It may not read our files, so it gets their texts. A
// specimen that is not known here may be one of its database.
Outcome<RunRequest> run_request(const LibraryPath& library, const std::string& protocol,
                                const std::vector<std::string>& assignments,
                                const std::string& specimen);

}  // namespace lcrig::cli
