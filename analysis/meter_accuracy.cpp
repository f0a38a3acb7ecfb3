// SPDX-License-Identifier: Apache-2.0
#include "analysis/meter_accuracy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/text.hpp"
#include "events/payloads.hpp"

namespace lcrig {

namespace {

// Standard deviation of one conversion at 1 kHz and 1 V, F, by speed: 3 fF at 20 kHz, FAST, from
// recordings, scaled by 1/(f V), and less by the root of the ratio of conversion times.
constexpr std::array<double, 3> kNoise_F{60e-15, 44e-15, 25e-15};

// Ka and Kb: below 100 Hz, up to 100 kHz, and above. Z is in ohm, Vs in mV.
struct Coefficients {
  double ka = 0, kb = 0;
};
Coefficients coefficients(const MeterSetting& s, double impedance_ohm) {
  const bool fast = s.aperture == Aperture::fast;
  const double mV = s.level_V * 1e3;
  const double f = s.frequency_Hz;
  const double low = f < 100 ? 1 + std::sqrt(100 / f) : 1;
  const double high = f > 100e3 ? 3 : 1;
  const double series = (fast ? 400 : 200) / mV;
  const double parallel = (fast ? 100 : 70) / mV;
  Coefficients k;
  if (impedance_ohm < 500) {
    k.ka = (fast ? 2.5e-3 : 1e-3) / impedance_ohm * ((f > 100e3 ? 2 : 1) + series) * low;
  } else {
    k.kb = impedance_ohm * (fast ? 2e-9 : 1e-9) * high * (1 + parallel) * low;
  }
  return k;
}

// Factor on A outside 0.4 to 1.2 V: 2.5 at 0.1 V, 1.5 at 0.3 V, 1 at 1 V, linear in log level.
Result<double> level_factor(double level_V) {
  if (level_V >= 0.4 && level_V <= 1.2) return 1.0;
  if (level_V < 0.1 || level_V > 2) {
    return fail(Errc::invalid_request,
                "no accuracy is known at {} V: the tables go from 0.1 to 2 V", level_V);
  }
  if (level_V > 1.2) return 1.0;
  const bool lower = level_V < 0.3;
  const double a = lower ? 0.1 : 0.3, b = lower ? 0.3 : 1.0;
  const double fa = lower ? 2.5 : 1.5, fb = lower ? 1.5 : 1.0;
  return fa + (fb - fa) * std::log(level_V / a) / std::log(b / a);
}

Result<double> temperature_factor(double celsius) {
  if (celsius >= 18 && celsius <= 28) return 1.0;
  if (celsius >= 8 && celsius <= 38) return 2.0;
  return fail(Errc::invalid_request,
              "no accuracy is known at {} degrees Celsius: the tables go from 8 to 38", celsius);
}

}  // namespace

std::optional<MeterSetting> parse_meter_setting(std::string_view json_text) {
  const auto stored = from_json<SettingsEvent>(json_text);
  if (!stored || !stored->aperture) return std::nullopt;
  MeterSetting out;
  out.frequency_Hz = stored->frequency_Hz.value_or(0);
  out.level_V = stored->level_V.value_or(0);
  if (!(out.frequency_Hz > 0) || !(out.level_V > 0)) return std::nullopt;
  out.bias_V = stored->bias_V;
  out.aperture = *stored->aperture;
  out.average = static_cast<int>(std::clamp(stored->average.value_or(1), 1.0, 256.0));
  out.internal_trigger = stored->trigger == LcrTrigger::internal;
  out.conversion_s = stored->conversion_time_s;
  return out;
}

Result<MeterAccuracy> meter_accuracy(const MeterSetting& s, const MeterPlace& place,
                                     double capacitance_F, double dissipation) {
  if (!(capacitance_F > 0) || !(s.frequency_Hz > 0)) {
    return fail(Errc::invalid_request, "no accuracy is known of {} F at {} Hz", capacitance_F,
                s.frequency_Hz);
  }
  auto ar = level_factor(s.level_V);
  if (!ar) return fail(ar.error());
  auto kc = temperature_factor(place.temperature_C.value_or(kAssumedTemperature_C));
  if (!kc) return fail(kc.error());
  MeterAccuracy out;
  out.impedance_ohm = 1 / (2 * std::numbers::pi * s.frequency_Hz * capacitance_F);
  const Coefficients k = coefficients(s, out.impedance_ohm);
  const double basic = (s.aperture == Aperture::fast ? 1e-3 : 5e-4) * *ar;
  const double kf = place.interpolated_correction ? 3e-4 : 0;
  // Ae holds for D <= 0.1; beyond, it is multiplied by sqrt(1 + D^2).
  const double loss = dissipation > 0.1 ? std::sqrt(1 + dissipation * dissipation) : 1;
  out.gain = (basic + kf + k.ka) * *kc * loss;
  out.offset_F = k.kb * *kc * loss * capacitance_F;
  out.total = out.gain + k.kb * *kc * loss;
  if (s.level_V > 1.2) add_remark(out.note, "Ar above 1.2 V is not known and taken as 1");
  if (s.frequency_Hz < 100) add_remark(out.note, "below 100 Hz");
  return out;
}

double meter_noise_F(const MeterSetting& s) {
  return kNoise_F[static_cast<std::size_t>(s.aperture)] * (1000 / s.frequency_Hz) / s.level_V /
         std::sqrt(s.average);
}

}  // namespace lcrig
