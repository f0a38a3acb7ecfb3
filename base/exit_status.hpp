// SPDX-License-Identifier: Apache-2.0
// How a run ended. The runner decides it; the database, the control socket and the command line
// hold its word, which is part of their formats.
#pragma once

#include <optional>
#include <string_view>

#include "base/enum_words.hpp"

namespace lcrig {

// `interrupted`: its daemon died, the next one closed the run. `stopped`: it finished what it was
// asked to finish, and unloaded; the rest of the protocol was left out.
enum class ExitStatus { success, abort, fail, interrupted, stopped };
// Nothing went wrong: the specimen is unloaded, and all that was recorded is whole.
constexpr bool ended_well(ExitStatus status) {
  return status == ExitStatus::success || status == ExitStatus::stopped;
}
template <>
inline constexpr EnumWords<5> kWordsOf<ExitStatus>{"success", "abort", "fail", "interrupted",
                                                   "stopped"};
// Words for a run without an end: it goes on, or nobody records it.
inline constexpr std::string_view kRunGoesOn = "running", kRunCutOff = "cut off";
// `absent` stands for a run that has not ended.
inline std::string_view to_string(std::optional<ExitStatus> status, std::string_view absent) {
  return status ? to_string(*status) : absent;
}
// nullopt: no such word
inline std::optional<ExitStatus> parse_exit_status(std::string_view word) {
  return parse_word<ExitStatus>(word);
}

}  // namespace lcrig
