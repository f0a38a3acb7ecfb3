// SPDX-License-Identifier: Apache-2.0
// What became of each lie in a sweep: the figures of docs/promises.md.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/property/falsehood.hpp"

namespace lcrig::property {

struct LieFigures {
  std::int64_t told = 0;  // it began while a run went on
  std::int64_t contradicted = 0;  // and showed, for long enough
  std::int64_t noticed = 0;  // of those: STOP went out in time, the run failed
  std::vector<double> to_stop_s;  // from the arrival of the first sample that contradicts
  double worst_of_limit = 0;  // true force, part of the limit
  double worst_of_bound = 0;  // part of what time, speed and stiffness allow
  std::uint64_t worst_seed = 0;
};

class LieTable {
 public:
  LieFigures& of(FrameLie lie) { return rows_[lie]; }
  void add(const LieTable& more);
  // DIR/NAME.json, if LCRIG_SWEEP says where; a row of Markdown each to standard error, if verbose.
  void write(const std::string& name) const;

 private:
  std::map<FrameLie, LieFigures> rows_;
};

}  // namespace lcrig::property
