// SPDX-License-Identifier: Apache-2.0
// The room on the disk that stays free beside a planned run. The recorder refuses a run by it, and
// `lcrig doctor` warns by it.
#pragma once

#include <cstdint>

namespace lcrig {

// Has to stay free beside what is planned: for what no plan knows, such as pauses and losses.
inline constexpr std::int64_t kStaysFree_bytes = 64 << 20;

}  // namespace lcrig
