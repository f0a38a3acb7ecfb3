// SPDX-License-Identifier: Apache-2.0
// Writes the output file of a command, whole or not at all. Used by reports, budgets, pictures and
// the bundle of `lcrig doctor`.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "tools/lcrig/exit_code.hpp"

namespace lcrig::cli {

// How each kind of output begins. A file without this mark is not replaced.
inline constexpr const char* kPageMark = "<meta name='generator' content='lcrig ";
inline constexpr const char* kPictureMark = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 ";
inline constexpr const char* kTableMark = "run,specimen,protocol,simulated,exit_status,";

// Failure: replacing the file would lose something else (require_earlier_output).
Outcome<void> require_replaceable(const std::string& path, const char* mark);

// As write_whole_file, but a device or a pipe is written to directly. Failure: as
// require_replaceable, or an error of the system that names the file.
Outcome<void> write_file(const std::string& path, const char* mark,
                         const std::function<Result<>(int fd)>& write);
Outcome<void> write_file(const std::string& path, const char* mark, std::string_view content);

}  // namespace lcrig::cli
