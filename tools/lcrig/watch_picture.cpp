// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/watch_picture.hpp"

#include <limits>

#include "daemon/replayed_watch.hpp"

namespace lcrig::cli {

std::optional<WatchPicture> watch_picture(const Database& db, std::int64_t run) {
  const auto motion = watched_motion(db, run);
  if (!motion || !*motion) return std::nullopt;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  WatchPicture out;
  for (const WatchedMotion::Point& p : (*motion)->points) {
    out.travel_mm.push_back(p.travel_mm);
    out.force_N.push_back(p.force_N);
    out.low_N.push_back(p.low_N.value_or(kNone));
    out.high_N.push_back(p.high_N.value_or(kNone));
  }
  out.outside = (*motion)->outside;
  return out;
}

}  // namespace lcrig::cli
