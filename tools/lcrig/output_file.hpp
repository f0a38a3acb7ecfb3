// SPDX-License-Identifier: Apache-2.0
// Writes the output file of a command: whole or not at all.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "tools/lcrig/exit_code.hpp"

namespace lcrig::cli {

// As write_whole_file; a device or a pipe is written to. Failure: what the system said, naming the
// file.
Outcome<void> write_file(const std::string& path, const std::function<Result<>(int fd)>& write);
Outcome<void> write_file(const std::string& path, std::string_view content);

}  // namespace lcrig::cli
