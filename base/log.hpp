// SPDX-License-Identifier: Apache-2.0
// Sets up logging to stderr. The programs' main() calls it; everybody else includes this header to
// log. Under systemd each line carries the <N> priority prefix that the journal understands.
#pragma once

#include <array>
#include <memory>
#include <string_view>

namespace spdlog {
class formatter;
class logger;
namespace details {
class thread_pool;
}
}  // namespace spdlog

namespace lcrig {

// The levels, from the one that logs everything to the one that logs nothing.
inline constexpr std::array<std::string_view, 6> kLogLevels{"trace", "debug", "info",
                                                            "warn",  "error", "off"};
inline constexpr const char* kLogLevelWords = "trace, debug, info, warn, error, off";

// Returns false for any other word. Every message becomes one line of at most 4000 characters,
// escaped by `printable`.
bool set_up_logging(std::string_view level);

// Changes the level after set_up_logging, also while other threads log. False: not one of the
// words.
bool set_log_level(std::string_view level);

// While it lives, a thread of its own writes the messages, so that a stalled journal, terminal or
// disk does not hold up the thread of the instruments. The newest thousand messages wait. Older
// ones are dropped, and the next line that is written says how many. Only one may exist at a time.
class LogThread {
 public:
  LogThread();
  // Writes the waiting messages; afterwards each thread writes its own again. If that takes longer
  // than 2 s, it gives up and nothing more is logged.
  ~LogThread();
  LogThread(const LogThread&) = delete;
  LogThread& operator=(const LogThread&) = delete;

 private:
  std::shared_ptr<spdlog::logger> direct_;
  std::shared_ptr<spdlog::details::thread_pool> pool_;
};

// The format of a log line: for the journal, or with time and level for a terminal.
std::unique_ptr<spdlog::formatter> log_formatter(bool journal);

}  // namespace lcrig
