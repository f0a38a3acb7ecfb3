// SPDX-License-Identifier: Apache-2.0
#include "model/curve.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/number.hpp"

namespace lcrig {
namespace {

std::optional<std::vector<double>> split_numbers(std::string_view text, char separator) {
  std::vector<double> numbers;
  while (true) {
    const auto end = std::min(text.find(separator), text.size());
    const auto value = number_from<double>(text.substr(0, end));
    if (!value) return std::nullopt;
    numbers.push_back(*value);
    if (end == text.size() || numbers.size() > kMostPressures) return numbers;
    text.remove_prefix(end + 1);
  }
}

tl::unexpected<Error> too_many() {
  return fail(Errc::invalid_request, "pressures: at most {} points", kMostPressures);
}

Result<std::vector<double>> expand_range(const std::vector<double>& parts) {
  const double from = parts[0], to = parts[1], step = parts[2];
  if (!(step > 0) || to < from) {
    return fail(Errc::invalid_request, "pressures {}:{}:{}: need from <= to and step > 0", from, to,
                step);
  }
  const double count = std::floor((to - from) / step + 1e-9);
  if (!(count < static_cast<double>(kMostPressures))) return too_many();
  std::vector<double> list;
  for (double i = 0; i <= count; ++i) list.push_back(from + i * step);
  return list;
}

}  // namespace

Result<std::vector<Pressure>> parse_pressures_kPa(std::string_view text) {
  const bool range = text.find(':') != std::string_view::npos;
  const auto numbers = split_numbers(text, range ? ':' : ',');
  if (!numbers || (range && numbers->size() != 3)) {
    return fail(Errc::invalid_request,
                "pressures \"{}\": expected FROM:TO:STEP or a list P1,P2,... in kPa",
                text.substr(0, 60));
  }
  Result<std::vector<double>> list = range ? expand_range(*numbers) : *numbers;
  if (!list) return fail(list.error());
  if (list->size() > kMostPressures) return too_many();
  std::vector<Pressure> pressures;
  for (const double p : *list) {
    if (p < 0 || (!pressures.empty() && p * 1e3 <= pressures.back().si())) {
      return fail(Errc::invalid_request, "pressures \"{}\": must be >= 0 and rise",
                  text.substr(0, 60));
    }
    pressures.push_back(Pressure::from_si(p * 1e3));
  }
  return pressures;
}

Result<Curve> calc_curve(const Specimen& specimen, const std::optional<LevelSettings>& settings,
                         double tolerance, const std::vector<Pressure>& pressures,
                         const std::optional<SearchTime>& patience) {
  if (pressures.empty() || pressures.size() > kMostPressures) {
    return fail(Errc::invalid_request, "pressures: 1 to {} points", kMostPressures);
  }
  const Pressure highest = std::max(pressures.back(), Pressure::from_si(1e-9));
  Curve curve;
  if (settings) {
    curve.settings = *settings;
  } else {
    auto choice = choose_level(specimen, tolerance, highest, patience);
    if (!choice) return fail(choice.error());
    curve.settings = choice->settings;
    curve.error_estimate = choice->error_estimate;
    curve.lost_beyond = choice->lost_beyond;
    curve.choice = std::move(*choice);
  }
  auto model = make_level_model(specimen, curve.settings);
  if (!model) return fail(model.error());
  if (settings) {  // last, because an estimate can take long and the level may refuse the specimen
    if (const auto estimate = estimate_error(specimen, *settings, highest)) {
      curve.error_estimate = estimate->relative;
      curve.lost_beyond = estimate->lost_beyond;
    }
  }
  for (const Pressure p : pressures) {
    const auto state = (*model)->at_pressure(p);
    if (!state) return fail(state.error().code, "at {} kPa: {}", p.si() / 1e3, state.error().what);
    curve.points.push_back({p.si(), (*model)->c0_F() + state->delta_capacitance_F,
                            state->delta_capacitance_F, state->shortening_m,
                            curve.lost_beyond && p > *curve.lost_beyond});
  }
  return curve;
}

nlohmann::json to_json(const Curve& curve) {
  nlohmann::json points = nlohmann::json::array();
  for (const auto& p : curve.points) {
    points.push_back({{"pressure_kPa", p.pressure_Pa / 1e3},
                      {"capacitance_pF", p.capacitance_F * 1e12},
                      {"delta_C_fF", p.delta_capacitance_F * 1e15},
                      {"shortening_um", p.shortening_m * 1e6}});
    if (p.extrapolated) points.back()["extrapolated"] = true;
  }
  nlohmann::json json{{"level", to_string(curve.settings.level)},
                      {"pressure_kind", to_string(curve.settings.pressure_kind)},
                      {"points", points}};
  json["error_estimate"] =
      curve.error_estimate ? nlohmann::json(*curve.error_estimate) : nlohmann::json(nullptr);
  json["lost_beyond_kPa"] =
      curve.lost_beyond ? nlohmann::json(curve.lost_beyond->si() / 1e3) : nlohmann::json(nullptr);
  if (curve.choice) json["choice"] = to_json(*curve.choice);
  return json;
}

double fit_slope(const std::vector<ModelPoint>& points) {
  const ModelPoint& first =
      points.front();  // sums start here, so that a large offset costs no digits
  double mean_x = 0, mean_y = 0;
  for (const auto& p : points) {
    mean_x += (p.pressure_Pa - first.pressure_Pa) / static_cast<double>(points.size());
    mean_y +=
        (p.delta_capacitance_F - first.delta_capacitance_F) / static_cast<double>(points.size());
  }
  double xx = 0, xy = 0;
  for (const auto& p : points) {
    const double x = p.pressure_Pa - first.pressure_Pa - mean_x;
    xx += x * x;
    xy += x * (p.delta_capacitance_F - first.delta_capacitance_F - mean_y);
  }
  return xy / xx;
}

}  // namespace lcrig
