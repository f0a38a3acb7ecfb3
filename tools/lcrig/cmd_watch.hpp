// SPDX-License-Identifier: Apache-2.0
// `lcrig watch` without more words.
#pragma once

#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

// Shows the run that goes on until it ends.
Outcome<ExitCode> watch_live(Context& context);

}  // namespace lcrig::cli
