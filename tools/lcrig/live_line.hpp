// SPDX-License-Identifier: Apache-2.0
// The line that shows a run while it goes on.
#pragma once

#include <optional>
#include <string>

#include "base/time.hpp"
#include "protocols/run/sink.hpp"
#include "tools/lcrig/console.hpp"

namespace lcrig::cli {

// At most `width` - 1 printable ASCII characters (a full last column would wrap), no escape codes,
// no newline. What does not fit is left out, the least important part first.
std::string format_live_line(const RunStatus& status, int width);
// For logs and pipes: all parts, no bar.
std::string format_plain_line(const RunStatus& status);
// "3:05", "1:02:07"
// With `digits` behind the point; nothing is less than zero by less than they show.
std::string format_fixed(double value, int digits);
std::string format_time(double seconds);

// On a terminal one line that is rewritten at most 20 times a second; elsewhere a line at each new
// step, state or prompt, and else at most one a second.
class LiveLine {
 public:
  LiveLine(Console& console, const Clock& clock) : console_(console), clock_(clock) {}
  void show(const RunStatus& status);
  // Something to read above the line.
  void say(const std::string& text);
  void say_one_line(const std::string& text);  // on a terminal no longer than its line
  void finish();  // leaves the cursor at the start of an empty line

 private:
  bool due(const RunStatus& status);
  void show_prompt(const RunStatus& status);

  Console& console_;
  const Clock& clock_;
  std::optional<MonoTime> last_;
  std::string last_step_, last_prompt_, drawn_;
  std::int64_t last_repeat_ = 0;
  RunState last_state_ = RunState::preparing;
};

}  // namespace lcrig::cli
