// SPDX-License-Identifier: Apache-2.0
// Decides which client of the control socket gives its place to the one that comes, so that no
// number of connections can keep out a person who stops the frame. Used by ControlServer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/time.hpp"

namespace lcrig {

struct ControlPlace {
  std::uint32_t uid = 0;
  std::int32_t pid = 0;
  MonoTime came, quiet_since;  // quiet_since: its last call, or the end of its last answer
  bool busy = false;  // it watches, or a call or an answer of it is in progress
};

// Of those that are not busy, the one that has been quiet the longest, and for at least `least`.
std::optional<std::size_t> longest_idle(std::span<const ControlPlace> places, MonoTime now,
                                        Duration least);

// Among the users the one with the most places, among that user's processes the one with the most,
// of these the first that came; one that is not busy before one that is. Thus somebody else who
// holds one place keeps it, however many connections others open. `places` is not empty.
std::size_t greediest(std::span<const ControlPlace> places);

}  // namespace lcrig
