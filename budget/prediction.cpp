// SPDX-License-Identifier: Apache-2.0
#include "budget/prediction.hpp"

#include <fmt/format.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "analysis/least_squares.hpp"
#include "analysis/line_fit.hpp"
#include "analysis/online.hpp"
#include "analysis/peak_curve.hpp"

namespace lcrig {

namespace {

constexpr int kParts = 40;  // equally likely ones of a mean square
// Where the last reading before a peak falls is chance: averaged over these parts of an interval.
constexpr double kPhases[] = {0.1, 0.3, 0.5, 0.7, 0.9};

struct Parts {
  double value = 0;
  double meter = 0, force = 0;  // standard errors of the two scatters
};

double force_noise_kPa(const PlannedRun& run) {
  return run.force_noise_N / run.area_m2 * 1e-3 * std::sqrt(kInterpolated);
}

Parts slope_of(const PlannedRun& run, double sxx, double sxy) {
  Parts out;
  out.value = sxy / sxx;
  out.meter = run.reading_noise_F * 1e15 / std::sqrt(sxx);
  out.force = std::abs(out.value) * force_noise_kPa(run) / std::sqrt(sxx);
  return out;
}

std::optional<Parts> slope_of_levels(const PlannedRun& run, const PressureRange& range) {
  RunningLine line;  // a level of n readings has weight n
  for (const PlannedLevel& l : run.levels) {
    if (!is_inside(range, l.pressure_kPa) || l.readings <= 0) continue;
    line.add(l.pressure_kPa, run.delta_C_fF(l.pressure_kPa), l.readings);
  }
  if (!(line.sxx() > 1e-12 * line.weights() * line.x_mean() * line.x_mean())) return std::nullopt;
  return slope_of(run, line.sxx(), line.sxy());
}

// Pressure at the instants of the readings of one loading, from contact to peak.
class LoadingPath {
 public:
  LoadingPath(const PlannedRun& run, const PlannedCycle& cycle) : run_(run), cycle_(cycle) {
    peak_N_ = cycle.peak_kPa * 1e3 * run.area_m2;
    way_m_ = run.compression_m(peak_N_);
  }
  // Readings of a branch, the first of them `nearest_s` from the peak.
  std::vector<double> kPa(double nearest_s) const {
    std::vector<double> out;
    for (double t = nearest_s; t <= cycle_.loading_s; t += run_.interval_s) {
      out.push_back(at(1 - t / cycle_.loading_s));
    }
    return out;
  }
  // Of the first one that a slope takes: its window must not reach over the peak.
  double first_s(double phase) const {
    const double t = phase * run_.interval_s;
    return 2 * t < run_.meter.conversion_s ? t + run_.interval_s : t;
  }

