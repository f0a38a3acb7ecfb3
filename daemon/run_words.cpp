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

std::string service_line(const RunStatus& s) {
  const double all_s = s.elapsed_s + s.left_s;
  auto line = fmt::format("{} {} on {}: {}", run_words(s.simulated, s.run), s.protocol, s.specimen,
                          to_string(s.state));
  if (!s.step_id.empty()) line += ", " + s.step_id;
  if (all_s > 0) {
    line += fmt::format(", {:.0f} %, {:.0f} min left", 100 * s.elapsed_s / all_s,
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
