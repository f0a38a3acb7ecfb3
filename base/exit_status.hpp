// SPDX-License-Identifier: Apache-2.0
// How a run ended. The runner decides it. Its words are part of the formats of the database, the
// control socket and the command line.
#pragma once

#include <optional>
#include <string_view>

#include "base/enum_words.hpp"

namespace lcrig {

// `interrupted`: the daemon died, and the next one closed the run. `stopped`: a person asked the
// run to end early; it completed the part that was asked for and unloaded.
enum class ExitStatus { success, abort, fail, interrupted, stopped };
// True when nothing went wrong: the specimen is unloaded and the record is complete.
constexpr bool ended_well(ExitStatus status) {
  return status == ExitStatus::success || status == ExitStatus::stopped;
}
template <>
inline constexpr EnumWords<5> kWordsOf<ExitStatus>{"success", "abort", "fail", "interrupted",
                                                   "stopped"};
// Words for a run that has not ended: it still runs, or its recorder is gone.
inline constexpr std::string_view kRunGoesOn = "running", kRunCutOff = "cut off";
// `absent` is the word for a run that has not ended.
inline std::string_view to_string(std::optional<ExitStatus> status, std::string_view absent) {
  return status ? to_string(*status) : absent;
}

}  // namespace lcrig
