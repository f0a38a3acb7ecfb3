// SPDX-License-Identifier: Apache-2.0
// JSON of a value that may be missing, which is null then. Messages, rows and the command line have
// it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

namespace lcrig {

template <class T>
nlohmann::json json_or_null(const std::optional<T>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

}  // namespace lcrig
