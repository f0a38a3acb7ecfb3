// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/fields.hpp"

#include <nlohmann/json.hpp>

#include "base/decimal.hpp"
#include "base/json_or_null.hpp"

namespace lcrig {

using nlohmann::json;

void FieldWriter::put(const char* key, json value) {
  out_[key] = std::move(value);
}

void FieldWriter::text(const char* key, std::string_view v, bool, std::size_t) {
  out_[key] = v;
}

void FieldWriter::text_or_null(const char* key, std::string_view v) {
  out_[key] = v.empty() ? json() : json(v);
}

void FieldWriter::text_or_absent(const char* key, const std::string& v, std::size_t) {
  if (!v.empty()) out_[key] = v;
}

void FieldWriter::texts(const char* key, const std::vector<std::string>& v) {
  out_[key] = v;
}

void FieldWriter::integer(const char* key, std::int64_t v, bool) {
  out_[key] = v;
}

void FieldWriter::integer(const char* key, const std::optional<std::int64_t>& v) {
  out_[key] = json_or_null(v);
}

void FieldWriter::number(const char* key, double v, bool) {
  out_[key] = v;
}

void FieldWriter::boolean(const char* key, bool v) {
  out_[key] = v;
}

void FieldWriter::quantity(const char* key, const std::optional<double>& si, int power) {
  out_[key] = si ? json(shift_decimal(*si, -power)) : json();
}

void FieldWriter::numbers(const char* key, const ParameterValues& v) {
  json& object = out_[key] = json::object();
  for (const auto& [name, value] : v) {
    std::visit([&object, &name](const auto& each) { object[name] = each; }, value);
  }
}

FieldWriter FieldWriter::inside(const char* key) {
  return FieldWriter(out_[key] = json::object());
}

FieldWriter FieldWriter::item(const char* key) {
  return FieldWriter(out_[key].emplace_back(json::object()));
}

}  // namespace lcrig
