// SPDX-License-Identifier: Apache-2.0
// What of a config file only the computer can tell: whether the bench, the folders and the socket
// that it names can be used. Opens no port and creates nothing.
#pragma once

#include <string>
#include <vector>

#include "daemon/config.hpp"

namespace lcrig {

// Errors: invalid_request with what, where and what to do next; `detail` has what else is wrong.
// `file` is the config file.
Result<> check_surroundings(const Config& config, const std::string& file);
// What keeps no daemon from working, but will be missed.
std::vector<std::string> config_warnings(const Config& config, const std::string& file);
// What was taken from the file, a line each.
std::string config_summary(const Config& config);

}  // namespace lcrig
