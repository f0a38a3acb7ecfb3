// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

struct Quantity {
  std::string name;
  double value = 0;
  std::vector<SlopePart> relative;  // parts that the two runs do not share; empty: not known
};

Quantity quantity(const RunAnalysis& a, const std::string& name, double value) {
  Quantity q;
  q.name = name;
  q.value = value;
  const auto known = std::ranges::find(a.uncertainties, name, &Uncertainty::quantity);
  if (known == a.uncertainties.end() || value == 0) return q;
  std::vector<UncertaintyPart> own = known->parts;
  std::erase_if(own, [](const UncertaintyPart& p) { return p.shared_by_runs; });
  if (own.empty() || own.front().kind != UncertaintyKind::a) return q;
  for (const UncertaintyPart& p : own) {
    q.relative.push_back({p.standard_uncertainty / std::abs(value), p.degrees_of_freedom});
  }
  return q;
}

std::string sensitivity_name(const RangeResult& r) {
  return fmt::format("sensitivity {}", range_text(r.range));
}

std::vector<Quantity> quantities(const RunAnalysis& a) {
  std::vector<Quantity> out;
  const auto add = [&](const std::string& name, const Metric& m) {
    if (m) out.push_back(quantity(a, name, m.value()));
  };
  for (const RangeResult& r : a.ranges) {
    add(sensitivity_name(r), r.sensitivity);
  }
  add("C0", a.c0);
  add("dynamic range", a.dynamic_range);
  return out;
}

// Works with the logarithm of the ratio: its interval never crosses 0, and shared errors cancel.
void add_interval(const Quantity& from, const Quantity& to, double confidence, Comparison& c) {
  if (from.relative.empty() || to.relative.empty()) return;
  std::vector<SlopePart> parts = from.relative;
  parts.insert(parts.end(), to.relative.begin(), to.relative.end());
  const Estimate e = estimate_of_parts(0, parts, confidence);
  const double ratio = to.value / from.value;
  c.standard_error_percent = std::abs(ratio) * *e.standard_error * 100;
  if (ratio <= 0) return;
  const auto [low, high] = *e.interval;
  c.interval_percent = {(ratio * std::exp(low) - 1) * 100, (ratio * std::exp(high) - 1) * 100};
}

std::vector<double> pressures_of(const RunAnalysis& a, const PressureRange& range) {
  std::vector<double> out;
  for (const LevelResult& l : a.levels) {
    const double kPa = l.target_kPa.value_or(l.pressure_kPa);
    if (l.direction == a.line_direction && is_inside(range, kPa)) out.push_back(kPa);
  }
  return out;
}

// Lists the pressures of the other run at which `run` has no level.
std::string lacks(const RunAnalysis& run, const PressureRange& range,
                  std::vector<double> of_other) {
  constexpr double kNearby = 0.02;  // relative; within it two levels are the same
  const auto own = pressures_of(run, range);
  std::ranges::sort(of_other);
  std::string out;
  double last = -1;
  for (const double kPa : of_other) {
    const auto is_near = [&](double p) { return std::abs(p - kPa) <= kNearby * kPa; };
    if (is_near(last) || std::ranges::any_of(own, is_near)) continue;
    out += fmt::format("{}{:.4g}", out.empty() ? "" : ", ", kPa);
    last = kPa;
  }
  return out.empty() ? out : fmt::format("run {} has no level at {} kPa", run.run, out);
}

// The slope of a bent curve depends on the pressures, so different pressures need a remark.
std::string remark_on_pressures(const RunAnalysis& from, const RunAnalysis& to,
                                const std::string& name) {
  std::string out;
  for (const RangeResult& r : from.ranges) {
    if (name != sensitivity_name(r) || from.levels.empty() || to.levels.empty()) continue;
    out = lacks(from, r.range, pressures_of(to, r.range));
    add_remark(out, lacks(to, r.range, pressures_of(from, r.range)));
    if (!out.empty()) out += ": part of the difference may be that of the pressures";
  }
  return out;
}

void compare_two(const RunAnalysis& from, const RunAnalysis& to, std::vector<Comparison>& out) {
  const auto of_to = quantities(to);
  for (const Quantity& a : quantities(from)) {
    for (const Quantity& b : of_to) {
      if (a.name != b.name || a.value == 0) continue;
      Comparison c;
      c.from_run = from.run;
      c.to_run = to.run;
      c.from_specimen = from.specimen;
      c.to_specimen = to.specimen;
      c.quantity = a.name;
      c.from_value = a.value;
      c.to_value = b.value;
      c.increase_percent = (b.value / a.value - 1) * 100;
      c.remark = remark_on_pressures(from, to, a.name);
      add_interval(a, b, from.options.confidence, c);
      out.push_back(std::move(c));
    }
  }
}

}  // namespace

std::vector<Comparison> compare(std::span<const RunAnalysis> runs) {
  std::vector<Comparison> out;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    compare_two(runs[i - 1], runs[i], out);
    if (i > 1) compare_two(runs[0], runs[i], out);
  }
  return out;
}

}  // namespace lcrig
