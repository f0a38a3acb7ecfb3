// SPDX-License-Identifier: Apache-2.0
// A protocol as a command line asks for it: by name or file, changed by -p.
#pragma once

#include <string>
#include <vector>

#include "protocols/file/parse.hpp"
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

}  // namespace lcrig::cli
