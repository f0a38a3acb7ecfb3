// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/read_backs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "protocols/plan/check.hpp"
#include "protocols/run/settings_proof.hpp"

namespace lcrig {

// A read-back waits for the end of a reading, which may find its value at the second attempt.
void PlannedReadBacks::add_recording(const LcrSettings& settings, const LcrCapabilities& meter) {
  const double interval_s = to_seconds(SettingsProof::kInterval);
  recording_s =
      std::max(recording_s, interval_s + takes_s + 2 * reading_interval_s(settings, meter));
  LcrSettings s = settings;
  for (const Aperture a : {Aperture::fast, Aperture::medium, Aperture::slow}) {
    s.aperture = a;
    const double share = takes_s / (interval_s + takes_s);
    cost_per_s[static_cast<std::size_t>(a)] = share / reading_interval_s(s, meter);
  }
}

// Without a pause between its readings, a level is read back before and after it only.
void PlannedReadBacks::add_level(double readings, double within_s, const LcrSettings& settings,
                                 const LcrCapabilities& meter) {
  const double period_s = within_s / readings;
  const double reading_s = reading_interval_s(settings, meter);
  const bool fits = SettingsProof::fits(from_seconds(period_s - reading_s), meter);
  const double pauses_s = to_seconds(SettingsProof::kInterval) + period_s;
  const double longest_s = fits ? std::min(pauses_s, within_s) : within_s;
  level_s = std::max(level_s, longest_s + 2 * reading_s + to_seconds(meter.read_back));
}

nlohmann::json to_json(const PlannedReadBacks& plan) {
  const auto maybe = [](double s) { return s > 0 ? nlohmann::json(s) : nlohmann::json(); };
  return {{"recording_s", maybe(plan.recording_s)},
          {"level_s", maybe(plan.level_s)},
          {"takes_s", plan.takes_s},
          {"settling_s", plan.settling_s},
          {"cost_readings_per_s",
           {{"fast", plan.cost_per_s[0]},
            {"medium", plan.cost_per_s[1]},
            {"slow", plan.cost_per_s[2]}}}};
}

}  // namespace lcrig
