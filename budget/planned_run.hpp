// SPDX-License-Identifier: Apache-2.0
// Derives from a protocol the readings that it will take. The budget predicts the results from
// them, and so does `lcrig rehearse --batch`. `lcrig protocol plan` asks whether they can reveal a
// drift.
#pragma once

#include <string>

#include "budget/prediction.hpp"
#include "model/specimen.hpp"
#include "protocols/plan/plan.hpp"

namespace lcrig {

// Time for readings over the time that they need; the margin of the plan.
constexpr double kReadingSlack = 1.02;

// The specimen's curve, tabulated once for all settings of a budget.
struct SpecimenCurve {
  double c0_F = 0;
  std::function<double(double kPa)> delta_C_fF;  // kPa as the protocol states them
  std::string level;
};
// Tabulates up to `force_max`. Errors: no level of the model can compute the specimen.
Result<SpecimenCurve> tabulate(const Specimen& specimen, Force force_max,
                               const PressureArea& pressure);

// Levels and cycles of the protocol, in the order of execution. `plan` is the protocol's plan on
// this rig. Errors: the protocol changes the meter's settings during the run; it never loads the
// specimen; the fixture's probe or the specimen is not known.
Result<PlannedRun> plan_readings(const Protocol& protocol, const Environment& environment,
                                 const Rig& rig, const Plan& plan, const SpecimenCurve& curve);

// True if two stretches without load are long enough for the analysis to tell a drift of the
// capacitance from the specimen's response, or if nothing is ever loaded.
bool shows_drift(const Protocol& protocol, const Environment& environment, const Rig& rig,
                 const Plan& plan);

// A protocol with other settings of the meter. Where the conversions do not fit into the time of a
// `measure` step, the step gets as much time as they take, and `note` says so.
struct Variant {
  Protocol protocol;
  std::string note;
  std::map<std::string, double> parameters;  // parameters with the same effect, SI
  bool by_parameters = true;  // false: a step without a parameter for it had to be changed
};
Variant with_settings(const Protocol& protocol, const Environment& environment, const Rig& rig,
                      Aperture aperture, Frequency frequency);

// Names of the parameters that set how much is measured. An empty name: there is no such parameter.
struct Knobs {
  std::string readings, within, repeats;
};
Knobs find_knobs(const Protocol& protocol);

}  // namespace lcrig
