// SPDX-License-Identifier: Apache-2.0
// Converts an optional value to JSON, with null for a missing one. Used for messages, rows and the
// command line.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace lcrig {

template <class T, class Json = nlohmann::json>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace lcrig
