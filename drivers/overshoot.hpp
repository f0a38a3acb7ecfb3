// SPDX-License-Identifier: Apache-2.0
// How far the force runs past its threshold while a frame reacts and decelerates.
#pragma once

#include "base/clock.hpp"
#include "base/quantity.hpp"

namespace lcrig {

// dF = k (v tau + v^2 / 2a) (load-frame reference, section 2). `stiffness` is that of specimen and
// frame in series at the threshold; the sign of `speed` does not matter; `deceleration` > 0.
constexpr Force predicted_overshoot(Stiffness stiffness, Velocity speed, Duration reaction,
                                    Acceleration deceleration) {
  const auto tau = Quantity<0, 0, 1, 0>::from_si(to_seconds(reaction));
  const Velocity v = speed.si() < 0 ? -speed : speed;
  const Length way = v * tau + v * v / (2.0 * deceleration);
  return stiffness * way;
}

}  // namespace lcrig
