// SPDX-License-Identifier: Apache-2.0
// The line that shows a run or a rehearsal while it goes on. Other commands use its formats of
// times.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/time.hpp"
#include "protocols/run/sink.hpp"
#include "tools/lcrig/console.hpp"

namespace lcrig::cli {

// At most `width` - 1 printable ASCII characters (a full last column would wrap), without escape
// codes and newline. Parts that do not fit are left out, the least important first.
std::string format_live_line(const RunStatus& status, int width);
// For logs and pipes: all parts, without a bar.
std::string format_plain_line(const RunStatus& status);
// format_time: "3:05", "1:02:07". format_fixed: `digits` behind the point, and no "-0".
std::string format_fixed(double value, int digits);
std::string format_time(double seconds);
// ", 26 more are not proven"; empty: there are none.
std::string unproven_words(std::int64_t readings);

// On a terminal it is one line, rewritten at most 20 times a second. Elsewhere it prints a line at
// each new step, state or prompt, and otherwise at most one a second.
class LiveLine {
 public:
  LiveLine(Console& console, const Clock& clock) : console_(console), clock_(clock) {}
  void show(const RunStatus& status);
  // Prints a text above the line.
  void say(const std::string& text);
  void say_one_line(const std::string& text);  // on a terminal cut to the width of its line
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
  Standstill last_standstill_ = Standstill::not_asked;
};

}  // namespace lcrig::cli
