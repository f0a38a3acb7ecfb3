// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>

namespace lcrig::cli {

// One line. Bytes that are no UTF-8 (a file name, an instrument's words) are replaced.
void print_json(std::ostream& out, const nlohmann::json& value);

}  // namespace lcrig::cli
