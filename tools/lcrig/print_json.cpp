// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/print_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"

namespace lcrig::cli {

// JSON escapes what ASCII has; some terminals also obey U+0080..9F and all reorder text.
void print_json(std::ostream& out, const nlohmann::json& value) {
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size() + 1);
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view before = rest;
    const char32_t c = take_character(rest);
    if (is_steering(c)) {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe += before.substr(0, before.size() - rest.size());
    }
  }
  out << safe << '\n';
}

ExitCode show(Context& context, const nlohmann::json& result,
              const std::function<void(std::ostream&)>& text) {
  if (context.global.json) {
    print_json(context.console.out, result);
  } else {
    text(context.console.out);
  }
  return kOk;
}

}  // namespace lcrig::cli
