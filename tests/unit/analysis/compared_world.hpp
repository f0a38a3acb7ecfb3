// SPDX-License-Identifier: Apache-2.0
// Runs of two worlds whose true ratio is known, for tests of comparisons. The errors of meter, load
// cell and probe are drawn here, from the limits of their papers, and not taken from the product.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "analysis/run_data.hpp"

namespace lcrig {

// The specimen: C0 + span (1 - exp(-P / bend)), times its creep. P is the pressure on its disc.
struct ComparedSpecimen {
  double c0_fF = 4000, span_fF = 600, bend_kPa = 70;
  double creep_per_decade = 0;
  // As in its file, and how much larger it is; absent: the file is not known, and P is the pressure
  // under the probe.
  std::optional<double> disc_mm = {};
  double disc_error_mm = 0;

  double delta_fF(double kPa, double after_s) const {
    const double creep = 1 + creep_per_decade * std::log10(std::max(after_s, 0.05));
    return span_fF * (1 - std::exp(-kPa / bend_kPa)) * creep;
  }
};

// Relative errors, constant in a run.
struct ComparedRig {
  double meter_gain = 0, meter_offset_fF = 0, cell_gain = 0, probe_area = 0;
  std::string meter = "LCR-6100 A1", cell = "C1", probe = "P1";  // empty: not stated
  bool weights = false;  // in place of the load cell
};

struct ComparedProtocol {
  bool ramps = false;  // loadings without levels
  std::vector<double> kPa = {10, 20, 30, 40, 50, 60};
  int repeats = 4, readings = 24, settle = 0;  // settle: readings at a level before it counts
  int ramp_readings = 60;  // of a loading without levels
  double frequency_Hz = 100e3, level_V = 1;
  std::optional<double> bias_V;
  std::string function = "Cp-D";
  double probe_mm = 4, force_class = 1;
  std::optional<bool> open_on = true, short_on = true;
  std::optional<std::int64_t> corrected_unix_ns = 1;
};

class ComparedRun {
 public:
  static constexpr double kReading_s = 0.14;

  ComparedRun(std::int64_t number, std::string specimen, const ComparedSpecimen& s,
              const ComparedRig& rig, const ComparedProtocol& p, std::uint64_t seed)
      : s_(s), rig_(rig), p_(p), random_(seed) {
    data.run = number;
    data.row.specimen_name = std::move(specimen);
    data.row.protocol_name = p.ramps ? "ramps" : "levels";
    data.row.lcr_identity = "the whole reply";
    data.listing.exit_status = ExitStatus::success;
    describe_rig();
    data.rest_force_N = 0;
    for (int i = 0; i < 120; ++i) read(0, 0, 0, 0);
    data.contact_s = t_s_ - 0.5;
    for (repeat_ = 1; repeat_ <= p.repeats; ++repeat_) p.ramps ? ramp() : levels();
    data.duration_s = t_s_;
  }
  RunData data;

 private:
  void describe_rig() {
    data.probe_diameter_m = p_.probe_mm * 1e-3;
    data.area_m2 = std::numbers::pi / 4 * *data.probe_diameter_m * *data.probe_diameter_m;
    data.row.probe_diameter_m = data.probe_diameter_m;
    data.pressure.probe_diameter_m = data.probe_diameter_m;
    if (s_.disc_mm) data.pressure.disc_diameter_m = *s_.disc_mm * 1e-3;
    data.function = p_.function;
    data.steps = {"s"};
    data.force_class_percent = p_.force_class;
    data.dead_weights = rig_.weights;
    std::string fixture = "{";
    const auto add = [&fixture](const char* key, const std::string& value) {
      if (value.empty()) return;
      fixture += (fixture.size() > 1 ? ",\"" : "\"") + std::string(key) + "\":\"" + value + "\"";
    };
    add("cell_serial", rig_.cell);
    add("probe_serial", rig_.probe);
    data.row.frame_capabilities_json = fixture + "}";
    auto& corrections = data.corrections.emplace();
    corrections.meter = rig_.meter.empty() ? data.row.lcr_identity : rig_.meter;
    corrections.open = {p_.open_on, p_.corrected_unix_ns, "ada"};
    corrections.short_circuit = {p_.short_on, p_.corrected_unix_ns, "ada"};
    RunData::Settings settings;
    settings.since_s = -1;
    settings.meter.frequency_Hz = p_.frequency_Hz;
    settings.meter.level_V = p_.level_V;
    settings.meter.bias_V = p_.bias_V;
    data.settings.push_back(settings);
  }

