// SPDX-License-Identifier: Apache-2.0
// The ranges of LCR settings in a protocol file; `sample.lcr` and `set_lcr` share them.
#pragma once

#include <cstdint>

#include "base/range.hpp"

namespace lcrig {

// Ranges that any meter could have; the plan checks the limits of the instrument itself.
inline constexpr Range kFrequencyRange{1, 1e8};
inline constexpr Range kLevelRange{0, 20, true};
inline constexpr Range kBiasRange{-100, 100};
inline constexpr std::int64_t kAverageMax = 256;

}  // namespace lcrig
