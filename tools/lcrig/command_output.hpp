// SPDX-License-Identifier: Apache-2.0
// What a command prints: its result, as one line of JSON or as words for people, and the command to
// type next.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

// Bytes that are no UTF-8 (a file name, an instrument's words) are replaced.
std::string json_line(const nlohmann::json& value);  // without the line's end
void print_json(std::ostream& out, const nlohmann::json& value);
// Prints `result`: with --json as one line, else as `text` writes it.
ExitCode show(Context& context, const nlohmann::json& result,
              const std::function<void(std::ostream&)>& text);

// The command that a `next:` line proposes. Somebody copies it and expects what they asked for so
// far: it carries every option that decides what will happen, and the shell reads it as one
// command.
using Words = std::vector<std::string>;

// One word for a POSIX shell; what would steer a terminal becomes $'...', which bash and zsh know.
std::string shell_quoted(std::string_view word);

// Nothing when `value` is empty: the option was not given.
void add_option(Words& words, const char* name, const std::string& value);
void add_options(Words& words, const char* name, const std::vector<std::string>& values);
void add_flag(Words& words, const char* name, bool given);

// Options that name this database and nothing else.
GlobalOptions at_database(const std::string& path);
// Options with which a rehearsal uses this database: none, when it does anyway.
GlobalOptions for_rehearsal(const Context& context, const std::string& path);
// "--db mine.db --socket /tmp/s": of those that say where; "" when none was given.
std::string given_options(const GlobalOptions& global);
// "lcrig runs show 3 --db mine.db   (NOTE)" from {"runs", "show", "3"}.
std::string next_command(const GlobalOptions& global, const Words& words,
                         std::string_view note = {});

}  // namespace lcrig::cli
