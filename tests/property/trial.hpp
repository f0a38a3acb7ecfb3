// SPDX-License-Identifier: Apache-2.0
// Carries out a case and compares what happened with what was promised. Used by sweeps and by the
// judge of lies.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/property/case.hpp"
#include "tests/property/lie_table.hpp"

namespace lcrig::property {

// How often each named situation occurred.
using Counters = std::map<std::string, std::int64_t>;

class Trial {
 public:
  explicit Trial(Case c);
  void run();
  // Only plans the run, with these values of parameters.
  void plan_only(ParameterValues parameters);

  const Case& what() const { return case_; }
  RigWorld& world() { return *world_; }
  const RigWorld& world() const { return *world_; }
  const sim::RandomRig& rig() const { return rig_; }
  double limit_N() const { return limit_N_; }
  bool is_accepted() const { return !world_->refused; }
  // Conditional: accepted on the condition that the stiffness measured at contact allows it.
  // Declined: that stiffness did not allow it.
  bool is_conditional() const;
  bool is_declined() const;
  // The truth lies within what was told of the rig.
  bool is_honest() const;
  double uncertainty_N() const;  // as the plan prints it
  void count(Counters& counters) const;
  // When each lie of the case began and ended.
  struct Told {
    std::optional<MonoTime> from, to;
  };
  const std::vector<Told>& told() const { return told_; }
  LieTable lie_figures;  // set when the trial is judged

 private:
  Case case_;
  sim::RandomRig rig_;
  double limit_N_ = 0;
  std::unique_ptr<RigWorld> world_;
  std::vector<Told> told_;
};

// Each function returns what was broken; empty: nothing. The words before the colon name the kind.
using Broken = std::vector<std::string>;
Broken force_within_limit(Trial& t);
Broken travel_within_limits(Trial& t);
Broken stiffness_is_not_underestimated(Trial& t);
Broken healthy_runs_succeed(Trial& t);
Broken finishes_what_is_under_way(Trial& t);
Broken ends_standing_and_honest(Trial& t);
Broken nothing_moves_after_the_stop(Trial& t);
Broken lost_within_the_second_figure(Trial& t);
Broken lies_are_not_pressed_again(Trial& t);
Broken refused_and_nothing_moved(Trial& t);
// Follows the advice of refusals until the plan is accepted or says that nothing helps.
Broken advice_is_good(const Case& c, Counters& counters);

}  // namespace lcrig::property
