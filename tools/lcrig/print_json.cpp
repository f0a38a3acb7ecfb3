// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/print_json.hpp"

#include <nlohmann/json.hpp>

namespace lcrig::cli {

void print_json(std::ostream& out, const nlohmann::json& value) {
  out << value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

}  // namespace lcrig::cli
