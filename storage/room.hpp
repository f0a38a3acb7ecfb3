// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace lcrig {

// Has to stay free beside what is planned: for what no plan knows, such as pauses and losses.
inline constexpr std::int64_t kStaysFree_bytes = 64 << 20;

}  // namespace lcrig
