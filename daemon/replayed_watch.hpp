// SPDX-License-Identifier: Apache-2.0
// Reads a stored run and judges it again with the watch of this program (`lcrig watch replay`).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocols/run/watch_replay.hpp"
#include "storage/database.hpp"

namespace lcrig {

struct ReplayedWatch {
  std::int64_t run = 0, samples = 0, inputs = 0;
  // Why only the limits of the force were judged, and up to where; empty: everything was judged.
  std::string only;
  std::vector<WatchFinding> recorded;  // what the watch of the run found in its samples
  std::vector<WatchFinding> judged;  // what this one finds
  MonoTime started;
  bool is_same() const { return recorded == judged; }
};

// Force against travel of one motion towards the specimen, with its corridor: the motion in which a
// sample left it, else that with the largest force.
struct WatchedMotion {
  struct Point {
    double travel_mm = 0, force_N = 0;
    std::optional<double> low_N, high_N;  // edges of the corridor
  };
  std::vector<Point> points;
  std::optional<std::size_t> outside;  // the point in which a check found something
};

// Errors: not_found (no such run), garbled (an event that this program cannot read), io.
Result<ReplayedWatch> replay_watch(const Database& db, std::int64_t run);
// nullopt: no motion presses, or its orders were not stored.
Result<std::optional<WatchedMotion>> watched_motion(const Database& db, std::int64_t run);

}  // namespace lcrig
