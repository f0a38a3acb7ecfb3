// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/protocol_request.hpp"

#include <utility>

#include "base/doc_page.hpp"
#include "protocols/file/meter_text.hpp"
#include "storage/database.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

Outcome<ProtocolRequest> find_protocol(const LibraryPath& library, const std::string& protocol,
                                       const std::vector<std::string>& assignments) {
  auto parameters = parse_assignments(protocol, assignments);
  if (!parameters) return parameters.error();
  auto file = library.get(LibraryKind::protocol, protocol);
  if (!file) return file.error();
  ProtocolRequest out;
  out.typed = protocol;
  out.file = std::move(*file);
  out.parameters = std::move(*parameters);
  MeterValue wrong = MeterValue::none;
  auto text = with_meter_values(out.file.text, out.file.path.string(), out.parameters, &wrong);
  if (!text) {
    if (wrong == MeterValue::none) return file_refused(text.error());
    Failure refused(text.error(), wrong == MeterValue::aperture
                                      ? "give -p aperture=auto, or one that it lists"
                                      : "give the number alone, in Hz");
    refused.code = kProtocol;
    return refused;
  }
  out.text_of_file = std::exchange(out.file.text, std::move(*text));
  return out;
}

Failure file_refused(const Error& error) {
  Failure out(error, "correct the file; " + doc_page("protocol-file") + " describes it");
  out.code = kProtocol;
  return out;
}

Failure plan_refused(const Context& context, const std::string& protocol, const Error& error) {
  Failure out(error, next_command(context.global, {"protocol", "show", protocol},
                                  "its parameters: -p NAME=VALUE"));
  if (error.code == Errc::invalid_request) out.code = kProtocol;
  return out;
}

Outcome<BoundProtocol> bind_protocol(const Context& context, const ProtocolRequest& wanted) {
  const std::string path = wanted.file.path.string();
  auto protocol = parse_protocol(wanted.file.text, path);
  if (!protocol) {
    const bool correct_file = parse_protocol(wanted.text_of_file, path).has_value();
    return correct_file ? plan_refused(context, wanted.typed, protocol.error())
                        : file_refused(protocol.error());
  }
  auto environment = bind_parameters(*protocol, wanted.parameters);
  if (!environment) return plan_refused(context, wanted.typed, environment.error());
  return BoundProtocol{std::move(*protocol), std::move(*environment)};
}

Failure refused_run(const Context& context, Failure refused, const RunRequest& request,
                    const std::string& protocol, const std::vector<std::string>& assignments) {
  if (!refused.refused_request) return refused;
  refused.code = kProtocol;
  const auto wanted = find_protocol(LibraryPath(context.env), protocol, assignments);
  if (wanted) {
    if (auto bound = bind_protocol(context, *wanted); !bound) return bound.error();
  }
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
