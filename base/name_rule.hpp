// SPDX-License-Identifier: Apache-2.0
// Which names of specimens, benches and protocols can be typed again: every command that takes a
// name, and every "next:" line that prints one, must read it back. Every file that is brought in
// has to keep the rule; names that are stored already are read as they are.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

inline constexpr std::size_t kLongestName = 60;  // characters; tables and messages cut longer ones

// What is wrong with the name, as "found, expected"; nullopt: it can be read back.
std::optional<std::string> why_no_name(std::string_view name);

}  // namespace lcrig
