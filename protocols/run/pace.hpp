// SPDX-License-Identifier: Apache-2.0
// How long a run has taken and how long it will take: the live line and `lcrig status` show it. A
// step counts with its planned time, also when it takes longer.
#pragma once

#include <map>
#include <string>

#include "base/time.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct PlannedTimes {
  double total_s = 0;  // 0: not known
  std::map<std::string, double> step_s;  // of one pass of each leaf step
  double finally_s = 0;  // of all of `finally`, which is part of the total
};

class Pace {
 public:
  // Both outlive it.
  Pace(const Clock& clock, const PlannedTimes& planned) : clock_(clock), planned_(planned) {}

  void begin_run() { start_ = clock_.now(); }
  void begin_step(const std::string& id);
  void begin_finally();  // also when steps were left out
  void pass_over(const std::string& id);  // a step that the run before this one has done
  void write_to(RunProgress& progress) const;
  double planned_of(const std::string& id) const;  // one pass of a step, s
  double left_of_step_s() const;  // of the present one

 private:
  const Clock& clock_;
  const PlannedTimes& planned_;
  MonoTime start_{}, step_began_{};
  double passed_s_ = 0, step_s_ = 0;  // planned: before the present step, and for it
};

}  // namespace lcrig
