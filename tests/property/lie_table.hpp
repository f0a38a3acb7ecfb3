// SPDX-License-Identifier: Apache-2.0
// What became of each lie in a sweep, for the figures of docs/promises.md. Each Trial keeps such a
// table, and lies_test.cpp adds them up.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/property/falsehood.hpp"

namespace lcrig::property {

struct LieFigures {
  std::int64_t told = 0;  // the lie began during a run
  std::int64_t contradicted = 0;  // of these: it was visible for long enough
  std::int64_t noticed = 0;  // of these: STOP was sent in time and the run failed
  std::vector<double> to_stop_s;  // from the arrival of the first contradicting sample
  double worst_of_limit = 0;  // true force over the limit
  double worst_of_bound = 0;  // true force over that which time, speed and stiffness allow
  std::uint64_t worst_seed = 0;
};

class LieTable {
 public:
  LieFigures& of(FrameLie lie) { return rows_[lie]; }
  void add(const LieTable& more);
  // Writes DIR/NAME.json if LCRIG_SWEEP is DIR, and rows of Markdown to standard error if
  // LCRIG_VERBOSE is set.
  void write(const std::string& name) const;

 private:
  std::map<FrameLie, LieFigures> rows_;
};

}  // namespace lcrig::property
