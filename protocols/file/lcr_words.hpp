// SPDX-License-Identifier: Apache-2.0
// The words and ranges of LCR settings in a protocol file; `sample.lcr` and `set_lcr` share them.
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "base/strict_json.hpp"
#include "drivers/lcr_meter.hpp"

namespace lcrig {

inline constexpr std::array<std::pair<std::string_view, LcrFunction>, 7> kFunctionWords{{
    {"Cp-D", LcrFunction::CpD},
    {"Cp-Rp", LcrFunction::CpRp},
    {"Cs-D", LcrFunction::CsD},
    {"Cs-Rs", LcrFunction::CsRs},
    {"R-X", LcrFunction::RX},
    {"Z-thr", LcrFunction::ZThr},
    {"Z-thd", LcrFunction::ZThd},
}};
inline constexpr std::array<std::pair<std::string_view, LcrTrigger>, 2> kTriggerWords{{
    {"bus", LcrTrigger::bus},
    {"internal", LcrTrigger::internal},
}};
inline constexpr std::array<std::pair<std::string_view, Aperture>, 3> kApertureWords{{
    {"fast", Aperture::fast},
    {"medium", Aperture::medium},
    {"slow", Aperture::slow},
}};

// What any meter could do; the instrument's own limits are checked by the plan.
inline constexpr Range kFrequencyRange{1, 1e8};
inline constexpr Range kLevelRange{0, 20, true};
inline constexpr Range kBiasRange{-100, 100};
inline constexpr std::int64_t kAverageMax = 256;

}  // namespace lcrig
