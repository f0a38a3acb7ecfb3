// SPDX-License-Identifier: Apache-2.0
// The area that a pressure belongs to. A fixture has a probe, a specimen has a disc, and a force
// divided by the one or by the other gives two pressures. Whatever asks for, plans, predicts or
// prints a pressure takes the area from here.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/enum_words.hpp"
#include "base/result.hpp"

namespace lcrig {

// The body whose area turns a force into the pressures that are asked for and printed.
enum class PressureOn { probe, disc };
template <>
inline constexpr EnumWords<2> kWordsOf<PressureOn>{"probe", "disc"};

// Limits of the diameter of a probe tip: a turned part (docs/analysis.md, "area of the probe").
inline constexpr double kProbeLimit_m = 0.02e-3;
// Limits of the diameter of a disc whose file states none: ISO 2768-1, class f (0.05 mm up to 6 mm,
// 0.1 mm up to 30 mm, 0.15 mm up to 120 mm, 0.2 mm beyond).
double disc_limit_m(double diameter_m);

struct PressureArea {
  std::optional<double> probe_diameter_m;  // of the fixture; absent: not known
  std::optional<double> disc_diameter_m;  // of the specimen; absent: not known
  bool plate = false;  // a rigid plate on the disc spreads the force of a smaller probe
  PressureOn on = PressureOn::probe;
  double probe_limit_m = kProbeLimit_m;

  std::optional<double> probe_area_m2() const;
  std::optional<double> disc_area_m2() const;
  // Pressures are force divided by this; absent: not known.
  std::optional<double> area_m2() const;
  std::optional<double> diameter_m() const;  // of that area
  double limit_m() const;  // of that diameter
  // The diameters differ by more than the sum of their limits.
  bool differs() const;
  // The probe is smaller than the disc, and no plate spreads its force: no pressure holds for the
  // whole disc.
  bool presses_part() const;
  // Pressure on the disc for a printed pressure of 1. Absent: not known, or a part is pressed.
  std::optional<double> on_disc() const;
  // Which pressure is meant and what the disc gets; empty where probe and disc agree.
  std::string words() const;
  // The same for one force, to follow its size: " = 94 kPa over the probe = 375 kPa on the disc of
  // 4 mm". Empty: the probe is not known.
  std::string words(double force_N) const;
};

// Errors: invalid_request: the area of the stated body is not known, or the disc is stated although
// only a part of it is pressed.
Result<> require_area(const PressureArea& pressure);
// For whatever computes with the model. Errors: invalid_request: only a part of the disc is
// pressed.
Result<> require_whole_disc(const PressureArea& pressure);

// The object `pressure` of docs/cli-json.md.
nlohmann::json to_json(const PressureArea& pressure);

}  // namespace lcrig
