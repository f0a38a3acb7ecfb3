// SPDX-License-Identifier: Apache-2.0
// How a run ended. The runner decides it; the database, the control socket and the command line
// hold its word, which is part of their formats.
#pragma once

#include <optional>
#include <string_view>

namespace lcrig {

// `interrupted`: its daemon died, the next one closed the run.
enum class ExitStatus { success, abort, fail, interrupted };
std::string_view to_string(ExitStatus status);
// `absent` stands for a run that has not ended.
std::string_view to_string(std::optional<ExitStatus> status, std::string_view absent);
std::optional<ExitStatus> parse_exit_status(std::string_view word);  // nullopt: no such word

}  // namespace lcrig
