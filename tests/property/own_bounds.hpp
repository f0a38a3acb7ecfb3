// SPDX-License-Identifier: Apache-2.0
// What a rig can do, worked out again from what is told of it: by other formulas and other means
// than the product's, so that a mistake would have to be made twice.
#pragma once

#include <optional>

#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

// The stiffest contact that what is told allows: the frame as stated, in series with layers that
// cannot spread (docs/model.md: energy A, uniaxial strain).
class OwnContact {
 public:
  explicit OwnContact(const sim::RandomRig& rig);
  bool is_bounded() const { return bounded_; }
  double way_m(double force_N) const;  // beyond contact, at least
  double force_after_N(double force_N, double way_m) const;
  double stiffness_N_m(double force_N) const;  // at most
  // How far a specimen that may spread freely would go, about: twice what is likely.
  double generous_way_m(double force_N) const;

 private:
  double layers_m(double force_N) const;
  bool bounded_ = false;
  std::optional<double> frame_N_m_;
  double shear_Pa_ = 0, poisson_ = 0, thickness_m_ = 0, area_m2_ = 1;
};

// v tau + v^2/2a with what CAPS say; 20 ms more for a gateway that polls (docs/protocol-file.md).
double own_stopping_way_m(const sim::RandomRig& rig, double speed_m_s);
double own_speed_m_s(const sim::RandomRig& rig, double way_m);
// The fastest that stops from one force below another; 0: nothing bounds it.
double own_fastest_m_s(const sim::RandomRig& rig, double from_N, double to_N);
// How far the true force may be from the one that is shown: class at the limit, zero by the class
// (a tenth of it, of the nominal force), four standard deviations of the noise.
double own_uncertainty_N(const sim::RandomRig& rig, double limit_N);
// From the loss of the host until the frame stands: 1 s of silence, 20 ms, and the stop.
double own_lost_way_m(const sim::RandomRig& rig, double speed_m_s);

}  // namespace lcrig::property
