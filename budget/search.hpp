// SPDX-License-Identifier: Apache-2.0
// Weighs speed against error. It tries every setting of the meter and finds how much must be
// measured with each. `lcrig budget` and `lcrig rehearse --batch` use it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "budget/planned_run.hpp"
#include "budget/prediction.hpp"

namespace lcrig {

// One way to do the experiment, with its predicted errors.
struct BudgetPoint {
  Aperture aperture = Aperture::medium;
  double frequency_Hz = 0;
  std::map<std::string, double> parameters;  // that differ from the request, in the name's unit
  bool follows = true;  // the protocol with these parameters is planned exactly like this point
  std::string refused;  // why it cannot be done or predicted; empty: the members below are filled
  std::string note;
  bool noise_guessed = false;
  double duration_s = 0;
  std::int64_t readings = 0;  // of `measure` steps; without such steps, all recorded readings
  std::vector<Prediction> predictions;
  double worst = 0;  // largest relative standard error of the predictions
  double worst_half_width = 0;  // relative, of the interval expected from `analyze`
  double worst_expanded = 0;  // relative, including the systematic parts
  int repeats = 0;  // smallest number that one of the predictions is made of
  std::vector<std::string> not_predicted;  // results that can never be said to meet a target
  // A single repeat says nothing of differences between repeats: no interval can be promised.
  bool tells_repeats() const { return repeats >= 2; }
  bool meets(double target) const {
    return possible() && not_predicted.empty() && tells_repeats() && worst_half_width <= target;
  }
  bool front = false;  // no other point is both quicker and more accurate
  bool possible() const { return refused.empty(); }
};

struct BudgetSetting {  // one combination of aperture and frequency
  BudgetPoint planned;  // as the protocol has it
  std::vector<BudgetPoint> curve;  // with increasing effort; each point as quick as it can be
  std::optional<BudgetPoint> to_target;  // the least effort that meets the target
};

struct Budget {
  std::string model_level;
  PressureArea pressure;  // what its pressures are over
  std::optional<double> target;  // relative
  std::vector<BudgetSetting> settings;
  std::optional<BudgetPoint> cheapest;  // among the points that meet the target
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
