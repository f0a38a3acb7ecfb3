// SPDX-License-Identifier: Apache-2.0
// JSON of a value that may be missing, which is null then. Messages, rows and the command line have
// it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace lcrig {

template <class T, class Json = nlohmann::json>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace lcrig
