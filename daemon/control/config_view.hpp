// SPDX-License-Identifier: Apache-2.0
// The configuration as `lcrig config` shows it: each key that applies, its value, and the source of
// the value. It describes a file, or the running daemon, which may still use an older file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/enum_words.hpp"
#include "base/result.hpp"

namespace lcrig {

using ConfigValue = std::variant<std::monostate, double, std::string>;  // monostate: no value
std::string to_text(const ConfigValue& value);

enum class ConfigSource { built_in, file, command_line };
template <>
inline constexpr EnumWords<3> kWordsOf<ConfigSource>{"default", "file", "command line"};

// When a change of the file takes effect.
enum class ConfigEffect { at_once, when_idle, restart };
template <>
inline constexpr EnumWords<3> kWordsOf<ConfigEffect>{"at once", "when idle", "restart"};

// A value in the file that the daemon has not applied yet.
struct WaitingValue {
  ConfigValue value;
  ConfigEffect effect = ConfigEffect::at_once;
};

struct ConfigKeyView {
  std::string key;  // "frame.stiffness_N_mm"
  ConfigValue value;
  ConfigSource source = ConfigSource::built_in;
  std::optional<WaitingValue> waiting;  // set when the file has another value
};

struct ConfigView {
  std::string file;
  bool of_daemon = false;  // true: in force in the daemon; false: in the file
  std::string refused;  // why the daemon refused the file when it last read it; empty: it did not
  std::vector<std::string> warnings;
  std::vector<ConfigKeyView> keys;
};
nlohmann::json to_json(const ConfigView& view);
Result<ConfigView> parse_config_view(const nlohmann::json& value);

// Checks a file as `lcrigd --check-config` does (daemon/config_check.cpp), with the same errors.
Result<ConfigView> look_at_config_file(const std::string& file);

}  // namespace lcrig
