// SPDX-License-Identifier: Apache-2.0
// The accuracy that the LCR-6100 promises (basic accuracy), and the scatter of its readings. The
// analysis derives uncertainties from both, and the budget predicts with them.
//
// Basic accuracy: Ae = [A Ar + (Ka + Kb + Kf) 100 + KL] Kc, percent (LCR-6000 manual, p. 137-139).
// The manual's pages with Ka, Kb, Kc, Kf and Ar were not at hand. Their values are those of an
// instrument with the same formula and letters (UNI-T UTR2800 class, identical in structure to the
// BK 894 and the HP 4284A). KL is known for 0 m only. The scatter is from recordings of an LCR-6100
// at 20 kHz, 1 V, FAST, and from the law of a constant current noise, 1/(f V).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/meter_words.hpp"
#include "base/result.hpp"

namespace lcrig {

struct MeterSetting {
  double frequency_Hz = 1000;
  double level_V = 1;  // rms
  std::optional<double> bias_V = {};  // absent: off
  Aperture aperture = Aperture::medium;
  int average = 1;
  bool internal_trigger = false;
  std::optional<double> conversion_s;  // of one reading, averaging included; absent: not recorded
};
// Reads the JSON object of a run row or of a `settings` event. nullopt: the text names no setting.
std::optional<MeterSetting> parse_meter_setting(std::string_view json_text);

inline constexpr double kAssumedTemperature_C = 23;
// Facts about the meter and its leads that a run does not record.
struct MeterPlace {
  std::optional<double> temperature_C;  // of the meter; absent: kAssumedTemperature_C
  std::optional<double> cable_m;  // length of the leads; absent: 0
  // The open and short corrections were measured at neighbouring frequencies only (Kf).
  bool interpolated_correction = false;
};

// Limits of error, not standard uncertainties. Two parts act differently. `gain` scales every
// capacitance and every change of it. `offset_F` is a parallel admittance that is constant while
// the setting is, so it does not affect a change of capacitance. See docs/analysis.md.
struct MeterAccuracy {
  double gain = 0;  // relative: A Ar + Kf + KL (and Ka, which counts below 500 ohm only), times Kc
  double offset_F = 0;  // Kb C Kc: Kb grows with the impedance, so this hardly depends on C
  double total = 0;  // relative, from the whole formula
  double impedance_ohm = 0;
  std::string note;  // what was assumed; empty: no assumption was needed
};
// Errors: frequency, level, capacitance or temperature outside the range of the tables.
Result<MeterAccuracy> meter_accuracy(const MeterSetting& setting, const MeterPlace& place,
                                     double capacitance_F, double dissipation = 0);

// Standard deviation of one reading, F.
double meter_noise_F(const MeterSetting& setting);

}  // namespace lcrig
