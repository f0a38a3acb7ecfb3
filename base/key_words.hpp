// SPDX-License-Identifier: Apache-2.0
// Proposes the known key that an unknown key probably stands for. It never guesses the unit at the
// end of a key: a file with 200 kPa instead of 200 Pa looks correct and would be run. Used by the
// readers of files and by the command line.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace lcrig {

// The known key that `key` mistypes, if it has the same unit.
std::optional<std::string> nearest_key(std::string_view key, std::span<const std::string> known);
// "`force_lbf`: `_lbf` is no unit of force; it takes force_mN, force_N, force_kN", when the unit of
// `key` is missing or wrong.
std::optional<std::string> unit_mistake(std::string_view key, std::span<const std::string> known);

// For a name that the file itself chooses: "`speed_cm_s`: `_cm_s` is no unit of speed; there are
// _um_s, _mm_s, _mm_min, _m_s". nullopt: the name ends in a known unit, or in none.
std::optional<std::string> name_unit_mistake(std::string_view name);

}  // namespace lcrig
