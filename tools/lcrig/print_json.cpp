// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/print_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.hpp"

namespace lcrig::cli {

// JSON escapes what ASCII has; some terminals also obey U+0080..9F and all reorder text.
std::string json_line(const nlohmann::json& value) {
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size() + 1);
  constexpr auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
  for (std::string_view rest = text; !rest.empty();) {
    // Nearly everything, so it is taken at once.
    const auto plain = std::ranges::find_if_not(rest, is_plain) - rest.begin();
    safe += rest.substr(0, static_cast<std::size_t>(plain));
    rest.remove_prefix(static_cast<std::size_t>(plain));
    if (rest.empty()) break;
    const std::string_view before = rest;
    const char32_t c = take_character(rest);
    if (is_steering(c)) {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe += before.substr(0, before.size() - rest.size());
    }
  }
  return safe;
}

void print_json(std::ostream& out, const nlohmann::json& value) {
  out << json_line(value) << '\n';
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
