// SPDX-License-Identifier: Apache-2.0
// The aim of a load step, and the force that it is on a given rig. Planner, runner and budget share
// the arithmetic.
#pragma once

#include "protocols/number.hpp"

namespace lcrig {

// `value` is m, N, Pa or kg. Pressure becomes force by the area of the probe, mass by gravity.
enum class TargetKind { travel, gap, force, pressure, mass };
struct Target {
  TargetKind kind = TargetKind::travel;
  Number value;
};

inline bool is_force(const Target& target) {
  return target.kind != TargetKind::travel && target.kind != TargetKind::gap;
}

// Factors that turn a pressure or a mass into a force.
struct LoadFactors {
  LoadFactors(double area, double gravity) : probe_area_m2(area), gravity_m_s2(gravity) {}
  double probe_area_m2;  // 0: not known
  double gravity_m_s2;  // local
};

// N; of a target that is a force.
double target_force_N(const Target& target, const Environment& env, const LoadFactors& factors);

}  // namespace lcrig
