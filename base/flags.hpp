// SPDX-License-Identifier: Apache-2.0
// The bits of the `flags` columns, which drivers set, and the words that exports show for them.
// They are part of the schema: bits are added, never reused.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace lcrig {

namespace lcr_flag {
constexpr std::uint32_t kPrimaryOverload = 1U << 0U;  // primary is NULL
constexpr std::uint32_t kSecondaryOverload = 1U << 1U;  // secondary is NULL
constexpr std::uint32_t kAfterResync = 1U << 2U;  // first reading after the line was resynchronised
constexpr std::uint32_t kAfterSetUp = 1U << 3U;  // first reading after the driver repeated the
                                                 // set-up, because the meter had become slow
constexpr std::uint32_t kAfterGap = 1U << 4U;  // first reading after the meter was lost
constexpr std::uint32_t kOutOfRange = 1U << 5U;  // a value that the meter cannot have measured
}  // namespace lcr_flag

namespace frame_flag {
constexpr std::uint32_t kMoving = 1U << 0U;
constexpr std::uint32_t kForceControl = 1U << 1U;
constexpr std::uint32_t kForceOverload = 1U << 2U;  // beyond the load cell's range: force_N is
                                                    // empty
constexpr std::uint32_t kAfterGap = 1U << 3U;  // samples that the device sent before this one are
                                               // missing
}  // namespace frame_flag

// Indexed by bit number.
constexpr std::array<std::string_view, 6> kLcrFlagWords{"overload_primary", "overload_secondary",
                                                        "after_resync",     "after_set_up",
                                                        "after_gap",        "out_of_range"};
constexpr std::array<std::string_view, 4> kFrameFlagWords{"moving", "force_control",
                                                          "force_overload", "after_gap"};

}  // namespace lcrig
