// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/params.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/decimal.hpp"
#include "base/text.hpp"
#include "daemon/control/messages.hpp"

namespace lcrig {

ParamsReader::ParamsReader(const nlohmann::json& object, std::string where)
    : object_(object), where_(std::move(where)) {
  if (!object_.is_object()) {
    fail_with(Error(Errc::invalid_request,
                    fmt::format("{}: expected an object, got {}", where_, object_.type_name())));
  }
}

void ParamsReader::expected(const char* key, const char* what, const nlohmann::json& got) {
  refuse(key, fmt::format("expected {}, got {}", what, got.type_name()));
}

void ParamsReader::expected_word(const char* key, const std::vector<std::string>& words) {
  refuse(key, "expected " + either_of(words));
}

void ParamsReader::inside(const char* key, const Read& read) {
  ParamsReader inner(object_.at(key), pointer(key));
  read(inner);
  if (inner.error_) fail_with(*inner.error_);
}

void ParamsReader::each(const char* key, const Read& read) {
  const auto* list = member(key);
  if (list == nullptr) return;
  if (!list->is_array()) return expected(key, "an array", *list);
  for (std::size_t i = 0; i < list->size(); ++i) {
    ParamsReader inner((*list)[i], fmt::format("{}/{}", pointer(key), i));
    read(inner);
    if (inner.error_) fail_with(*inner.error_);
  }
}

const nlohmann::json* ParamsReader::find(const char* key, bool required) {
  known_.insert(key);
  if (!object_.is_object()) return nullptr;
  const auto it = object_.find(key);
  if (it != object_.end()) return &*it;
  if (required) refuse(key, "is missing");
  return nullptr;
}

const nlohmann::json* ParamsReader::member(const char* key) {
  const auto* value = find(key, false);
  return value == nullptr || value->is_null() ? nullptr : value;
}

void ParamsReader::text(const char* key, std::string& out, bool required, std::size_t most) {
  const auto* value = find(key, required);
  if (value == nullptr) return;
  if (!value->is_string()) return expected(key, "a string", *value);
  out = value->get<std::string>();
  if (most == SIZE_MAX) return;
  if (auto good = check_text(pointer(key), out, most); !good) fail_with(good.error());
}

void ParamsReader::text_or_null(const char* key, std::string& out) {
  if (member(key) != nullptr) text(key, out);
}

void ParamsReader::texts(const char* key, std::vector<std::string>& out) {
  const auto* value = member(key);
  if (value == nullptr) return;
  const auto is_text = [](const nlohmann::json& each) { return each.is_string(); };
  if (!value->is_array() || !std::ranges::all_of(*value, is_text)) {
    return expected(key, "an array of strings", *value);
  }
  out = value->get<std::vector<std::string>>();
}

void ParamsReader::integer(const char* key, std::int64_t& out, bool required) {
  const auto* value = find(key, required);
  if (value == nullptr) return;
  const bool fits = value->is_number_integer() &&
                    (!value->is_number_unsigned() ||
                     value->get<std::uint64_t>() <=
                         static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
  if (!fits) return expected(key, "a whole number", *value);
  out = value->get<std::int64_t>();
}

void ParamsReader::integer(const char* key, std::optional<std::int64_t>& out) {
  if (member(key) != nullptr) integer(key, out.emplace());
}

void ParamsReader::boolean(const char* key, bool& out) {
  const auto* value = find(key, false);
  if (value == nullptr) return;
  if (!value->is_boolean()) return expected(key, "true or false", *value);
  out = value->get<bool>();
}

void ParamsReader::number(const char* key, double& out, bool required) {
  const auto* value = find(key, required);
  if (value == nullptr) return;
  if (!value->is_number()) return expected(key, "a number", *value);
  out = value->get<double>();
}

void ParamsReader::quantity(const char* key, std::optional<double>& out, int power) {
  const auto* value = member(key);
  if (value == nullptr) return;
  if (!value->is_number()) return expected(key, "a number or null", *value);
  const double si = shift_decimal(value->get<double>(), power);
  if (!std::isfinite(si)) {
    return fail_with(Error(Errc::garbled, fmt::format("{}: beyond every number", pointer(key))));
  }
  out = si;
}

void ParamsReader::numbers(const char* key, ParameterValues& out) {
  const auto* value = member(key);
  if (value == nullptr) return;
  if (!value->is_object()) return expected(key, "an object of numbers", *value);
  for (const auto& [name, number] : value->items()) {
    if (!number.is_number() && !number.is_string()) {
      const std::string inner = std::string(key) + "/" + printable(name, 60);
      return expected(inner.c_str(), "a number", number);
    }
    if (number.is_string()) {
      out[name] = number.get<std::string>();
    } else {
      out[name] = number.get<double>();
    }
  }
}

void ParamsReader::refuse_unknown() {
  if (!object_.is_object()) return;
  for (const auto& [name, value] : object_.items()) {
    if (known_.contains(name)) continue;
    fail_with(Error(Errc::invalid_request,
                    fmt::format("{}/{}: unknown member", where_, printable(name, 60))));
  }
}

Result<> ParamsReader::finish() const {
  if (error_) return fail(*error_);
  return {};
}

}  // namespace lcrig
