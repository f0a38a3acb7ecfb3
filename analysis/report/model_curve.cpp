// SPDX-License-Identifier: Apache-2.0
#include "analysis/report/model_curve.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/curve.hpp"
#include "model/specimen_file.hpp"

namespace lcrig::report {

namespace {

constexpr int kSmoothPoints = 40;

// The level that the bench chose. Its other settings come from the JSON that the bench stored.
std::optional<LevelSettings> stored_settings(const ModelRequest& request) {
  const auto level = request.level ? parse_word<Level>(*request.level) : std::nullopt;
  if (!level) return std::nullopt;
  LevelSettings out;
  out.level = *level;
  const auto json = nlohmann::json::parse(request.choice_json.value_or("{}"), nullptr, false);
  if (!json.is_object()) return out;
  if (const auto mesh = json.find("mesh"); mesh != json.end() && mesh->is_number_integer()) {
    out.mesh.refinement = mesh->get<int>();
  }
  if (const auto form = json.find("form"); form != json.end() && form->is_string()) {
    out.form = parse_word<EnergyForm>(form->get<std::string>()).value_or(out.form);
  }
  return out;
}

// The requested points and a smooth curve, as rising pressures over the disc.
std::vector<double> grid_of(const ModelRequest& request, double over_disc) {
  std::vector<double> grid{0};
  double most = 0;
  for (const double p : request.pressure_kPa) {
    if (p > 0) grid.push_back(p * over_disc);
    most = std::max(most, p * over_disc);
  }
  for (int i = 1; i <= kSmoothPoints; ++i) grid.push_back(most * i / kSmoothPoints);
  std::ranges::sort(grid);
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  return grid;
}

Result<Curve> curve_of(const Specimen& specimen, const std::optional<LevelSettings>& settings,
                       const std::vector<Pressure>& pressures) {
  Result<Curve> curve = fail(Errc::bug, "no tolerance");
  for (const double tolerance : kUsefulTolerances) {
    curve = calc_curve(specimen, settings, tolerance, pressures);
    if (curve || settings) break;
  }
  return curve;
}

double at(const Curve& curve, double pressure_Pa) {
  const auto above = std::ranges::lower_bound(curve.points, pressure_Pa * (1 - 1e-12), {},
                                              &ModelPoint::pressure_Pa);
  return above == curve.points.end() ? NAN : above->delta_capacitance_F * 1e15;
}

}  // namespace

Result<ModelAnswer> evaluate_model(const ModelRequest& request) {
  auto specimen = parse_specimen(request.specimen_text, request.specimen_name);
  if (!specimen) return fail(specimen.error());
  const double over_disc = request.area_m2 / specimen->area_m2();
  const auto grid = grid_of(request, over_disc);
  if (grid.size() < 2) return fail(Errc::invalid_request, "no pressure above zero was measured");
  std::vector<Pressure> pressures;
  for (const double kPa : grid) pressures.push_back(Pressure::from_si(kPa * 1e3));
  const auto settings = stored_settings(request);
  auto curve = curve_of(*specimen, settings, pressures);
  if (!curve) return fail(curve.error());
  ModelAnswer out;
  out.level = to_string(curve->settings.level);
  out.error_estimate = curve->error_estimate;
  out.note = settings ? "the level that the bench chose for this run"
                      : "chosen now: " + (curve->choice ? curve->choice->reason : std::string());
  if (std::abs(over_disc - 1) > 1e-6) {
    out.note +=
        fmt::format("; the probe's area is {:.4g} of the disc's, forces are equal", over_disc);
  }
  for (const double p : request.pressure_kPa) {
    out.delta_C_fF.push_back(p <= 0 ? 0 : at(*curve, p * over_disc * 1e3));
  }
  for (const ModelPoint& p : curve->points) {
    out.smooth_kPa.push_back(p.pressure_Pa * 1e-3 / over_disc);
    out.smooth_fF.push_back(p.delta_capacitance_F * 1e15);
  }
  return out;
}

}  // namespace lcrig::report
