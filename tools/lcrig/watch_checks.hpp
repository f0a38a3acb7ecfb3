// SPDX-License-Identifier: Apache-2.0
// The table of the checks of the frame, and the constants behind their tolerances, for `lcrig watch
// checks` and docs/watch.md.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lcrig::cli {

// Two tables in Markdown.
std::string checks_text();
nlohmann::json checks_json();

}  // namespace lcrig::cli
