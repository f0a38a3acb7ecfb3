// SPDX-License-Identifier: Apache-2.0
// The part of the manual page that cannot differ from the program: `lcrig __man`, for the build.
#pragma once

#include <string>

namespace lcrig::cli {

// Every command with its options, as scdoc source (docs/man/lcrig.1.scd).
std::string manual_of_commands();

}  // namespace lcrig::cli
