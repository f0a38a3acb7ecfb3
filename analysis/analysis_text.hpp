// SPDX-License-Identifier: Apache-2.0
// An analysis as text for a terminal.
#pragma once

#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

std::string to_text(const RunAnalysis& analysis);
std::string to_text(const std::vector<Comparison>& comparisons);

}  // namespace lcrig
