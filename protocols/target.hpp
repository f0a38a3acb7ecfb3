// SPDX-License-Identifier: Apache-2.0
// The target of a load step, and the force that it means on a given rig. Planner, runner and budget
// share the calculation.
#pragma once

#include "protocols/number.hpp"

namespace lcrig {

// `value` is in m, N, Pa or kg. A pressure becomes a force by the area that the protocol
// states it over (the probe or the disc), a mass by gravity.
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
  LoadFactors(double area, double gravity) : area_m2(area), gravity_m_s2(gravity) {}
  double area_m2;  // that pressures are over (PressureArea); 0: unknown
  double gravity_m_s2;  // at the place of the rig
};

// N; the target must be a force, a pressure or a mass.
double target_force_N(const Target& target, const Environment& env, const LoadFactors& factors);

}  // namespace lcrig
