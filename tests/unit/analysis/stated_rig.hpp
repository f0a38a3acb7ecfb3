// SPDX-License-Identifier: Apache-2.0
// A rig whose errors are stated, all of them small. A test makes one of them large, or leaves it
// out.
#pragma once

#include <utility>

#include "analysis/analysis.hpp"

namespace lcrig {

struct StatedRig {
  MeterSetting setting;
  AnalysisOptions options;
  MeterCorrections corrections;
  StatedRig() {
    setting.frequency_Hz = 100e3;
    setting.aperture = Aperture::slow;
    options.rig.force_class_percent = 1e-4;
    options.rig.probe_diameter_tolerance_mm = 1e-5;
    corrections.open.on = corrections.short_circuit.on = true;
  }
};

inline RunAnalysis analysis_of(const StatedRig& rig, RunData data) {
  data.settings.push_back({-1, rig.setting});
  data.corrections = rig.corrections;
  return analyse(data, rig.options).value();
}

}  // namespace lcrig
