// SPDX-License-Identifier: Apache-2.0
// Checks a single step's demands on the instruments, the fixture and the limits. Pure functions
// without I/O, called by the planner and the steps.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/pressure_area.hpp"
#include "base/quantity.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/protocol.hpp"
#include "protocols/rig/cell_noise.hpp"
#include "protocols/rig/force_bound.hpp"
#include "protocols/rig/limits.hpp"
#include "protocols/rig/tolerances.hpp"

namespace lcrig {

// How much the instruments of a bench scatter, standard deviations.
struct InstrumentNoise {
  // Noise of one conversion at 1 kHz and 1 V, by aperture (fast, medium, slow), F; scales with
  // 1/(frequency level) and 1/sqrt(average).
  std::array<double, 3> capacitance_F{};
  double force_N = 0;  // of one sample
  std::array<bool, 3> guessed{};  // by aperture: an assumption, not measured
  std::string basis = "noise of the meter";
};

// Everything outside the file that a plan depends on.
struct Rig {
  LcrCapabilities lcr;
  FrameCapabilities frame;
  std::vector<std::string> frame_differences;  // LoadFrame::differences
  // The probe of the fixture and the disc of the specimen. make_plan sets which of them the
  // pressures of its protocol are over (rig_for).
  PressureArea pressure;
  double gravity_m_s2 = kStandardGravity_m_s2;  // at the place of the rig, for dead weights

  // Facts that bound the force on the specimen, for a bench and for a real rig.
  // The least that the specimen shortens between two forces, and its shortening if nothing holds it
  // sideways; empty: unknown.
  Compression specimen_least_m, specimen_free_m;
  std::optional<double> frame_stiffness_N_m;  // as stated; absent: taken as rigid
  std::optional<Length> start_travel;  // where the frame stands
  std::optional<Length> start_gap;  // as a person stated it: gap_mm may be used at once
  std::optional<Length> found_contact;  // machine travel where find_contact found it
  std::optional<double> force_noise_N;  // observed noise of one sample at rest
  std::optional<CellNoise> force_scatter;  // observed as well, by digits of the cell
  double rest_force_N = 0;  // observed force of the unloaded cell

  // Estimates of specimen, frame and mounting, for times and expected forces. Without them the plan
  // states its assumptions.
  // Travel of the drive beyond contact that produces a force, m (specimen and frame in series).
  Compression compression_m;
  std::optional<Length> expected_contact;  // machine travel at which the probe will touch
  std::optional<InstrumentNoise> noise;  // absent: unknown
};

// The words of a refusal, without the place: "a force of 1.8 N, the limits allow -0.2 to 1.5 N".
using Words = std::optional<std::string>;

// A value outside a window, and the nearest end of the window.
struct Outside {
  Outside(std::string w, double e) : why(std::move(w)), end(e) {}
  std::string why;
  double end;  // SI
};
using MaybeOutside = std::optional<Outside>;

MaybeOutside check_force(double force_N, const BoundLimits& limits, const Rig& rig);
MaybeOutside check_travel(double travel_m, const BoundLimits& limits, const Rig& rig);
MaybeOutside check_speed(double speed_m_s, const BoundLimits& limits, const Rig& rig);
// Checks that the limits themselves lie within the machine's range.
MaybeOutside check_force_limit(double force_N, const FrameCapabilities& caps);
MaybeOutside check_travel_limit(double travel_m, const FrameCapabilities& caps);
Words check_lcr(const LcrSettings& settings, const LcrCapabilities& caps);
// Checks that `count` fresh readings fit into `within_s`: conversions and the pauses between
// questions must be short enough.
Words check_measure(std::int64_t count, double within_s, const LcrSettings& settings,
                    const LcrCapabilities& caps);
// Time between two fresh readings, s.
double reading_interval_s(const LcrSettings& settings, const LcrCapabilities& caps);
// Why this rig cannot do the step at all, for lack of motion or of weights.
Words check_capability(const Step& step, const FrameCapabilities& caps);

std::optional<double> force_noise_N(const Rig& rig);
double sure_force_noise_N(const Rig& rig);  // surely not less; 0: unknown
// The most that the same will be once the noise was measured anew.
double sure_force_noise_anew_N(const Rig& rig);
double target_force_N(const Target& target, const Environment& env, const Rig& rig);
// The rig with the area that the pressures of this protocol are over.
Rig rig_for(const Protocol& protocol, Rig rig);

}  // namespace lcrig
