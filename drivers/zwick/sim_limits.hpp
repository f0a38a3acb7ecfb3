// SPDX-License-Identifier: Apache-2.0
// The capabilities of the simulated machine and the limits that it was armed with. It refuses
// requests beyond them. Used by SimMachine.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "drivers/load_frame.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig::frame_link {

struct Refusal {
  Refusal(std::string c, std::string t) : code(std::move(c)), text(std::move(t)) {}
  std::string code, text;  // as in the gateway's ERR
};
using Verdict = std::optional<Refusal>;  // nullopt: accepted

// 1 towards the specimen, -1 away from it.
inline double direction_of(double way) {
  return way < 0 ? -1.0 : 1.0;
}

inline constexpr double kForceSlack_N = 1e-12;  // allows for a motion that stopped exactly at a
                                                // limit

double felt_N(const PlantConfig& config);  // the smallest force that counts as contact

// `scene` and `settings` must outlive it. `zero_m` is the machine's own travel where samples show
// 0.
class SimLimits {
 public:
  SimLimits(const FrameScene& scene, const ZwickSimSettings& settings)
      : scene_(scene), settings_(settings) {}

  FrameCapabilities of_machine() const;
  Verdict set(const FrameLimits& limits, double zero_m);
  void forget() { limits_.reset(); }
  bool are_set() const { return limits_.has_value(); }
  const FrameLimits& now() const { return limits_.value(); }

  // The limits must be set.
  Verdict check_motion(double target_m, double speed_m_s, double zero_m) const;
  Verdict check_force(double force_N) const;
  Verdict check_direction(double shown_N, double direction) const;

 private:
  const FrameScene& scene_;
  const ZwickSimSettings& settings_;
  std::optional<FrameLimits> limits_;
};

}  // namespace lcrig::frame_link
