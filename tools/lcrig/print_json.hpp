// SPDX-License-Identifier: Apache-2.0
// Prints the result of a command that reads: one line of JSON, or words for people.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

// Bytes that are no UTF-8 (a file name, an instrument's words) are replaced.
std::string json_line(const nlohmann::json& value);  // without the line's end
void print_json(std::ostream& out, const nlohmann::json& value);
// Prints `result`: with --json as one line, else as `text` writes it.
ExitCode show(Context& context, const nlohmann::json& result,
              const std::function<void(std::ostream&)>& text);

}  // namespace lcrig::cli
