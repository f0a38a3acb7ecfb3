// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/protocol_request.hpp"

#include "base/strict_json.hpp"
#include "protocols/file/meter_text.hpp"
#include "storage/database.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/specimen_lookup.hpp"

namespace lcrig::cli {

Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments) {
  auto parameters = parse_assignments(protocol, assignments);
  if (!parameters) return parameters.error();
  auto file = library.get(LibraryKind::protocol, protocol);
  if (!file) return file.error();
  ProtocolRequest out{std::move(*file), std::move(*parameters)};
  auto text = with_meter_values(out.file.text, out.file.path.string(), out.parameters);
  if (!text) {
    const bool readable = JsonDocument::parse(out.file.text, out.file.name).has_value();
    Failure refused(text.error(), readable
                                      ? "give it in Hz, such as -p frequency_Hz=1000"
                                      : "correct the file; docs/protocol-file.md describes it");
    refused.code = kProtocol;
    return refused;
  }
  out.file.text = std::move(*text);
  return out;
}

Failure refused_run(const Context& context, Failure refused, const RunRequest& request) {
  if (!refused.refused_request) return refused;
  refused.code = kProtocol;
  if (!request.specimen_text.empty()) return refused;
  const auto db = context.db_path();
  std::error_code ignored;
  if (!db || !std::filesystem::exists(*db, ignored) || !open_read_only(*db)) return refused;
  const auto found = find_specimen_text(context, *db, request.specimen_name);
  if (found) return refused;
  return Failure(kProtocol, found.error().what, found.error().next);
}

Outcome<RunRequest> run_request(const LibraryPath& library, const std::string& protocol,
                                const std::vector<std::string>& assignments,
                                const std::string& specimen) {
  auto wanted = find_protocol(library, protocol, assignments);
  if (!wanted) return wanted.error();
  RunRequest out;
  out.parameters = std::move(wanted->parameters);
  out.protocol_name = wanted->file.path.filename().string();
  out.protocol_text = std::move(wanted->file.text);
  auto file = library.find(LibraryKind::specimen, specimen);
  if (!file) return file.error();
  out.specimen_name = *file ? (*file)->name : specimen;
  if (*file) out.specimen_text = std::move((*file)->text);
  return out;
}

}  // namespace lcrig::cli
