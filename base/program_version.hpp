// SPDX-License-Identifier: Apache-2.0
// The version of these programs, shown by each of them, stored with each run, and used for the
// Debian package. It contains the number of commits and the commit that they were built from:
// "0.1.0+870.g6009c7e12345", with ".dirty" behind it when files differed from that commit, or
// "0.1.0" when the sources come without their history. cmake/program_version.cmake writes its
// definition.
#pragma once

#include <string_view>

namespace lcrig {

std::string_view program_version();

}  // namespace lcrig
