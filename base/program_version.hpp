// SPDX-License-Identifier: Apache-2.0
// The version of these programs with the commit that they were built from: "0.1.0+g6009c7e12345",
// with ".dirty" behind it when files differed from that commit, or "0.1.0" from sources without
// their history. Shown by every program and stored with each run. cmake/program_version.cmake
// writes its definition.
#pragma once

#include <string_view>

namespace lcrig {

std::string_view program_version();

}  // namespace lcrig
