// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/config_view.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/control/fields.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

void value_field(FieldWriter& f, const ConfigValue& value) {
  const auto* number = std::get_if<double>(&value);
  const auto* text = std::get_if<std::string>(&value);
  f.put("value", number != nullptr ? json(*number) : text != nullptr ? json(*text) : json());
}

void value_field(ParamsReader& in, ConfigValue& value) {
  const json* found = in.member("value");
  if (found == nullptr) return;
  if (found->is_number()) {
    value = found->get<double>();
  } else if (found->is_string()) {
    value = found->get<std::string>();
  } else {
    in.refuse("value", "expected a number, a string or null");
  }
}

}  // namespace

std::string to_text(const ConfigValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.12g}", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return "none";
}

template <class F>
void fields(F& f, Of<F, WaitingValue>& w) {
  value_field(f, w.value);
  f.word("for", w.effect, true);
}

template <class F>
void fields(F& f, Of<F, ConfigKeyView>& k) {
  f.text("key", k.key, true);
  value_field(f, k.value);
  f.word("source", k.source, true);
  f.object("waiting", k.waiting);
}

template <class F>
void fields(F& f, Of<F, ConfigView>& v) {
  f.text("file", v.file, true);
  f.boolean("of_daemon", v.of_daemon);
  f.text_or_null("refused", v.refused);
  f.texts("warnings", v.warnings);
  f.list("keys", v.keys);
}

json to_json(const ConfigView& view) {
  return written(view);
}

Result<ConfigView> parse_config_view(const json& value) {
  return read_answer<ConfigView>(value);
}

}  // namespace lcrig
