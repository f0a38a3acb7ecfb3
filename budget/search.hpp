// SPDX-License-Identifier: Apache-2.0
// Weighs speed against error: tries every setting of the meter, and finds how much measuring each
// needs. `lcrig budget` and `lcrig rehearse --batch` use it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "budget/planned_run.hpp"
#include "budget/prediction.hpp"

namespace lcrig {

// One way to do the experiment.
struct BudgetPoint {
  Aperture aperture = Aperture::medium;
  double frequency_Hz = 0;
  std::map<std::string, double> parameters;  // other than asked for, in the unit of the name
  bool follows = true;  // the protocol with these parameters is planned exactly like this
  std::string refused;  // why it cannot be done or predicted; empty: the rest is filled
  std::string note;
  bool noise_guessed = false;
  double duration_s = 0;
  std::int64_t readings = 0;  // of `measure` steps; without such, all that are recorded
  std::vector<Prediction> predictions;
  double worst = 0;  // largest relative standard error of the predictions
  double worst_half_width = 0;  // relative, of the interval that `analyze` is expected to print
  double worst_expanded = 0;  // relative, with the systematic parts
  int repeats = 0;  // fewest that one of the predictions is made of
  std::vector<std::string> not_predicted;  // results: they can never be said to meet a target
  // One repeat tells nothing of what differs between repeats: no interval of it can be promised.
  bool tells_repeats() const { return repeats >= 2; }
  bool meets(double target) const {
    return possible() && not_predicted.empty() && tells_repeats() && worst_half_width <= target;
  }
  bool front = false;  // no other point is both quicker and better
  bool possible() const { return refused.empty(); }
};

struct BudgetSetting {  // aperture and frequency
  BudgetPoint planned;  // as the protocol says
  std::vector<BudgetPoint> curve;  // more and more measuring, each as quick as it can be
  std::optional<BudgetPoint> to_target;  // the least measuring that meets the target
};

struct Budget {
  std::string model_level;
  std::optional<double> target;  // relative
  std::vector<BudgetSetting> settings;
  std::optional<BudgetPoint> cheapest;  // of those that meet the target
};

struct BudgetQuestion {
  const Protocol& protocol;
  const Environment& environment;
  const Rig& rig;
  const SpecimenCurve& curve;
  std::vector<Aperture> apertures;
  std::vector<double> frequencies_Hz;
  std::optional<double> target;
  AnalysisOptions options;
};
Budget reckon_budget(const BudgetQuestion& question);

}  // namespace lcrig
