// SPDX-License-Identifier: Apache-2.0
// The version of these programs with the commit that they were built from, and how many commits led
// to it: "0.1.0+870.g6009c7e12345", with ".dirty" behind it when files differed from that commit,
// or "0.1.0" from sources without their history. Shown by every program, stored with each run, and
// the version of the Debian package. cmake/program_version.cmake writes its definition.
#pragma once

#include <string_view>

namespace lcrig {

std::string_view program_version();

}  // namespace lcrig