  void levels() {
    double before = 0;
    int index = 0;
    for (const double kPa : p_.kPa) {
      for (int k = 0; k < 8; ++k) read(before + (kPa - before) * (k + 0.5) / 8, 0, 0, 0.1);
      const double reached_s = t_s_;
      for (int k = 0; k < p_.settle; ++k) read(kPa, 0, 0, t_s_ - reached_s + kReading_s / 2);
      LevelRow row;
      row.level = static_cast<std::int32_t>(data.levels.size()) + 1;
      row.repeat = repeat_;
      row.index = ++index;
      row.target_pressure_Pa = kPa * 1e3;
      row.target_force_N = kPa * 1e3 * *data.area_m2;
      row.planned_readings = p_.readings;
      row.begin_s = t_s_;
      data.levels.push_back(row);
      for (int k = 1; k <= p_.readings; ++k) {
        read(kPa, row.level, k, t_s_ - reached_s + kReading_s / 2);
      }
      before = kPa;
    }
    for (int k = 0; k < 12; ++k) read(before * (1 - (k + 0.5) / 12), 0, 0, 0.1);
    for (int k = 0; k < 40; ++k) read(0, 0, 0, 0);
  }

  void ramp() {
    const int n = p_.ramp_readings;
    const double peak = p_.kPa.back();
    const double begin_s = t_s_;
    for (int k = 0; k < n; ++k) read(peak * (k + 0.5) / n, 0, 0, t_s_ - begin_s);
    for (int k = 0; k < n; ++k) read(peak * (1 - (k + 0.5) / n), 0, 0, t_s_ - begin_s);
    for (int k = 0; k < 40; ++k) read(0, 0, 0, 0);
  }

  // `kPa` as the rig shows it.
  void read(double kPa, std::int32_t level, std::int32_t index, double after_s) {
    RunReading r;
    r.t_s = t_s_ + kReading_s / 2;
    t_s_ += kReading_s;
    r.force_N = static_cast<float>(kPa * 1e3 * *data.area_m2);
    r.level = level;
    r.index = index;
    r.repeat = repeat_;
    r.present = 1;
    data.frame.push_back({r.t_s, r.force_N, 0, false});
    ++data.frame_samples;
    ++data.fresh_readings;
    // The cell shows more force than there is, and the probe is larger than it is said to be.
    const double true_kPa = kPa / (1 + rig_.cell_gain) * pressed();
    double fF = s_.c0_fF + s_.delta_fF(true_kPa, after_s);
    fF = fF * (1 + rig_.meter_gain) + rig_.meter_offset_fF;
    r.capacitance_F = (fF + 0.5 * normal_(random_)) * 1e-15;
    data.readings.push_back(r);
  }

  // Pressure on the specimen for a printed pressure of 1 and a true force.
  double pressed() const {
    if (!s_.disc_mm) return 1 / (1 + rig_.probe_area);
    const double ratio = p_.probe_mm / (*s_.disc_mm + s_.disc_error_mm);
    return ratio * ratio;
  }

  ComparedSpecimen s_;
  ComparedRig rig_;
  ComparedProtocol p_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double t_s_ = 0;
  std::int32_t repeat_ = 0;
};

}  // namespace lcrig
