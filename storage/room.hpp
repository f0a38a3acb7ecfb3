// SPDX-License-Identifier: Apache-2.0
// How much of the disk must stay free beside a planned run. The recorder refuses a run that leaves
// less, and `lcrig doctor` warns.
#pragma once

#include <cstdint>

namespace lcrig {

// For what no plan can know, such as pauses and losses of instruments.
inline constexpr std::int64_t kStaysFree_bytes = 64 << 20;

}  // namespace lcrig
