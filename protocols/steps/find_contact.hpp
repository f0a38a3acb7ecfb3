// SPDX-License-Identifier: Apache-2.0
// The step `find_contact`: moves towards the specimen until the force rises, and back off.
#pragma once

#include "protocols/steps/facts.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

class Forecast;

struct FindContactStep {
  static constexpr std::string_view kWord = "find_contact";
  Number speed, force, back_off, timeout;  // m/s, N (rise over the baseline), m, s
  std::optional<Number> within;  // m, longest way of the search; absent: as far as the limits allow
  std::optional<Number> overshoot;  // N allowed beyond the rise; plan and run refuse more
  bool slow_down = false;  // `speed` is at most: slower where this rig stops too late

  struct Progress : StepProgress {
    std::optional<double> start_travel_m;  // of the search, also of one that begins anew
    void go_on_from(const LeftOff& before) override { start_travel_m = before.start_travel_m; }
  };
  static FindContactStep parse(const StepReader& r);
  StepFacts facts() const {
    return {FrameUse::motion(nullptr, &speed, HoldMode::travel, FrameUse::OnTheWay::nothing),
            kNoReadings, kNoSettings, kNoQuestion, kNoLoop};
  }
  StepPlan plan(PlannedRig& rig) const;
  Task<Result<>> execute(RunParts& run, Progress& progress) const;
  // With slow_down as fast as the file says, but so slow that the stop needs no more than half of
  // the room from the threshold up to the limit.
  double search_speed_m_s(const Environment& env, const Forecast& forecast, double room_N,
                          double slowest_m_s) const;
};

}  // namespace lcrig
