// SPDX-License-Identifier: Apache-2.0
// Checks of a config file that depend on this computer: whether the bench, the folders and the
// socket that it names can be used. Opens no port and creates nothing. Used by lcrigd at its start,
// on a reload and for `--check-config`, and by `lcrig config check`.
#pragma once

#include <string>
#include <vector>

#include "daemon/config.hpp"

namespace lcrig {

// Errors: invalid_request with what is wrong, where, and what to do next; `detail` lists further
// mistakes. `file` is the config file.
Result<> check_surroundings(const Config& config, const std::string& file);
// Mistakes that do not stop the daemon, but that people will notice later.
std::vector<std::string> config_warnings(const Config& config, const std::string& file);
// The settings from the file, one per line.
std::string config_summary(const Config& config);

}  // namespace lcrig
