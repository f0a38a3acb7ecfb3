// SPDX-License-Identifier: Apache-2.0
// Checks of a config file that depend on this computer: whether the bench, the folders and the
// socket that it names can be used. Opens no port and creates nothing. lcrigd uses it at its start,
// on a reload and for `--check-config`, and `lcrig config check` too.
#pragma once

#include <string>
#include <vector>

#include "daemon/config.hpp"

namespace lcrig {

// Errors: invalid_request with what, where and what to do next; `detail` has what else is wrong.
// `file` is the config file.
Result<> check_surroundings(const Config& config, const std::string& file);
// Mistakes that no daemon fails at, but that people will notice later.
std::vector<std::string> config_warnings(const Config& config, const std::string& file);
// The settings that the file made, a line each.
std::string config_summary(const Config& config);

}  // namespace lcrig
