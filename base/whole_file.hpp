// SPDX-License-Identifier: Apache-2.0
// A file that is there whole or not at all, whoever reads it and whenever the power fails.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

// `write` fills a new file beside `path` (NAME.PID-N.part), which then takes its name. A file that
// a crash left behind is not in the way, and a link that somebody put there is not followed.
// Errors: what `write` said, or io with the path; nothing is left behind.
Result<> write_whole_file(const std::string& path, const std::function<Result<>(int fd)>& write);
Result<> write_whole_file(const std::string& path, std::string_view text);

// All of it, to a descriptor of the file `path`. Errors: io with the path.
Result<> write_text(int fd, const std::string& path, std::string_view text);

}  // namespace lcrig
