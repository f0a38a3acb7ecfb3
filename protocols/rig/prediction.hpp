// SPDX-License-Identifier: Apache-2.0
// Compares the force of a motion with what was predicted for it. The cell may show the largest
// force only after the end of the motion.
#pragma once

#include <optional>
#include <utility>

#include "drivers/load_frame.hpp"
#include "events/payloads.hpp"
#include "protocols/rig/order.hpp"

namespace lcrig {

// Of a motion that was to stop at a force.
struct ForceComparison {
  double threshold_N = 0, predicted_N = 0, observed_N = 0;
  std::optional<double> expected_N;
  bool exceeded = false;
  template <EventKind kind>
  OvershootOf<kind> event() const {
    return {threshold_N, predicted_N, expected_N, observed_N};
  }
};

class ForcePrediction {
 public:
  // `shown_after`: how long after its end the force of a motion may still be shown.
  ForcePrediction(ForceClass cell, Duration shown_after) : cell_(cell), shown_after_(shown_after) {}

  // A motion starts. Every sample until `end` belongs to it.
  void begin(const Permit& permit);
  // Returns a second comparison of the last motion if the sample shows clearly more than the first
  // one said: at once if that is more than was predicted, else when the time is over.
  std::optional<ForceComparison> add(const FrameSample& sample);
  // nullopt: there is nothing to compare, because the motion was not meant to stop at a force, or
  // it ended earlier and within its bound. `noise_N`: of a sample, at most.
  std::optional<ForceComparison> end(const MotionOutcome& outcome, double noise_N);
  // The force loop may raise the force from now on, so it shows nothing of the last motion.
  void leave_to_loop() { late_.reset(); }

 private:
  std::optional<ForceComparison> add_late(const FrameSample& sample);
  void judge(ForceComparison& c, double noise_N) const;

  ForceClass cell_;
  Duration shown_after_;
  std::optional<Permit> open_;
  std::optional<double> peak_N_;
  struct Late {  // the last motion that pressed, while the cell may still follow it
    Late(const ForceComparison& c, double n, bool r)
        : first(c), noise_N(n), reported(r), peak_N(c.observed_N) {}
    ForceComparison first;
    double noise_N;
    bool reported;  // `first` was returned
    std::optional<MonoTime> until;  // counts from the first sample after its end
    double peak_N;  // since then
  };
  std::optional<Late> late_;
};

// Whether a force is beyond the predicted one by more than the class of the cell and its noise
// explain.
bool is_beyond(double observed_N, double predicted_N, ForceClass cell, double noise_N);

}  // namespace lcrig