 private:
  // Where the drive is after this part of its way: it moves at constant speed.
  double at(double part) const {
    const auto short_of = [&](double force_N) {
      return run_.compression_m(force_N) - part * way_m_;
    };
    if (part >= 1) return cycle_.peak_kPa;
    if (short_of(0) >= 0) return 0;
    std::uintmax_t steps = 50;
    const auto force_N = boost::math::tools::toms748_solve(
        short_of, 0.0, peak_N_, boost::math::tools::eps_tolerance<double>(48), steps);
    return force_N.second / run_.area_m2 * 1e-3;
  }
  const PlannedRun& run_;
  const PlannedCycle& cycle_;
  double peak_N_ = 0, way_m_ = 0;
};

// Most cycles are alike: what one gave is kept.
bool same_loading(const PlannedCycle& a, const PlannedCycle& b) {
  return a.peak_kPa == b.peak_kPa && a.loading_s == b.loading_s;
}

std::optional<Parts> slope_of_loadings(const PlannedRun& run, const PressureRange& range) {
  double sxx = 0, sxy = 0, cycle_sxx = 0, cycle_sxy = 0;
  const PlannedCycle* before = nullptr;
  for (const PlannedCycle& c : run.cycles) {
    if (c.loading_s <= 0) continue;
    if (before && same_loading(*before, c)) {
      sxx += cycle_sxx;
      sxy += cycle_sxy;
      continue;
    }
    before = &c;
    cycle_sxx = cycle_sxy = 0;
    const LoadingPath loading(run, c);
    for (const double phase : kPhases) {
      RunningLine line;
      for (const double kPa : loading.kPa(loading.first_s(phase))) {
        if (kPa > kCycleEdge * c.peak_kPa && is_inside(range, kPa)) {
          line.add(kPa, run.delta_C_fF(kPa));
        }
      }
      cycle_sxx += line.sxx() / std::size(kPhases);
      cycle_sxy += line.sxy() / std::size(kPhases);
    }
    sxx += cycle_sxx;
    sxy += cycle_sxy;
  }
  if (!(sxx > 0)) return std::nullopt;
  return slope_of(run, sxx, sxy);
}

// Parts of the peak, less 1, of the readings that the fit takes.
std::vector<double> upper_half(const LoadingPath& loading, double nearest_s, double peak_kPa) {
  std::vector<double> out;
  for (const double kPa : loading.kPa(nearest_s)) {
    if (kPa >= PeakCurve::kUpper * peak_kPa) out.push_back(kPa / peak_kPa - 1);
  }
  return out;
}

// Variance of C at the peak from the fit to the upper half of the force, for unit variance of a
// reading. The readings go on through the turn, so the nearer the last one before it, the farther
// the first one after it.
double unit_variance_of_fit(const PlannedRun& run, const PlannedCycle& cycle) {
  const LoadingPath loading(run, cycle);
  double mean = 0;
  for (const double phase : kPhases) {
    const auto up = upper_half(loading, phase * run.interval_s, cycle.peak_kPa);
    const auto down = upper_half(loading, (1 - phase) * run.interval_s, cycle.peak_kPa);
    const PeakCurve curve(std::ssize(up), std::ssize(down));
    LeastSquares fit(curve.columns());
    for (const double d : up) fit.add(curve.row(d, true).data(), 0);
    for (const double d : down) fit.add(curve.row(d, false).data(), 0);
    const auto solution = fit.solve();
    mean += (solution && solution->freedom >= 1 ? solution->unit_covariance[0] : 1.0) /
            std::size(kPhases);
  }
  return mean;
}

// Mean over the cycles of (peak - rest)/C0, percent.
std::optional<Parts> dynamic_range(const PlannedRun& run) {
  double meter = 0, force = 0;  // variances of the sum over the cycles, fF2
  double sum = 0, first_rest = 0, fitted = 0;
  const PlannedCycle* before = nullptr;
  for (const PlannedCycle& c : run.cycles) {
    if (c.rest_readings < 1) return std::nullopt;
    if (first_rest <= 0) first_rest = c.rest_readings;
    const bool plateau =
        c.loading_s <= 0 || c.plateau_readings >= static_cast<double>(kPlateauReadings);
    if (plateau && c.plateau_readings < 1) return std::nullopt;
    if (!plateau && !(before && same_loading(*before, c))) fitted = unit_variance_of_fit(run, c);
    before = plateau ? nullptr : &c;
    const double peak = plateau ? 1 / c.plateau_readings : fitted;
    const double noise = run.reading_noise_F * 1e15;
    meter += noise * noise * (peak + 1 / c.rest_readings);
    const double h = 0.01 * c.peak_kPa;
    const double slope =
        (run.delta_C_fF(c.peak_kPa + h) - run.delta_C_fF(c.peak_kPa - h)) / (2 * h);
    const double scatter = slope * force_noise_kPa(run);
    force += scatter * scatter * peak;
    sum += run.delta_C_fF(c.peak_kPa);
  }
  const auto n = static_cast<double>(run.cycles.size());
  const double percent = 100 / (run.c0_F * 1e15) / n;
  Parts out;
  out.value = sum * percent;
  out.force = std::sqrt(force) * percent;
  const double c0 = run.reading_noise_F / std::sqrt(first_rest) / run.c0_F * out.value;
  out.meter = std::hypot(std::sqrt(meter) * percent, c0);
  return out;
}

void add(Uncertainty& uncertainty, std::string name, double size, UncertaintyKind kind,
         std::string basis) {
  UncertaintyPart part;
  part.name = std::move(name);
  part.standard_uncertainty = size;
  part.kind = kind;
  part.shrinks = kind == UncertaintyKind::a;
  part.shared_by_runs = kind == UncertaintyKind::b;
  part.basis = std::move(basis);
  uncertainty.parts.push_back(std::move(part));
}

// Limits +-relative of the value, all values between them alike.
void add_limits(Uncertainty& uncertainty, std::string name, double relative, std::string basis) {
  add(uncertainty, std::move(name), rectangular(relative) * std::abs(uncertainty.value),
      UncertaintyKind::b, std::move(basis));
}

void add_rig(const PlannedRun& run, const RigAccuracy& rig, Uncertainty& uncertainty) {
  const double force = rig.force_limit_percent(run.dead_weights);
  add_limits(uncertainty, "force", force / 100,
             fmt::format("class {:g}: limits of {:g} % of reading{}", force, force,
                         rig.force_class_percent ? "" : "; assumed"));
  const double tolerance_m = rig.diameter_limit_mm() * 1e-3;
  const double diameter_m = std::sqrt(4 * run.area_m2 / std::numbers::pi);
  add_limits(uncertainty, "area of the probe", 2 * tolerance_m / diameter_m,
             fmt::format("diameter within {:g} mm{}", tolerance_m * 1e3,
                         rig.probe_diameter_tolerance_mm ? "" : "; assumed"));
}

Prediction predicted(std::string quantity, std::string unit, const Parts& parts,
                     const PlannedRun& run) {
  Prediction p;
  p.quantity = p.uncertainty.quantity = std::move(quantity);
  p.unit = p.uncertainty.unit = std::move(unit);
  p.value = p.uncertainty.value = parts.value;
  p.standard_error = std::hypot(parts.meter, parts.force);
  add(p.uncertainty, "scatter of the readings", parts.meter, UncertaintyKind::a, run.noise_basis);
  add(p.uncertainty, "scatter of the force", parts.force, UncertaintyKind::a,
      "noise of the load cell");
  return p;
}

Prediction not_predicted(std::string quantity, std::string unit, std::string reason) {
  Prediction p;
  p.quantity = std::move(quantity);
  p.unit = std::move(unit);
  p.reason = std::move(reason);
  return p;
}

// Of the slope of a range, in standard errors.
double half_widths(const PlannedRun& run, const PressureRange& range, double confidence) {
  if (run.levels.empty()) {
    return expected_half_width(static_cast<int>(run.cycles.size()), 1, confidence);
  }
  std::map<int, int> levels;  // of each repeat
  for (const PlannedLevel& l : run.levels) {
    if (is_inside(range, l.pressure_kPa) && l.readings > 0) ++levels[l.repeat];
  }
  std::erase_if(levels, [](const auto& repeat) { return repeat.second < 2; });
  if (levels.empty()) return expected_half_width(1, 1, confidence);
  return expected_half_width(static_cast<int>(levels.size()), levels.begin()->second, confidence);
}

Prediction predict_sensitivity(const PlannedRun& run, const PressureRange& range,
                               const MeterAccuracy& meter, const AnalysisOptions& options) {
  const std::string name = fmt::format("sensitivity {:g}-{:g} kPa", range.from_kPa, range.to_kPa);
  const auto parts =
      run.levels.empty() ? slope_of_loadings(run, range) : slope_of_levels(run, range);
  if (!parts) {
    return not_predicted(name, "fF/kPa", "fewer than two different pressures lie in the range");
  }
  Prediction p = predicted(name, "fF/kPa", *parts, run);
  p.half_width = p.standard_error * half_widths(run, range, options.confidence);
  add_limits(p.uncertainty, "meter gain", meter.gain, "basic accuracy without its offset");
  add_rig(run, options.rig, p.uncertainty);
  combine(p.uncertainty, options.confidence);
  return p;
}

// The meter's gain cancels in the ratio; its offset stays in C0. The force is the abscissa: the
// range is that at the force that was meant.
Prediction predict_range(const PlannedRun& run, const MeterAccuracy& meter,
                         const AnalysisOptions& options) {
  const auto parts = run.cycles.empty() ? std::nullopt : dynamic_range(run);
  if (!parts) {
    return not_predicted("dynamic range", "%",
                         run.cycles.empty() ? "the protocol never loads and unloads"
                                            : "no reading is taken at rest, or none at the peak");
  }
  Prediction p = predicted("dynamic range", "%", *parts, run);
  const auto cycles = static_cast<int>(run.cycles.size());
  p.half_width = p.standard_error * expected_half_width(cycles, 1, options.confidence);
  add_limits(p.uncertainty, "meter offset in C0", meter.offset_F / run.c0_F,
             "basic accuracy, the part that does not grow with C");
  const PlannedCycle& c = run.cycles.front();
  const double h = 0.01 * c.peak_kPa;
  const double slope = (run.delta_C_fF(c.peak_kPa + h) - run.delta_C_fF(c.peak_kPa - h)) / (2 * h);
  const double bend = slope * c.peak_kPa / run.delta_C_fF(c.peak_kPa);
  const double force = options.rig.force_limit_percent(run.dead_weights);
  add_limits(p.uncertainty, "force at the peak", bend * force / 100,
             fmt::format("class {:g}, times the slope of the curve", force));
  combine(p.uncertainty, options.confidence);
  return p;
}

// Mean of chi-square over its degrees of freedom at the middles of equally likely parts.
std::vector<double> mean_squares(int freedom) {
  std::vector<double> out;
  out.reserve(kParts);
  for (int i = 0; i < kParts; ++i) {
    out.push_back(chi_squared_quantile((i + 0.5) / kParts, freedom) / freedom);
  }
  return out;
}

}  // namespace

double expected_half_width(int repeats, int levels, double confidence) {
  if (repeats < 2) return coverage_factor(confidence, std::numeric_limits<double>::infinity());
  const int of_slopes = repeats - 1, rest = (levels - 2) * (repeats - 1);
  const double t_slopes = coverage_factor(confidence, of_slopes);
  const auto slopes = mean_squares(of_slopes);
  double sum = 0;
  if (repeats == 2 || rest < 1) {
    for (const double s : slopes) sum += t_slopes * std::sqrt(s);
    return sum / kParts;
  }
  const double t_all = coverage_factor(confidence, of_slopes + rest);
  const auto others = mean_squares(rest);
  for (const double s : slopes) {
    for (const double r : others) {
      const double all = (of_slopes * s + rest * r) / (of_slopes + rest);
      sum += s >= all ? t_slopes * std::sqrt(s) : t_all * std::sqrt(all);
    }
  }
  return sum / kParts / kParts;
}

Result<std::vector<Prediction>> predict_errors(const PlannedRun& run,
                                               const AnalysisOptions& options) {
  if (!(run.reading_noise_F > 0) || !(run.interval_s > 0) || !(run.area_m2 > 0) ||
      !(run.c0_F > 0)) {
    return fail(Errc::invalid_request,
                "a budget needs the noise and the time of a reading, the probe's area and C0");
  }
  const auto meter = meter_accuracy(run.meter, options.rig.meter, run.c0_F);
  if (!meter) return fail(meter.error());
  std::vector<Prediction> out;
  out.reserve(options.ranges.size() + 1);
  for (const PressureRange& range : options.ranges) {
    out.push_back(predict_sensitivity(run, range, *meter, options));
  }
  out.push_back(predict_range(run, *meter, options));
  return out;
}

}  // namespace lcrig
