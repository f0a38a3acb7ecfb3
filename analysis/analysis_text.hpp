// SPDX-License-Identifier: Apache-2.0
// An analysis as text for a terminal.
#pragma once

#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// The two truths, beside every result.
inline constexpr const char* kOfScatter =
    "what this rig would show without noise, drift and difference of repeats";
inline constexpr const char* kOfAll =
    "the specimen's own, with what the rig may err by and what repeats may share";

std::string to_text(const RunAnalysis& analysis);
std::string to_text(const std::vector<Comparison>& comparisons);

}  // namespace lcrig
