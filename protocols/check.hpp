// SPDX-License-Identifier: Apache-2.0
// What a single step may ask of the instruments, the fixture and the limits. Pure functions, no
// I/O; plan.cpp calls them with the state that the step meets.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "drivers/load_frame.hpp"
#include "protocols/limits.hpp"
#include "protocols/protocol.hpp"

namespace lcrig {

// How much the instruments of a bench scatter, standard deviations.
struct InstrumentNoise {
  // Of one conversion at 1 kHz and 1 V, by aperture (fast, medium, slow), F; scales with
  // 1/(frequency level) and 1/sqrt(average).
  std::array<double, 3> capacitance_F{};
  double force_N = 0;  // of one sample
};

// Everything outside the file that a plan depends on.
struct Rig {
  Rig() = default;
  LcrCapabilities lcr;
  FrameCapabilities frame;
  Area probe_area;  // of the fixture's probe tip; pressure is force over this area
  double gravity_m_s2 = 9.80665;  // local, for dead weights
  // Estimates of specimen, frame and mounting; without them the plan says what it assumed.
  // Travel of the drive beyond contact that produces a force, m (specimen and frame in series).
  std::function<double(double force_N)> compression_m;
  std::optional<Length> contact_travel;  // machine travel at which the probe touches
  std::optional<Length> start_gap;  // present gap as stated by operator or bench; gap_mm may be
                                    // used without find_contact then
  std::optional<InstrumentNoise> noise;  // absent: not known
};

// The words of a refusal, without place: "a force of 1.8 N, the limits allow -0.2 to 1.5 N".
using Refusal = std::optional<std::string>;

Refusal check_force(double force_N, const BoundLimits& limits, const Rig& rig);
Refusal check_travel(double travel_m, const BoundLimits& limits, const Rig& rig);
Refusal check_speed(double speed_m_s, const BoundLimits& limits, const Rig& rig);
Refusal check_lcr(const LcrSettings& settings, const LcrCapabilities& caps);
// `count` fresh readings within `within_s`: the conversion must be short enough.
Refusal check_measure(std::int64_t count, double within_s, const LcrSettings& settings,
                      const LcrCapabilities& caps);
// Motion, weights, force loop: what this rig cannot do at all.
Refusal check_capability(const Step& step, const FrameCapabilities& caps);

double target_force_N(const Target& target, const Environment& env, const Rig& rig);
bool is_force_target(const Target& target);
// dF = k (v tau + v^2 / 2a), load-frame reference section 2. k in N/m at that force.
double predicted_overshoot_N(double stiffness_N_m, double speed_m_s, const FrameCapabilities& caps);

}  // namespace lcrig
