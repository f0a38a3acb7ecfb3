// SPDX-License-Identifier: Apache-2.0
// Rigs that nobody built: a machine and a specimen drawn from a seed, and, drawn independently,
// what a plan is told of them. docs/simulator.md
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

// F = k x (1 + c x): a closed form, as stiff as one likes.
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

// What makes a rig awkward, as bits: a case that failed is made plainer by taking them away.
enum Quirk : std::uint32_t {
  kOffset = 1U << 0U,  // the cell is not tared
  kDrift = 1U << 1U,  // its zero drifts
  kGain = 1U << 2U,  // it is off by a part of its class
  kMissing = 1U << 3U,  // values are missing in the samples
  kLate = 1U << 4U,  // samples come late and in bursts
  kSlowAnswers = 1U << 5U,
  kPolled = 1U << 6U,  // the gateway stops by polling
  kLoopWavers = 1U << 7U,  // the force loop has lag and ripple, and lands like any other motion
  kCurved = 1U << 8U,  // the specimen stiffens under force
  kOddTravel = 1U << 9U,  // travel does not begin at 0
  kRevision1 = 1U << 10U,
  kNoLoop = 1U << 11U,
};
constexpr std::uint32_t kAllQuirks = (1U << 12U) - 1;

// The truth lies outside of what is told: by so much.
struct Lie {
  Lie() = default;
  double stiffness = 1;  // the contact is so many times stiffer
  double reaction = 1;  // the drive reacts so many times later
  bool is_one() const { return stiffness > 1 || reaction > 1; }
};

struct RandomRig {
  RandomRig() = default;
  std::uint64_t seed = 1;
  std::uint32_t quirks = 0;  // it has
  Lie lie;

  // The truth.
  double specimen_N_m = 0, curvature_1_m = 0;
  PlantConfig plant;
  ZwickSimSettings frame;  // `declared` is told
  double gap_m = 0;  // from the start to contact

  // Told: what the config of a daemon says of the frame (docs/config-file.md), and the file of
  // the specimen; empty: nothing is known of it.
  std::optional<double> frame_stiffness_N_m;
  double force_class_percent = 1;
  std::optional<ForceLoop> force_loop;
  double probe_diameter_m = 4e-3;
  std::string specimen_text;

  double limit_N = 0;  // what is told holds up to twice this force

  const FrameCapabilities& declared() const { return frame.declared.value(); }
  CurvedSpecimen specimen() const { return CurvedSpecimen(specimen_N_m, curvature_1_m); }
  double stiffness_N_m(double force_N) const;  // of the contact, in truth
  double reaction_s() const { return plant.drive_lag_s + frame.watch_period_s; }
};

struct RigOptions {
  RigOptions() = default;
  std::uint32_t without = 0;  // quirks that are left out
  std::optional<Lie> lie;
  std::optional<double> gap_m;  // instead of the one that was drawn
};

RandomRig random_rig(std::uint64_t seed, const RigOptions& options = RigOptions());
Lie random_lie(std::uint64_t seed);  // up to 20 times
// "random:7". Errors: invalid_request.
Result<RandomRig> parse_rig(std::string_view text);
// The members of "frame" and "fixture" in a daemon's config, and the specimen's file, as JSON.
std::string told_json(const RandomRig& rig);
// One line for messages.
std::string describe(const RandomRig& rig);

}  // namespace lcrig::sim
