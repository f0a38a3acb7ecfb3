// SPDX-License-Identifier: Apache-2.0
// Random rigs for `lcrig-sim --rig` and the property tests. A machine and a specimen are drawn from
// a seed. What a plan is told about them is drawn independently (docs/simulator.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"

namespace lcrig::sim {

// A specimen with F = k x (1 + c x), which has a closed form for any stiffness.
class CurvedSpecimen final : public SpecimenResponse {
 public:
  CurvedSpecimen(double stiffness_N_m, double curvature_1_m)
      : stiffness_N_m_(stiffness_N_m), curvature_1_m_(curvature_1_m) {}
  double shortening_m(double force_N) const override;
  double stiffness_N_m(double force_N) const;  // the slope at this force
  double capacitance_F(double force_N) const override;
  double c0_F() const override { return kUnloaded_F; }

 private:
  static constexpr double kUnloaded_F = 10e-12;
  double stiffness_N_m_, curvature_1_m_;
};

// Properties that make a rig difficult, as bits. Removing bits simplifies a case that failed.
enum Quirk : std::uint32_t {
  kOffset = 1U << 0U,  // the cell is not tared
  kDrift = 1U << 1U,  // its zero drifts
  kGain = 1U << 2U,  // its gain is wrong by part of what its class allows
  kMissing = 1U << 3U,  // some samples lack values
  kLate = 1U << 4U,  // samples come late and in bursts
  kSlowAnswers = 1U << 5U,
  kPolled = 1U << 6U,  // the gateway polls the force to decide when to stop
  kLoopWavers = 1U << 7U,  // the force loop has lag and ripple and stops at contact
  kCurved = 1U << 8U,  // the specimen stiffens under force
  kOddTravel = 1U << 9U,  // travel does not begin at 0
  kRevision1 = 1U << 10U,
  kNoLoop = 1U << 11U,
};
constexpr std::uint32_t kAllQuirks = (1U << 12U) - 1;

// How far the truth lies outside what a daemon is told.
struct Lie {
  double stiffness = 1;  // factor on the stiffness of the contact
  double reaction = 1;  // factor on the reaction time of the drive
  bool is_one() const { return stiffness > 1 || reaction > 1; }
};

struct RandomRig {
  std::uint64_t seed = 1;
  std::uint32_t quirks = 0;  // those that this rig has
  Lie lie;

  // The truth.
  double specimen_N_m = 0, curvature_1_m = 0;
  PlantConfig plant;
  ZwickSimSettings frame;  // `declared` is what the daemon is told
  double gap_m = 0;  // distance from the start to contact

  // What a daemon is told: the frame as in its config (docs/config-file.md), and the specimen's
  // file. An empty file means that the specimen is unknown.
  std::optional<double> frame_stiffness_N_m;
  double force_class_percent = 1;
  std::optional<ForceLoop> force_loop;
  double probe_diameter_m = 4e-3;
  std::string specimen_text;

  double limit_N = 0;  // up to twice this force the daemon's facts hold

  const FrameCapabilities& declared() const { return frame.declared.value(); }
  CurvedSpecimen specimen() const { return CurvedSpecimen(specimen_N_m, curvature_1_m); }
  double stiffness_N_m(double force_N) const;  // true stiffness of the contact
  double reaction_s() const { return plant.drive_lag_s + frame.watch_period_s; }
};

struct RigOptions {
  std::uint32_t without = 0;  // quirks to leave out
  std::optional<Lie> lie;
  std::optional<double> gap_m;  // instead of the drawn one
  std::optional<double> force_class_percent;  // of the cell, which errs within it; instead of the
                                              // drawn one
};

RandomRig random_rig(std::uint64_t seed, const RigOptions& options = RigOptions());
Lie random_lie(std::uint64_t seed);  // factors up to 20
// "random:7". Errors: invalid_request.
Result<RandomRig> parse_rig(std::string_view text);
// The members of "frame" and "fixture" in a daemon's config, and the specimen's file, as JSON.
std::string told_json(const RandomRig& rig);
// One line for messages.
std::string describe(const RandomRig& rig);

}  // namespace lcrig::sim
