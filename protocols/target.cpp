// SPDX-License-Identifier: Apache-2.0
#include "protocols/target.hpp"

namespace lcrig {

double target_force_N(const Target& target, const Environment& env, const LoadFactors& factors) {
  const double value = env.get(target.value);
  switch (target.kind) {
    case TargetKind::pressure: return value * factors.area_m2;
    case TargetKind::mass: return value * factors.gravity_m_s2;
    case TargetKind::travel:
    case TargetKind::gap:
    case TargetKind::force: break;
  }
  return value;
}

}  // namespace lcrig
