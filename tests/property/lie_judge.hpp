// SPDX-License-Identifier: Apache-2.0
// What lcrig promises on a frame that lies, held against what happened. docs/testing.md
#pragma once

#include "tests/property/trial.hpp"

namespace lcrig::property {

// Leaves its figures with the trial.
Broken lies_come_out(Trial& t, Counters& counters);

}  // namespace lcrig::property
