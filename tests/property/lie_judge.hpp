// SPDX-License-Identifier: Apache-2.0
// Compares what lcrig promises about a frame that lies with what happened (docs/testing.md). Used
// by the tests of lies and of stored cases.
#pragma once

#include "tests/property/trial.hpp"

namespace lcrig::property {

// Also stores the figures in the trial.
Broken lies_come_out(Trial& t, Counters& counters);

}  // namespace lcrig::property
