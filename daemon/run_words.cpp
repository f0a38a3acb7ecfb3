// SPDX-License-Identifier: Apache-2.0
#include "daemon/run_words.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/text.hpp"

namespace lcrig {

std::string run_words(bool simulated, std::int64_t run) {
  return fmt::format("{}run {}", simulated ? "simulated " : "", run);
}

std::string anchor_words(const std::string& anchor) {
  return anchor.empty() ? "" : " (anchor " + anchor + ")";
}

std::string orphan_line(std::int64_t run, const std::string& anchor, bool had_ended) {
  if (had_ended) {
    return fmt::format(
        "run {0} had ended, and its end was deleted from the database: its chain is cut. It is "
        "closed as interrupted, and the anchor of its end is kept ({1}). `lcrig verify {0}` tells "
        "what is missing",
        run, anchor);
  }
  return fmt::format(
      "run {0} had not ended when the last daemon died: closed as interrupted{1}; look whether its "
      "specimen is still loaded (lcrig runs show {0})",
      run, anchor_words(anchor));
}

std::string service_line(const RunStatus& s) {
  const double all_s = s.elapsed_s + s.left_s;
  auto line = fmt::format("{} {} on {}: {}", run_words(s.simulated, s.run), s.protocol, s.specimen,
                          to_string(s.state));
  if (!s.step_id.empty()) line += ", " + s.step_id;
  if (const auto alarm = alarm_words(s.standstill); !alarm.empty()) {
    return fmt::format("{}; frame: {}", line, alarm);
  }
  if (all_s > 0) {
    line += fmt::format(", {:.0f} %, ", std::floor(100 * s.elapsed_s / all_s));
    line += s.overdue && s.left_s <= 0
                ? "longer than planned"
                : fmt::format("{}{:.0f} min left", s.overdue ? "more than " : "",
                              std::ceil(s.left_s / 60));
  }
  return s.prompt.empty() ? line : line + "; waits for: " + s.prompt;
}

std::string ended_line(const RunOutcome& ended) {
  auto line = fmt::format("{} ended: {}", run_words(ended.simulated, ended.run),
                          to_string(ended.exit_status));
  if (!ended.reason.empty()) line += " " + printable(ended.reason);
  return line + anchor_words(ended.anchor);
}

}  // namespace lcrig
