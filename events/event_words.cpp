// SPDX-License-Identifier: Apache-2.0
#include "events/event_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/units.hpp"

namespace lcrig {

namespace {

using nlohmann::json;

std::string spaced(std::string_view name) {
  std::string out(name);
  std::ranges::replace(out, '_', ' ');
  return out;
}

// "mm_s" is written "mm/s".
std::string unit_of(const KeyParts& key) {
  std::string out = key.unit == nullptr ? "" : std::string(key.unit->suffix);
  std::ranges::replace(out, '_', '/');
  return out;
}

std::string field_words(const std::string& name, const json& value) {
  const KeyParts key = split_key(name);
  if (!value.is_number()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    return fmt::format("{} {}", spaced(name), text);
  }
  const double number = value.get<double>();
  if (unit_of(key) == "m") return fmt::format("{} {:.5g} mm", spaced(key.stem), number * 1e3);
  if (key.unit == nullptr) return fmt::format("{} {:.5g}", spaced(key.stem), number);
  return fmt::format("{} {:.4g} {}", spaced(key.stem), number, unit_of(key));
}

}  // namespace

std::string event_words(std::string_view detail) {
  const json fields = json::parse(detail, nullptr, false);
  if (!fields.is_object()) return std::string(detail);
  std::string out;
  for (const auto& [name, value] : fields.items()) {
    if (value.is_null()) continue;
    out += (out.empty() ? "" : ", ") + field_words(name, value);
  }
  return out;
}

}  // namespace lcrig
