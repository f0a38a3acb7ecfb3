// SPDX-License-Identifier: Apache-2.0
// Values of a specimen file that can be computed with but that hardly anybody means: a unit that
// was left out, a decimal point that moved. They are questioned before they are stored.
#pragma once

#include <string>
#include <vector>

#include "model/specimen.hpp"

namespace lcrig {

// One sentence for each: the place, the value, the plausible range and what it comes from.
std::vector<std::string> implausible_values(const Specimen& specimen);

}  // namespace lcrig
