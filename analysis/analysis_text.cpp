// SPDX-License-Identifier: Apache-2.0
#include "analysis/analysis_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "analysis/likeness.hpp"
#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kRows = 60;  // most rows of a table; the JSON has all of them

// Rounds a value to the second digit of its standard error; further digits would be noise.
std::string rounded(double value, std::optional<double> error) {
  if (!error || !(*error > 0) || !std::isfinite(*error)) return fmt::format("{:.6g}", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(*error))), 0, 9);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string with_error(double value, std::optional<double> error) {
  if (!error) return fmt::format("{:.6g}", value);
  return fmt::format("{} +- {}", rounded(value, error), rounded(*error, error));
}

std::string interval_text(const Estimate& e) {
  if (!e.interval) return "";
  return fmt::format("[{}, {}]", rounded((*e.interval)[0], e.standard_error),
                     rounded((*e.interval)[1], e.standard_error));
}

void append_metric(std::string& out, const std::string& name, const Metric& m,
                   const Uncertainty* u) {
  if (!m) {
    out += fmt::format("  {:<38} -  ({})\n", name, m.reason);
    return;
  }
  out += fmt::format("  {:<38} {:<22} {:<24} n {}\n", name,
                     with_error(m.value(), m.estimate->standard_error), interval_text(*m.estimate),
                     m.rows);
  if (!m.reason.empty()) out += fmt::format("  {:<38}   {}\n", "", m.reason);
  if (!m.estimand.empty()) out += fmt::format("    {}\n", m.estimand);
  if (u == nullptr) return;
  if (const auto gaps = u->gaps(); !gaps.empty()) {
    out += fmt::format("    for the specimen's own +- at least {:.2g}; not included: {}\n",
                       u->expanded, fmt::join(gaps, ", "));
  }
}

void append_range(std::string& out, const RangeResult& r) {
  append_metric(out, fmt::format("sensitivity {}, fF/kPa", range_text(r.range)), r.sensitivity,
                r.uncertainty.parts.empty() ? nullptr : &r.uncertainty);
  if (!r.sensitivity) return;
  const std::string r2 = r.r_squared ? fmt::format("{:.4f}", *r.r_squared) : "-";
  out += fmt::format("    {} points, {} pressures, R2 {}; {}\n", r.points, r.pressures, r2,
                     r.residual_pattern);
  if (r.robust) {
    out += fmt::format("    robust (Huber) {}\n",
                       with_error(r.robust->slope_fF_per_kPa, r.robust->standard_error));
  }
}

void append_curve(std::string& out, const RunAnalysis& a) {
  if (a.curve.empty()) return;
  out += "\nCurve (mean of the repeats)\n  direction  pressure_kPa  C_pF        delta_C_fF\n";
  for (const CurvePoint& c : a.curve) {
    out += fmt::format("  {:<9}  {:>12.3f}  {:<10.5f}  {}\n", to_string(c.direction),
                       c.pressure_kPa, c.capacitance_pF,
                       c.delta_C_fF ? with_error(*c.delta_C_fF, c.standard_error_fF) : "-");
  }
}

void append_cycles(std::string& out, const RunAnalysis& a) {
  if (a.cycles.empty()) return;
  out +=
      "\nLoadings\n  no  peak_s      force_N  rest_pF    peak_pF    delta_C_fF          percent\n";
  for (const CycleResult& c : a.cycles) {
    if (c.number > static_cast<std::int32_t>(kRows)) {
      out += fmt::format("  ... {} more (--json has all)\n", a.cycles.size() - kRows);
      break;
    }
    out += fmt::format(
        "  {:<3} {:<11.3f} {:<8.4f} {:<10.5f} {:<10.5f} {:<19} {}\n", c.number, c.peak_s,
        c.peak_force_N, c.rest_pF, c.peak_pF, with_error(c.delta_C_fF, c.delta_C_se_fF),
        a.c0 ? with_error(c.dynamic_range_percent, c.dynamic_range_se_percent) : "-");
  }
}

void append_uncertainty(std::string& out, const Uncertainty& b) {
  out += fmt::format("\nUncertainty of {}: {:.6g} {}\n", b.quantity, b.value, b.unit);
  if (!b.estimand.empty()) out += fmt::format("  {}\n", b.estimand);
  for (const UncertaintyPart& p : b.parts) {
    if (p.is_gap) continue;
    const std::string freedom =
        std::isfinite(p.degrees_of_freedom) ? fmt::format("{:.0f}", p.degrees_of_freedom) : "inf";
    out += fmt::format("  {:<24} {:<10.3g} {} {:<5} {:<8} {}\n", p.name, p.standard_uncertainty,
                       to_string(p.kind), freedom, p.shrinks ? "shrinks" : "stays", p.basis);
  }
  out += fmt::format("  combined {:.3g}, expanded {}{:.3g} (k = {:.2f}, {:g} %)\n", b.combined,
                     b.gaps().empty() ? "" : "at least ", b.expanded, b.coverage_factor,
                     b.confidence * 100);
  for (const UncertaintyPart& p : b.parts) {
    if (p.is_gap) out += fmt::format("  not included: {}: {}\n", p.name, p.basis);
  }
}

void append_outliers(std::string& out, const RunAnalysis& a) {
  if (a.outliers.empty()) return;
  out += fmt::format("\nOutliers ({})\n", a.outlier_count);
  for (std::size_t i = 0; i < a.outliers.size() && i < 10; ++i) {
    const Outlier& o = a.outliers[i];
    out += fmt::format("  t {:.3f} s, level {}, reading {}: {:+.1f} fF, {:+.1f} sigma\n", o.t_s,
                       o.level, o.index, o.deviation_fF, o.deviations);
  }
}

void append_regions(std::string& out, const RunAnalysis& a) {
  if (!a.regions) return;
  out += "\nTwo regions\n";
  if (!a.regions->reason.empty()) {
    out += fmt::format("  - ({})\n", a.regions->reason);
    return;
  }
  append_range(out, a.regions->low);
  append_range(out, a.regions->high);
  out += fmt::format("  one line would do as well with p = {:.2g}\n", a.regions->p_one_line);
}

}  // namespace

std::string to_text(const RunAnalysis& a) {
  std::string out = a.pressure.words();
  if (!out.empty()) out += '\n';
  const std::string origin = origin_of(a.conditions);
  out += fmt::format("run {}: {}, specimen {}, {}{}\n", a.run, printable(a.protocol, 60),
                     a.specimen.empty() ? "-" : printable(a.specimen, 60), a.function,
                     origin.empty() ? "" : " (" + origin + ")");
  for (const std::string& note : a.notes) out += fmt::format("  note: {}\n", printable(note, 1000));
  out += fmt::format(
      "\nResults: value +- standard error, {:g} % interval, readings\n"
      "  interval: {}\n  expanded (below): {}\n",
      a.options.confidence * 100, kOfScatter, kOfAll);
  std::size_t range = 0;
  for (const Metric* m : a.metrics()) {
    if (range < a.ranges.size() && m == &a.ranges[range].sensitivity) {
      append_range(out, a.ranges[range++]);
    } else {
      append_metric(out, m->name, *m, a.uncertainty_of(*m));
    }
  }
  append_regions(out, a);
  append_curve(out, a);
  append_cycles(out, a);
  append_outliers(out, a);
  for (const Uncertainty& b : a.uncertainties) append_uncertainty(out, b);
  return out;
}

}  // namespace lcrig
