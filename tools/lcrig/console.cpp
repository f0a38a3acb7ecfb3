// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/console.hpp"

#include <fmt/ostream.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <iostream>

#include "base/text.hpp"

namespace lcrig::cli {

void Console::print(const Failure& failure) {
  constexpr std::size_t kLongest = 2 * kLongestWords;
  const char* red = color ? "\x1b[31m" : "";
  const char* plain = color ? "\x1b[0m" : "";
  fmt::print(err, "{}lcrig: {}{}\n", red, printable(failure.what, kLongest), plain);
  for (std::string_view rest = failure.detail; !rest.empty();) {
    const auto line = rest.substr(0, rest.find('\n'));
    fmt::print(err, "  {}\n", printable(line, kLongest));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
  }
  if (!failure.next.empty()) next(failure.next);
  err.flush();
}

void Console::next(std::string_view command) {
  fmt::print(err, "  next: {}\n", printable(command, 2 * kLongestWords));
}

void Console::note(std::string_view words) {
  fmt::print(err, "lcrig: {}\n", printable(words, 2 * kLongestWords));
  err.flush();
}

std::optional<std::string> Console::wait_for_line(std::string_view words) {
  err << words;
  err.flush();
  return enter ? enter() : std::nullopt;
}

void Console::print_file(std::string_view text) {
  if (out_tty) {
    out << printable_lines(text);
  } else {
    out << text;
  }
  if (!text.ends_with('\n')) out << '\n';
}

namespace {
int terminal_width() {
  constexpr int kUnknown = 80;
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUnknown;
  return size.ws_col;
}
}  // namespace

Console real_console(const ProcessEnv& env) {
  Console console(std::cout, std::cerr);
  console.in_tty = ::isatty(STDIN_FILENO) == 1;
  const auto term = env.get("TERM");
  console.out_tty = ::isatty(STDOUT_FILENO) == 1;
  console.err_tty = ::isatty(STDERR_FILENO) == 1 && term != "dumb";
  console.color = console.err_tty && !env.get("NO_COLOR");
  console.width = terminal_width;
  console.enter = []() -> std::optional<std::string> {
    std::string line;
    if (!std::getline(std::cin, line)) return std::nullopt;
    return line;
  };
  return console;
}

}  // namespace lcrig::cli
