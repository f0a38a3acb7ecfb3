// SPDX-License-Identifier: Apache-2.0
#include "analysis/event_detail.hpp"

#include <nlohmann/json.hpp>

namespace lcrig {

std::optional<double> number_in(std::string_view detail, const char* key) {
  const auto j = nlohmann::json::parse(detail, nullptr, false);
  if (!j.is_object()) return std::nullopt;
  const auto it = j.find(key);
  if (it == j.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

}  // namespace lcrig
