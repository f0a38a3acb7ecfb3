// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/places.hpp"

#include <tuple>

namespace lcrig {

std::optional<std::size_t> longest_idle(std::span<const ControlPlace> places, MonoTime now,
                                        Duration least) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].busy || now - places[i].quiet_since < least) continue;
    if (!found || places[i].quiet_since < places[*found].quiet_since) found = i;
  }
  return found;
}

std::size_t greediest(std::span<const ControlPlace> places) {
  const auto rank = [places](const ControlPlace& place) {
    std::size_t of_user = 0, of_process = 0;
    for (const ControlPlace& other : places) {
      of_user += other.uid == place.uid ? 1 : 0;
      of_process += other.uid == place.uid && other.pid == place.pid ? 1 : 0;
    }
    return std::tuple(of_user, of_process, !place.busy, -place.came.time_since_epoch());
  };
  std::size_t found = 0;
  auto highest = rank(places[0]);
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto own = rank(places[i]);
    if (own <= highest) continue;
    found = i;
    highest = own;
  }
  return found;
}

}  // namespace lcrig
