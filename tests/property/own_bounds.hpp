// SPDX-License-Identifier: Apache-2.0
// Bounds of what a rig can do, calculated independently from what is told of it. Formulas and
// methods differ from the product's, so that one mistake cannot hide in both. Used by all property
// tests.
#pragma once

#include <optional>

#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

// The stiffest contact that the told values allow: the frame as stated, in series with layers that
// cannot spread sideways (docs/model.md: energy A, uniaxial strain).
class OwnContact {
 public:
  explicit OwnContact(const sim::RandomRig& rig);
  bool is_bounded() const { return bounded_; }
  double way_m(double force_N) const;  // travel beyond contact; a lower bound
  double force_after_N(double force_N, double way_m) const;
  double stiffness_N_m(double force_N) const;  // an upper bound
  // Twice the likely shortening of frame and specimen, if the layers may spread freely.
  double generous_way_m(double force_N) const;

 private:
  double layers_m(double force_N) const;
  bool bounded_ = false;
  std::optional<double> frame_N_m_;
  double shear_Pa_ = 0, poisson_ = 0, thickness_m_ = 0, area_m2_ = 1;
};

// v tau + v^2/2a with the values of CAPS, plus 20 ms for a gateway that polls
// (docs/protocol-file.md).
double own_stopping_way_m(const sim::RandomRig& rig, double speed_m_s);
double own_speed_m_s(const sim::RandomRig& rig, double way_m);
// The highest speed from which a stop at one force stays below another; 0: nothing bounds the
// force.
double own_fastest_m_s(const sim::RandomRig& rig, double from_N, double to_N);
// Largest difference between the true force and the one shown: the class at the limit, a tenth of
// the class of the nominal force for the zero, and four standard deviations of the noise.
double own_uncertainty_N(const sim::RandomRig& rig, double limit_N);
// Distance from the loss of the host until the frame stands: 1 s of silence, 20 ms, and the stop.
double own_lost_way_m(const sim::RandomRig& rig, double speed_m_s);

}  // namespace lcrig::property
