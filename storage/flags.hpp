// SPDX-License-Identifier: Apache-2.0
// The bits of the `flags` columns and the words that exports show for them. They are part of the
// schema: bits are added, never reused. daemon/record/batch.cpp asserts that they equal the
// constants in drivers/.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace lcrig {

// Indexed by bit number.
constexpr std::array<std::string_view, 5> kLcrFlagWords{
    "overload_primary", "overload_secondary", "after_resync", "after_set_up", "after_gap"};
constexpr std::array<std::string_view, 4> kFrameFlagWords{"moving", "force_control",
                                                          "force_overload", "after_gap"};
constexpr std::int64_t kFrameAfterGap = 1 << 3;

}  // namespace lcrig
