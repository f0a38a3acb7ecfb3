// SPDX-License-Identifier: Apache-2.0
// Adds caveats where an interval does not account for something: gross outliers, the digit of the
// meter, slow noise of a single repeat, few levels, readings without any scatter.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr double kGross = 20;  // standard deviations: one such outlier moves a mean by its error

std::vector<Metric*> under_load(RunAnalysis& a) {
  std::vector<Metric*> list{
      &a.delta_C,           &a.dynamic_range,   &a.dynamic_range_drift,    &a.force_sensitivity,
      &a.mullins,           &a.hysteresis.area, &a.hysteresis.largest_gap, &a.creep,
      &a.limit_of_detection};
  if (!a.levels.empty()) return list;  // slopes of levels get a remark with a figure elsewhere
  for (RangeResult& r : a.ranges) list.push_back(&r.sensitivity);
  return list;
}

void add(Metric& m, const std::string& words) {
  if (m.estimate) add_remark(m.reason, words);
}

bool is_under_load(const RunAnalysis& a, const Outlier& o) {
  return o.level > 0 || std::ranges::any_of(a.cycles, [&](const CycleResult& c) {
           return c.begin_s <= o.t_s && o.t_s <= c.end_s;
         });
}

void remark_on_outliers(RunAnalysis& a) {
  std::int64_t loaded = 0, resting = 0, resting_gross = 0;
  for (const Outlier& o : a.outliers) {
    const bool gross = std::abs(o.deviations) >= kGross, load = is_under_load(a, o);
    if (!load) ++resting;
    if (gross) ++(load ? loaded : resting_gross);
  }
  if (loaded > 0) {
    for (Metric* m : under_load(a)) {
      add(*m, fmt::format("{} gross outliers among the readings under load move it", loaded));
    }
  }
  if (resting > 0) {
    add(a.limit_of_detection,
        fmt::format("{} outliers among the readings without load are not in the noise", resting));
  }
  if (resting_gross > 0) {
    for (Metric* m : {&a.dynamic_range, &a.mullins, &a.creep, &a.delta_C}) {
      add(*m,
          fmt::format("{} gross outliers among the readings without load move it", resting_gross));
    }
  }
}

void remark_on_one_repeat(RunAnalysis& a) {
  constexpr const char* kSlow =
      "noise that is slower than the correlation of neighbouring readings is not in the interval";
  const bool one_repeat = std::ranges::all_of(
      a.levels, [&](const LevelResult& l) { return l.repeat == a.levels.front().repeat; });
  if (a.levels.empty() ? a.cycles.size() == 1 : one_repeat) {
    for (RangeResult& r : a.ranges) add(r.sensitivity, kSlow);
  }
  if (a.cycles.size() != 1) return;
  for (Metric* m :
       {&a.dynamic_range, &a.force_sensitivity, &a.hysteresis.largest_gap, &a.hysteresis.area}) {
    add(*m, kSlow);
  }
}

void remark_on_few_levels(RunAnalysis& a) {
  if (a.levels.empty()) return;
  for (RangeResult& r : a.ranges) {
    if (r.shared) continue;
    add(r.sensitivity,
        "fewer than six levels: what all repeats share is not in the expanded uncertainty");
  }
}

void remark_on_no_scatter(RunAnalysis& a) {
  std::vector<Metric*> list{&a.c0, &a.drift, &a.delta_C, &a.dynamic_range, &a.force_sensitivity};
  if (a.levels.empty()) {
    for (RangeResult& r : a.ranges) list.push_back(&r.sensitivity);
  }
  for (Metric* m : list) {
    if (m->estimate && m->estimate->standard_error == 0) {
      add_remark(m->reason,
                 "the readings do not scatter at all: an interval of no width says nothing");
    }
  }
  if (a.noise.estimate && a.noise.value() == 0) {
    add_remark(a.noise.reason,
               "neighbouring readings are alike: a meter that measures shows its noise");
  }
}

// The digit of the meter: the largest step of which all readings are multiples, among 1, 2, 2.5 and
// 5 times a power of ten below a hundredth of the largest reading. 0: there is no such step, or it
// is too small to matter.
double digit_F(const std::vector<RunReading>& readings) {
  double most = 0;
  for (const RunReading& r : readings) most = std::max(most, std::abs(r.capacitance_F));
  if (!(most > 0) || readings.size() < 10) return 0;
  const int top = static_cast<int>(std::floor(std::log10(most))) - 2;
  for (int exponent = top; exponent > top - 6; --exponent) {
    for (const double steps_of : {5.0, 2.5, 2.0, 1.0}) {
      const double digit = steps_of * std::pow(10.0, exponent);
      if (digit * 100 > most) continue;
      if (std::ranges::all_of(readings, [digit](const RunReading& r) {
            const double steps = r.capacitance_F / digit;
            return std::abs(steps - std::round(steps)) < 1e-5;
          })) {
        return digit;
      }
    }
  }
  return 0;
}

