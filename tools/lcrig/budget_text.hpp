// SPDX-License-Identifier: Apache-2.0
// Shows a budget as JSON, table and picture, for `lcrig budget`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "budget/search.hpp"

namespace lcrig::cli {

nlohmann::json to_json(const Budget& budget);
std::string to_table(const Budget& budget);
std::string to_svg(const Budget& budget, const std::string& title);

}  // namespace lcrig::cli
