// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/config_view.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace lcrig {

using nlohmann::json;

namespace {

constexpr std::array<std::pair<ConfigSource, std::string_view>, 3> kSources{
    {{ConfigSource::built_in, "default"},
     {ConfigSource::file, "file"},
     {ConfigSource::command_line, "command line"}}};
constexpr std::array<std::pair<ConfigEffect, std::string_view>, 3> kEffects{
    {{ConfigEffect::at_once, "at once"},
     {ConfigEffect::when_idle, "when idle"},
     {ConfigEffect::restart, "restart"}}};

template <class Table, class E>
std::string_view word_of(const Table& table, E value) {
  for (const auto& [each, word] : table) {
    if (each == value) return word;
  }
  return {};
}
template <class Table, class E>
bool parse_word(const Table& table, const json& word, E& out) {
  for (const auto& [each, text] : table) {
    if (!word.is_string() || word.get<std::string>() != text) continue;
    out = each;
    return true;
  }
  return false;
}

json json_of(const ConfigValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return nullptr;
}

std::optional<ConfigValue> value_of(const json& value) {
  if (value.is_null()) return ConfigValue();
  if (value.is_number()) return ConfigValue(value.get<double>());
  if (value.is_string()) return ConfigValue(value.get<std::string>());
  return std::nullopt;
}

std::optional<ConfigKeyView> parse_key(const json& key) {
  ConfigKeyView out;
  if (!key.is_object() || !key.contains("key") || !key["key"].is_string()) return std::nullopt;
  out.key = key["key"].get<std::string>();
  const auto value = value_of(key.value("value", json()));
  if (!value || !parse_word(kSources, key.value("source", json()), out.source)) return std::nullopt;
  out.value = *value;
  const json waiting = key.value("waiting", json());
  if (waiting.is_null()) return out;
  if (!waiting.is_object()) return std::nullopt;
  const auto later = value_of(waiting.value("value", json()));
  if (!later || !parse_word(kEffects, waiting.value("for", json()), out.effect)) {
    return std::nullopt;
  }
  out.waits = true;
  out.waiting = *later;
  return out;
}

}  // namespace

std::string to_text(const ConfigValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.12g}", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return "none";
}

std::string_view to_string(ConfigSource source) {
  return word_of(kSources, source);
}

std::string_view to_string(ConfigEffect effect) {
  return word_of(kEffects, effect);
}

json to_json(const ConfigView& view) {
  json keys = json::array();
  for (const auto& k : view.keys) {
    json key{{"key", k.key}, {"value", json_of(k.value)}, {"source", to_string(k.source)}};
    key["waiting"] = nullptr;
    if (k.waits) {
      key["waiting"] = json{{"value", json_of(k.waiting)}, {"for", to_string(k.effect)}};
    }
    keys.push_back(std::move(key));
  }
  json out{{"file", view.file}, {"of_daemon", view.of_daemon}, {"warnings", view.warnings}};
  out["refused"] = view.refused.empty() ? json(nullptr) : json(view.refused);
  out["keys"] = std::move(keys);
  return out;
}

Result<ConfigView> parse_config_view(const json& value) {
  const auto garbled = [] { return fail(Errc::garbled, "the daemon's configuration is garbled"); };
  ConfigView out;
  if (!value.is_object() || !value.contains("keys") || !value["keys"].is_array()) return garbled();
  const json file = value.value("file", json()), refused = value.value("refused", json());
  if (!file.is_string()) return garbled();
  out.file = file.get<std::string>();
  out.of_daemon = value.value("of_daemon", json()) == json(true);
  if (refused.is_string()) out.refused = refused.get<std::string>();
  for (const json& warning : value.value("warnings", json::array())) {
    if (!warning.is_string()) return garbled();
    out.warnings.push_back(warning.get<std::string>());
  }
  for (const json& each : value["keys"]) {
    auto key = parse_key(each);
    if (!key) return garbled();
    out.keys.push_back(std::move(*key));
  }
  return out;
}

}  // namespace lcrig
