// SPDX-License-Identifier: Apache-2.0
// Prints the result of a command, as one line of JSON or as words for people, and proposes the next
// command. Used by all commands.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

// Invalid UTF-8 (in a file name or an instrument's answer) is replaced.
std::string json_line(const nlohmann::json& value);  // without the line's end
void print_json(std::ostream& out, const nlohmann::json& value);
// Prints `result`: with --json as one line, otherwise as `text` writes it.
ExitCode show(Context& context, const nlohmann::json& result,
              const std::function<void(std::ostream&)>& text);

// The command that a `next:` line proposes. Somebody will copy it and expect the same settings as
// before. It therefore has every option that affects the result, and is quoted so that the shell
// reads it as one command.
using Words = std::vector<std::string>;

// Quotes one word for a POSIX shell; what would control a terminal becomes $'...' (bash, zsh).
std::string shell_quoted(std::string_view word);

// Add the option unless `value` is empty, which means that it was not given.
void add_option(Words& words, const char* name, const std::string& value);
void add_options(Words& words, const char* name, const std::vector<std::string>& values);
void add_flag(Words& words, const char* name, bool given);

// Options that name this database and nothing else.
GlobalOptions at_database(const std::string& path);
// Options that make a rehearsal use this database. None if it uses it by default.
GlobalOptions for_rehearsal(const Context& context, const std::string& path);
// Those of the options that say where, as "--db mine.db --socket /tmp/s". "" when none was given.
std::string given_options(const GlobalOptions& global);
// "lcrig runs show 3 --db mine.db   (NOTE)" from {"runs", "show", "3"}.
std::string next_command(const GlobalOptions& global, const Words& words,
                         std::string_view note = {});

}  // namespace lcrig::cli
