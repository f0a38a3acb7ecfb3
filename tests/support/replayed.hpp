// SPDX-License-Identifier: Apache-2.0
// Judges a stored run again and compares the findings with those that the run recorded.
#pragma once

#include <fmt/format.h>

#include <string>

#include "daemon/replayed_watch.hpp"

namespace lcrig {

// Empty: they are the same, and everything was judged.
inline std::string replay_difference(const Database& db, std::int64_t run) {
  const auto replayed = replay_watch(db, run);
  if (!replayed) return replayed.error().what;
  std::string out = replayed->only;
  if (replayed->is_same()) return out;
  const auto list = [&out](const char* who, const std::vector<WatchFinding>& findings) {
    for (const WatchFinding& f : findings) {
      out += fmt::format("\n{} {:.3f} s {}: {}", who, to_seconds(f.at.time_since_epoch()),
                         to_string(f.kind), f.why);
    }
  };
  list("recorded", replayed->recorded);
  list("judged again", replayed->judged);
  return out;
}

}  // namespace lcrig
