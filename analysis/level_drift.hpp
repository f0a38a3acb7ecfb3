// SPDX-License-Identifier: Apache-2.0
// Finds a change of C that goes one way while the load is held, in the levels of a run: creep or
// relaxation. Without it the first readings of a creeping level would pass for outliers. Private to
// analysis/.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// Kendall's rank statistic of a trend, in standard deviations of chance (Biometrika 30 (1938) 81).
// An outlier changes it by little. Precondition: two values.
double rank_trend(const std::vector<double>& values);

struct LevelSeries {
  Direction direction = Direction::up;
  std::vector<double> fF;  // the readings that count, in the order of time
};

class LevelDrift {
 public:
  // Judges the levels of each direction together. `widening`: factor by which the correlation of
  // readings without a load makes a standard error larger; counts where there are few levels.
  LevelDrift(const std::vector<LevelSeries>& levels, double widening);

  // Whether the level has a drift that is more than chance.
  bool drifts(std::size_t level) const { return !drift_fF_[level].empty(); }
  // The drift of a reading, relative to that of the middle of its level. Precondition: drifts().
  double at(std::size_t level, std::size_t reading) const { return drift_fF_[level][reading]; }
  // From the first to the last reading of the level; 0: it does not drift.
  double change_fF(std::size_t level) const;

 private:
  std::vector<std::vector<double>> drift_fF_;  // empty: no drift
};

}  // namespace lcrig
