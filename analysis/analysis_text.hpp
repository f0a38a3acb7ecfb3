// SPDX-License-Identifier: Apache-2.0
// Formats an analysis as text for the terminal, for `lcrig analyze`.
#pragma once

#include <string>

#include "analysis/analysis.hpp"

namespace lcrig {

// What each of the two intervals promises to contain; printed beside the results.
inline constexpr const char* kOfScatter =
    "what this rig would show without noise, drift and difference of repeats";
inline constexpr const char* kOfAll =
    "the specimen's own, with what the rig may err by and what repeats may share";

std::string to_text(const RunAnalysis& analysis);

}  // namespace lcrig
