// SPDX-License-Identifier: Apache-2.0
// How long a run has taken and how much time is left, for the live line and `lcrig status`. A step
// counts with its planned time, even when it takes longer.
#pragma once

#include <map>
#include <string>

#include "base/time.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

struct PlannedTimes {
  double total_s = 0;  // 0: unknown
  std::map<std::string, double> step_s;  // for one execution of each leaf step
  double finally_s = 0;  // for all of `finally`, which is part of the total
};

class Pace {
 public:
  // Both must outlive it.
  Pace(const Clock& clock, const PlannedTimes& planned) : clock_(clock), planned_(planned) {}

  void begin_run() { start_ = clock_.now(); }
  void begin_step(const std::string& id);
  void begin_finally();  // call it also when steps were left out
  void pass_over(const std::string& id);  // for a step that the previous run has done
  void write_to(RunProgress& progress) const;
  double planned_of(const std::string& id) const;  // one execution of a step, s
  double left_of_step_s() const;  // of the current step

 private:
  const Clock& clock_;
  const PlannedTimes& planned_;
  MonoTime start_{}, step_began_{};
  double passed_s_ = 0, step_s_ = 0;  // planned times of the steps before the current one, and of
                                      // the current one
};

}  // namespace lcrig
