// SPDX-License-Identifier: Apache-2.0
// Random numbers for a disturbance, and the instant in a run at which it begins. Used by cases.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "tests/support/rig_world.hpp"

namespace lcrig::property {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double even(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11U) * 0x1p-53);
  }
  double scale(double low, double high) { return low * std::pow(high / low, even(0, 1)); }
  std::int64_t below(std::int64_t n) {
    return std::min(n - 1, static_cast<std::int64_t>(even(0, static_cast<double>(n))));
  }

 private:
  std::mt19937_64 random_;
};

struct Instant {
  Instant() = default;
  RigWorld::Act::When when = RigWorld::Act::When::time;
  std::int64_t n = 0;
  double after_s = 0;
  double lasts_s = 0;  // 0: to the end
};

// During preparation, at any time, soon after a change of the drive, or in `finally`.
inline void draw_instant(Dice& dice, Instant& at) {
  using When = RigWorld::Act::When;
  switch (dice.below(5)) {
    case 0: at.when = When::time, at.after_s = dice.even(0, 2.5); return;
    case 1: at.when = When::part, at.after_s = dice.even(0, 1); return;
    case 2: at.when = When::finally, at.after_s = dice.even(0, 1) * dice.even(0, 1); return;
    default: break;
  }
  at.when = When::drive;
  at.n = dice.below(12);
  at.after_s = dice.even(0, 1) * dice.even(0, 1) * 2;
}

}  // namespace lcrig::property
