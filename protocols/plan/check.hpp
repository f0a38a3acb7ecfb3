// SPDX-License-Identifier: Apache-2.0
// Checks what a single step may ask of the instruments, the fixture and the limits. Pure functions,
// no I/O; the planner and the steps call them with what the step meets.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "base/quantity.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/plan/force_bound.hpp"
#include "protocols/plan/limits.hpp"
#include "protocols/protocol.hpp"
#include "protocols/watch/watch_figures.hpp"

namespace lcrig {

// How much the instruments of a bench scatter, standard deviations.
struct InstrumentNoise {
  // Noise of one conversion at 1 kHz and 1 V, by aperture (fast, medium, slow), F; scales with
  // 1/(frequency level) and 1/sqrt(average).
  std::array<double, 3> capacitance_F{};
  double force_N = 0;  // of one sample
  std::array<bool, 3> guessed{};  // by aperture: nobody has measured it
  std::string basis = "noise of the meter";
};

// Everything outside the file that a plan depends on.
struct Rig {
  LcrCapabilities lcr;
  FrameCapabilities frame;
  Area probe_area;  // of the fixture's probe tip; pressure is force over this area
  double gravity_m_s2 = kStandardGravity_m_s2;  // local, for dead weights

  // Facts that bound the force on the specimen. The same for a bench and for a real rig.
  Compression specimen_least_m;  // shortening of the specimen, at least; empty: not known
  std::optional<double> frame_stiffness_N_m;  // as stated; absent: taken for rigid
  std::optional<Length> start_travel;  // where the frame stands
  std::optional<Length> start_gap;  // present gap as a person stated it: gap_mm may be used at once
  std::optional<Length> found_contact;  // machine travel, once find_contact has found it
  double force_class_percent = 1;  // of the load cell: ISO 7500-1
  std::optional<double> force_noise_N;  // of a sample at rest, as it was seen
  std::optional<ForceScatter> force_scatter;  // the same, digit by digit
  double rest_force_N = 0;  // what the unloaded cell shows, as it was seen

  // Estimates of specimen, frame and mounting, for times and expected forces; without them the plan
  // says what it assumed.
  // Travel of the drive beyond contact that produces a force, m (specimen and frame in series).
  Compression compression_m;
  std::optional<Length> expected_contact;  // machine travel at which the probe will touch
  std::optional<InstrumentNoise> noise;  // absent: not known
};

// The words of a refusal, without place: "a force of 1.8 N, the limits allow -0.2 to 1.5 N".
using Words = std::optional<std::string>;

// A value outside of a window, and the end of the window that it may go to.
struct Outside {
  Outside(std::string w, double e) : why(std::move(w)), end(e) {}
  std::string why;
  double end;  // SI
};
using MaybeOutside = std::optional<Outside>;

MaybeOutside check_force(double force_N, const BoundLimits& limits, const Rig& rig);
MaybeOutside check_travel(double travel_m, const BoundLimits& limits, const Rig& rig);
MaybeOutside check_speed(double speed_m_s, const BoundLimits& limits, const Rig& rig);
// The limits themselves must be inside of what the machine can do.
MaybeOutside check_force_limit(double force_N, const FrameCapabilities& caps);
MaybeOutside check_travel_limit(double travel_m, const FrameCapabilities& caps);
Words check_lcr(const LcrSettings& settings, const LcrCapabilities& caps);
// `count` fresh readings within `within_s`: conversion and pause between two questions must be
// short enough.
Words check_measure(std::int64_t count, double within_s, const LcrSettings& settings,
                    const LcrCapabilities& caps);
// Between two fresh readings, s.
double reading_interval_s(const LcrSettings& settings, const LcrCapabilities& caps);
// Motion or weights: what this rig cannot do at all.
Words check_capability(const Step& step, const FrameCapabilities& caps);

std::optional<double> force_noise_N(const Rig& rig);
double target_force_N(const Target& target, const Environment& env, const Rig& rig);

}  // namespace lcrig
