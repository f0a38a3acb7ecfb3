// SPDX-License-Identifier: Apache-2.0
// Walks through a protocol for make_plan: visits the steps in the order of execution, sums their
// times, and keeps the first refusal. The effect of each step on the rig is in protocols/steps.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "protocols/plan/planned_rig.hpp"
#include "protocols/stop_places.hpp"

namespace lcrig {

class Planner {
 public:
  // All references must outlive it. `plan` contains the settings of the meter; the walk fills in
  // the rest.
  Planner(const Protocol& protocol, Environment& environment, const Rig& rig,
          const BoundLimits& limits, Plan& plan);
  void walk();
  const std::optional<PlanRefused>& refused() const { return refused_; }

 private:
  void check_start();
  void check_limits();
  void check_channels();
  bool walk_steps(const Steps& steps, bool in_finally);
  StepPlan visit(const Step& step);
  void count_places(const StepCursor& cursor, const Step& step);
  void account(const Step& step, const StepPlan& adds, bool in_finally);
  std::vector<Change> possible_frequency() const;
  void refuse(const std::string& pointer, const std::string& id, Refusal refusal);
  void finish_figures();
  void foresee_lies();

  const Protocol& protocol_;
  Environment& environment_;
  Plan& plan_;
  PlannedRig rig_;
  std::optional<PlanRefused> refused_;
  std::map<std::string, std::size_t> row_of_;  // step id -> index in plan_.steps
  std::int64_t visits_ = 0;
  StopPlaces places_;
};

}  // namespace lcrig
