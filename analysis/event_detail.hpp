// SPDX-License-Identifier: Apache-2.0
// What an event carries beside its kind.
#pragma once

#include <optional>
#include <string_view>

namespace lcrig {

// A number in a detail that is a JSON object; nullopt: none of that name.
std::optional<double> number_in(std::string_view detail, const char* key);

}  // namespace lcrig
