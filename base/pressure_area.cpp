// SPDX-License-Identifier: Apache-2.0
#include "base/pressure_area.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace lcrig {

namespace {

std::optional<double> area_of(const std::optional<double>& diameter_m) {
  if (!diameter_m) return std::nullopt;
  return std::numbers::pi / 4 * *diameter_m * *diameter_m;
}

nlohmann::json scaled(const std::optional<double>& value, double factor) {
  return value ? nlohmann::json(*value * factor) : nlohmann::json();
}

std::string mm(const std::optional<double>& diameter_m) {
  return fmt::format("{:.6g} mm", diameter_m.value_or(0) * 1e3);
}

}  // namespace

double disc_limit_m(double diameter_m) {
  if (diameter_m <= 6e-3) return 0.05e-3;
  if (diameter_m <= 30e-3) return 0.1e-3;
  return diameter_m <= 120e-3 ? 0.15e-3 : 0.2e-3;
}

std::optional<double> PressureArea::probe_area_m2() const {
  return area_of(probe_diameter_m);
}

std::optional<double> PressureArea::disc_area_m2() const {
  return area_of(disc_diameter_m);
}

std::optional<double> PressureArea::diameter_m() const {
  return on == PressureOn::disc ? disc_diameter_m : probe_diameter_m;
}

std::optional<double> PressureArea::area_m2() const {
  return area_of(diameter_m());
}

double PressureArea::limit_m() const {
  return on == PressureOn::disc ? disc_limit_m(disc_diameter_m.value_or(0)) : probe_limit_m;
}

bool PressureArea::differs() const {
  if (!probe_diameter_m || !disc_diameter_m) return false;
  return std::abs(*probe_diameter_m - *disc_diameter_m) >
         probe_limit_m + disc_limit_m(*disc_diameter_m);
}

bool PressureArea::presses_part() const {
  return differs() && *probe_diameter_m < *disc_diameter_m && !plate;
}

std::optional<double> PressureArea::on_disc() const {
  const auto area = area_m2(), disc = disc_area_m2();
  if (!area || !disc || presses_part()) return std::nullopt;
  return *area / *disc;
}

std::string PressureArea::words() const {
  if (!differs()) return {};
  const std::string probe = mm(probe_diameter_m), disc = mm(disc_diameter_m);
  if (presses_part()) {
    return fmt::format(
        "pressure is force over the probe of {}, which presses only a part of the disc of {}: no "
        "pressure holds for the whole disc",
        probe, disc);
  }
  const char* spread = *probe_diameter_m < *disc_diameter_m ? " under its rigid plate" : "";
  if (on == PressureOn::disc) {
    const double over_probe = *disc_area_m2() / *probe_area_m2() * 100;
    return fmt::format(
        "pressure is force over the disc of {}{}; 100 kPa on the disc is {:.4g} kPa over the probe "
        "of "
        "{}",
        disc, spread, over_probe, probe);
  }
  return fmt::format(
      "pressure is force over the probe of {}; 100 kPa over the probe is {:.4g} kPa on the disc of "
      "{}{}",
      probe, *on_disc() * 100, disc, spread);
}

std::string PressureArea::words(double force_N) const {
  const auto kPa = [force_N](double area_m2) { return force_N / area_m2 * 1e-3; };
  const auto probe = probe_area_m2();
  if (!probe) return {};
  std::string out = fmt::format(" = {:.4g} kPa over the probe", kPa(*probe));
  if (!differs()) return out;
  const std::string disc = mm(disc_diameter_m);
  if (presses_part()) return out + ", which presses only a part of the disc of " + disc;
  return out + fmt::format(" = {:.4g} kPa on the disc of {}", kPa(*disc_area_m2()), disc);
}

Result<> require_area(const PressureArea& pressure) {
  if (pressure.on == PressureOn::probe) {
    if (pressure.probe_diameter_m) return {};
    return fail(Errc::invalid_request,
                "aims at a pressure, but the area of the probe tip is not known: set "
                "fixture.probe_diameter_mm in the bench or config file");
  }
  if (!pressure.disc_diameter_m) {
    return fail(
        Errc::invalid_request,
        "states pressures on the disc (`pressure_on`), but no specimen is given: name it by "
        "--specimen");
  }
  if (!pressure.probe_diameter_m) {
    return fail(Errc::invalid_request,
                "states pressures on the disc (`pressure_on`), but whether the probe covers it is "
                "not known: set fixture.probe_diameter_mm in the bench or config file");
  }
  return require_whole_disc(pressure);
}

Result<> require_whole_disc(const PressureArea& pressure) {
  if (!pressure.presses_part()) return {};
  return fail(
      Errc::invalid_request,
      "the probe of {} presses only a part of the disc of {}, and the model knows only "
      "forces over a whole disc: if a rigid plate on the disc spreads the force, state "
      "\"top\": \"plate\" (or \"bonded_plate\") in the specimen file; else use a probe of at "
      "least {} (fixture.probe_diameter_mm of the bench or config file)",
      mm(pressure.probe_diameter_m), mm(pressure.disc_diameter_m), mm(pressure.disc_diameter_m));
}

nlohmann::json to_json(const PressureArea& pressure) {
  return {{"on", to_string(pressure.on)},
          {"area_mm2", scaled(pressure.area_m2(), 1e6)},
          {"probe_diameter_mm", scaled(pressure.probe_diameter_m, 1e3)},
          {"probe_area_mm2", scaled(pressure.probe_area_m2(), 1e6)},
          {"disc_diameter_mm", scaled(pressure.disc_diameter_m, 1e3)},
          {"disc_area_mm2", scaled(pressure.disc_area_m2(), 1e6)},
          {"on_disc_per_kPa", scaled(pressure.on_disc(), 1)},
          {"plate", pressure.plate},
          {"differs", pressure.differs()},
          {"presses_part", pressure.presses_part()},
          {"words", pressure.words()}};
}

}  // namespace lcrig
