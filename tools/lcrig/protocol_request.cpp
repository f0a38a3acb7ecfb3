// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/protocol_request.hpp"

#include "protocols/file/meter_text.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments) {
  auto parameters = parse_assignments(assignments);
  if (!parameters) return parameters.error();
  auto file = library.get(LibraryKind::protocol, protocol);
  if (!file) return file.error();
  ProtocolRequest out{std::move(*file), std::move(*parameters)};
  auto text = with_meter_values(out.file.text, out.file.path.string(), out.parameters);
  if (!text) {
    Failure refused(text.error(), fmt::format("lcrig protocol show {}", protocol));
    refused.code = kProtocol;
    return refused;
  }
  out.file.text = std::move(*text);
  return out;
}

}  // namespace lcrig::cli