Uncertainty* find(std::vector<Uncertainty>& list, UncertainResult result) {
  const auto it = std::ranges::find(list, result, &Uncertainty::result);
  return it == list.end() ? nullptr : &*it;
}

void add_resolution(Uncertainty* u, double size, double digit_fF) {
  if (u == nullptr) return;
  u->parts.push_back(part("resolution of the meter", size,
                          fmt::format("the digit is {:g} fF, and the readings scatter by less: "
                                      "rectangular",
                                      digit_fF)));
  combine(*u, u->confidence);
}

// Change of the slope from errors of a digit at each pressure, the same in all repeats.
double tilt_of_digit(const RunAnalysis& a, const PressureRange& range, double error_fF) {
  RunningLine line;
  std::vector<double> seen;
  for (const LevelResult& l : a.levels) {
    const double kPa = l.target_kPa.value_or(l.pressure_kPa);
    if (l.direction != a.line_direction || !is_inside(range, kPa)) continue;
    if (std::ranges::find(seen, kPa) != seen.end()) continue;
    seen.push_back(kPa);
    line.add(kPa, 0);
  }
  return line.sxx() > 0 ? error_fF / std::sqrt(line.sxx()) : 0;
}

void add_digit(const Scene& scene, RunAnalysis& a) {
  if (!a.noise.estimate) return;
  const double digit_fF = digit_F(scene.data.readings) * 1e15;
  if (!(digit_fF > a.noise.value())) return;
  const double error_fF = digit_fF / std::sqrt(12.0);
  const std::string words = fmt::format(
      "the readings scatter by less than the meter's digit of {:g} fF: the interval knows nothing "
      "of it, the expanded uncertainty does",
      digit_fF);
  for (Metric* m : {&a.c0, &a.dynamic_range, &a.delta_C}) add(*m, words);
  add_resolution(find(a.uncertainties, UncertainResult::c0), error_fF * 1e-3, digit_fF);
  add_resolution(find(a.uncertainties, UncertainResult::delta_C), std::sqrt(2.0) * error_fF,
                 digit_fF);
  if (a.c0 && a.c0.value() != 0) {
    const double percent = std::sqrt(2.0) * error_fF / std::abs(a.c0.value() * 1e3) * 100;
    add_resolution(find(a.uncertainties, UncertainResult::dynamic_range), percent, digit_fF);
  }
  if (a.levels.empty()) return;
  for (RangeResult& r : a.ranges) {
    add(r.sensitivity, words);
    const double tilt = tilt_of_digit(a, r.range, error_fF);
    if (r.uncertainty.parts.empty()) continue;
    add_resolution(&r.uncertainty, tilt, digit_fF);
    const auto told =
        std::ranges::find(a.uncertainties, r.uncertainty.quantity, &Uncertainty::quantity);
    if (told != a.uncertainties.end()) *told = r.uncertainty;
  }
}

bool is_finite(const Estimate& e) {
  const bool interval =
      !e.interval || (std::isfinite((*e.interval)[0]) && std::isfinite((*e.interval)[1]));
  return std::isfinite(e.value) && std::isfinite(e.standard_error.value_or(0)) && interval;
}

// A result that is not finite is replaced by a reason why there is none.
void drop_what_is_no_number(RunAnalysis& a) {
  for (const Metric* known : a.metrics()) {
    auto* m = const_cast<Metric*>(known);
    if (!m->estimate || is_finite(*m->estimate)) continue;
    m->estimate.reset();
    m->reason = "no finite number comes out of these readings";
  }
  std::erase_if(a.uncertainties, [](const Uncertainty& u) { return !std::isfinite(u.expanded); });
}

}  // namespace

void add_remarks(const Scene& scene, RunAnalysis& a) {
  if (!a.noise.reason.empty()) add(a.limit_of_detection, "its noise: " + a.noise.reason);
  remark_on_outliers(a);
  remark_on_one_repeat(a);
  remark_on_few_levels(a);
  remark_on_no_scatter(a);
  add_digit(scene, a);
  drop_what_is_no_number(a);
}

}  // namespace lcrig
