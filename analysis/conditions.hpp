// SPDX-License-Identifier: Apache-2.0
// The conditions of a run on which it depends whether its results can be compared with those of
// another run, and which errors both share: rig, settings and specimen, as far as the run recorded
// them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "analysis/meter_accuracy.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

struct RunData;
struct RunView;

struct RunConditions {
  // Which meter, load cell and probe were used. Absent: the run does not prove it, so it shares
  // their errors with no other run.
  std::optional<std::string> meter, cell, probe;
  std::optional<MeterCorrections> corrections;  // absent: not recorded
  std::string measured;  // "Cp" or "Cs"
  std::optional<MeterSetting> setting;  // of the readings that count; absent: not recorded
  std::optional<double> impedance_ohm;  // of the specimen without a load, under this setting
  bool dead_weights = false;  // no load cell
  double force_class_percent = 0;  // recorded, stated or assumed
  std::optional<double> probe_diameter_m, disc_diameter_m;
  std::string specimen_text;
  bool simulated = false, replayed = false;
};
RunConditions conditions_of(const RunView& view, std::optional<double> c0_pF);

// {"meter":…,"load_cell":…,"probe":…}; null: the run does not prove it.
nlohmann::json identities_json(const RunConditions& conditions);

}  // namespace lcrig
