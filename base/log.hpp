// SPDX-License-Identifier: Apache-2.0
// Set-up of logging to stderr, called by the programs' main(); everybody else includes this header
// to log. Under systemd each line carries the <N> priority prefix that the journal understands.
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

// How much is logged: everything first, nothing last.
inline constexpr std::array<std::string_view, 6> kLogLevels{"trace", "debug", "info",
                                                            "warn",  "error", "off"};
inline constexpr const char* kLogLevelWords = "trace, debug, info, warn, error, off";

// Returns false for any other word. Every message becomes one line of at most 4000 characters,
// escaped by `printable`.
bool set_up_logging(std::string_view level);

// Changes the level after set_up_logging, also while other threads log. False: no such word.
bool set_log_level(std::string_view level);

// While it lives, messages are written by a thread of their own: a journal, terminal or disk that
// takes nothing must not hold up the thread that runs the instruments. The newest thousand wait;
// older ones are left out, and the next line that is written says how many. One at a time.
class LogThread {
 public:
  LogThread();
  // Writes what waits, then messages are written by their own threads again. What takes longer than
  // 2 s is given up, and nothing more is logged.
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
