// SPDX-License-Identifier: Apache-2.0
#include "analysis/report/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/report/html.hpp"

namespace lcrig::report {

namespace {

constexpr std::size_t kMostRows = 200;  // of a table; the CSV export has all

Cell count(std::int64_t n) {
  return number(n);
}

std::string rows_left_out(std::size_t all) {
  if (all <= kMostRows) return {};
  return paragraph(fmt::format("The first {} of {}.", kMostRows, all), "small");
}

}  // namespace

std::string metric_label(const RunAnalysis& analysis, const Metric& metric) {
  const RangeResult* r = analysis.range_of(metric);
  return r == nullptr ? metric.label : "sensitivity " + range_name(r->range) + ", fF/kPa";
}

namespace {

// A hysteresis that was not found is quoted as how large it may be.
bool is_found(const RunAnalysis& analysis, const Metric& metric) {
  return &metric != &analysis.hysteresis.largest_gap || analysis.hysteresis.resolved;
}

std::string at_most(double value) {
  return "not resolved, at most " + number(value, value);
}

}  // namespace

Cell quoted(const RunAnalysis& analysis, const Metric& metric) {
  if (!metric) return measured(metric);
  const Estimate& e = *metric.estimate;
  const Uncertainty* u = analysis.uncertainty_of(metric);
  if (u == nullptr) {
    const std::string shown =
        !is_found(analysis, metric) && e.interval ? at_most((*e.interval)[1]) : measured(metric);
    return {shown + (e.standard_error ? " (standard error)" : ""), Cell::Kind::number};
  }
  const auto gaps = u->gaps();
  const std::string shown = !is_found(analysis, metric) ? at_most(e.value + u->expanded)
                            : gaps.empty()              ? measured(e.value, u->expanded)
                                           : number(e.value, u->expanded) + " ± at least " +
                                                 number(u->expanded, u->expanded);
  const std::string left_out =
      gaps.empty() ? "" : "; not included: " + text(fmt::format("{}", fmt::join(gaps, ", ")));
  return {fmt::format("{} ({:g} %, k = {}{})", shown, u->confidence * 100,
                      plain_number(u->coverage_factor), left_out),
          Cell::Kind::number};
}

std::string headline_table(const RunAnalysis& a) {
  Table table{"", "value ± expanded uncertainty<br/><small>for the specimen's own</small>",
              "not included", "remarks"};
  const auto row = [&](const Metric& m) {
    const Uncertainty* u = a.uncertainty_of(m);
    const std::string gaps =
        u == nullptr ? "errors of the rig" : fmt::format("{}", fmt::join(u->gaps(), ", "));
    table.row({text(metric_label(a, m)) + estimand_line(m.estimand), quoted(a, m),
               m ? text(gaps) : "", text(m.reason)});
  };
  row(a.c0);
  for (const RangeResult& r : a.ranges) row(r.sensitivity);
  for (const Metric* m :
       {&a.delta_C, &a.dynamic_range, &a.force_sensitivity, &a.hysteresis.largest_gap,
        &a.repeatability_2sigma, &a.creep, &a.limit_of_detection}) {
    if (*m) row(*m);
  }
  return table.html();
}

std::string metrics_table(const RunAnalysis& analysis) {
  Table table{"result", "value ± standard error", interval_head(analysis.options.confidence),
              "rows", "definition"};
  for (const Metric* m : analysis.metrics()) {
    const std::string label = text(metric_label(analysis, *m)) + estimand_line(m->estimand);
    const bool known = static_cast<bool>(*m);
    std::string definition = text(m->definition);
    if (known && !m->reason.empty()) definition += " <i>" + text(m->reason) + "</i>";
    table.row({label, measured(*m),
               known ? interval(m->estimate->interval, m->estimate->standard_error) : no_number(),
               count(m->rows), definition});
  }
  return table.html();
}

namespace {

// The expanded uncertainty, a lower limit where a part of it is not known.
Cell at_least(const Uncertainty& u) {
  return {(u.gaps().empty() ? "" : "at least ") + number(u.expanded, u.combined),
          Cell::Kind::number};
}

std::string table_of_ranges(const std::vector<const RangeResult*>& ranges, double confidence) {
  Table table{"range",
              "sensitivity, fF/kPa",
              interval_head(confidence),
              "with all parts, ±<br/><small>for the specimen's own</small>",
              "R²",
              "points",
              "straight? p",
              "residuals",
              "robust (Huber), fF/kPa"};
  for (const RangeResult* range : ranges) {
    const RangeResult& r = *range;
    if (!r.sensitivity) {
      table.row({range_name(r.range), text(r.sensitivity.reason), no_number(), no_number(),
                 no_number(), count(r.points), no_number(), no_number(), no_number()});
      continue;
    }
    const auto& estimate = *r.sensitivity.estimate;
    table.row(
        {range_name(r.range) + estimand_line(r.sensitivity.estimand),
         measured(estimate.value, estimate.standard_error),
         interval(estimate.interval, estimate.standard_error),
         r.uncertainty.parts.empty() ? no_number() : at_least(r.uncertainty), number(r.r_squared),
         count(r.points), number(r.lack_of_fit_p), text(r.residual_pattern),
         r.robust ? measured(r.robust->slope_fF_per_kPa, r.robust->standard_error) : no_number()});
  }
  return table.html();
}

std::string region_table(const RunAnalysis& analysis) {
  if (!analysis.regions) return {};
  const RegionSearch& found = *analysis.regions;
  std::string out = "<h3>Two regions</h3>\n";
  if (!found.reason.empty()) return out + paragraph("None: " + text(found.reason) + ".");
  return out + table_of_ranges({&found.low, &found.high}, analysis.options.confidence) +
         paragraph("One line would do as well with p = " + plain_number(found.p_one_line) + ".");
}

}  // namespace

std::string range_table(const RunAnalysis& analysis) {
  std::vector<const RangeResult*> ranges;
  for (const RangeResult& r : analysis.ranges) ranges.push_back(&r);
  return table_of_ranges(ranges, analysis.options.confidence) + region_table(analysis);
}

namespace {

// Compares the peaks with the model. For a continuous loading, which has no levels.
std::string peak_table(const ReportRun& run) {
  if (!run.model) return {};
  Table table{"cycle", "peak, kPa", "ΔC, fF", "model ΔC, fF", "difference, fF", "difference, %"};
  for (std::size_t i = 0; i < std::min(run.analysis.cycles.size(), kMostRows); ++i) {
    const CycleResult& c = run.analysis.cycles[i];
    if (!c.peak_kPa || i >= run.model->peak_delta_C_fF.size()) continue;
    const double modelled = run.model->peak_delta_C_fF[i];
    const auto se = c.delta_C_se_fF;
    const auto relative = se ? std::optional(*se / std::abs(modelled) * 100) : se;
    table.row({count(c.number), number(*c.peak_kPa), measured(c.delta_C_fF, se),
               number(modelled, se), number(c.delta_C_fF - modelled, se),
               number((c.delta_C_fF / modelled - 1) * 100, relative)});
  }
  return table.empty() ? std::string() : table.html();
}

// Beyond a million, Student's t equals the normal distribution in all digits that are shown.
Cell degrees(double of_freedom) {
  if (!std::isfinite(of_freedom)) return "∞";
  const std::string shown = of_freedom < 1e6 ? fmt::format("{:.0f}", of_freedom) : "∞";
  return {fmt::format("<data value='{}'>{}</data>", of_freedom, shown), Cell::Kind::number};
}

}  // namespace

std::string level_table(const ReportRun& run) {
  Table table{"direction", "pressure, kPa", "C, pF",          "ΔC, fF",
              "readings",  "model ΔC, fF",  "difference, fF", "difference, %"};
  for (std::size_t i = 0; i < run.analysis.curve.size(); ++i) {
    const CurvePoint& p = run.analysis.curve[i];
    const auto se = p.standard_error_fF;
    Cell model = no_number(), difference = no_number(), relative = no_number();
    if (run.model && p.delta_C_fF) {
      const double modelled = run.model->delta_C_fF[i];
      model = number(modelled, se);
      difference = number(*p.delta_C_fF - modelled, se);
      if (modelled != 0) {
        const double percent = (*p.delta_C_fF / modelled - 1) * 100;
        relative = number(percent, se ? std::optional(*se / std::abs(modelled) * 100) : se);
      }
    }
    table.row({std::string(to_string(p.direction)), number(p.pressure_kPa),
               number(p.capacitance_pF, se ? std::optional(*se * 1e-3) : se),
               p.delta_C_fF ? measured(*p.delta_C_fF, se) : no_number(), count(p.readings), model,
               difference, relative});
  }
  return table.empty() ? peak_table(run) : table.html();
}

std::string cycle_table(const RunAnalysis& analysis) {
  Table table{"cycle",
              "peak force, N",
              "peak, kPa",
              "at rest, pF",
              "at peak, pF",
              "ΔC, fF",
              "ΔC/C0, %",
              "slope of loading, fF/N",
              "how the peak was read"};
  for (std::size_t i = 0; i < std::min(analysis.cycles.size(), kMostRows); ++i) {
    const CycleResult& c = analysis.cycles[i];
    const auto pF_error = [](const std::optional<double>& fF) {
      return fF ? std::optional(*fF * 1e-3) : fF;
    };
    table.row({count(c.number), number(c.peak_force_N), number(c.peak_kPa),
               number(c.rest_pF, pF_error(c.rest_se_fF)), number(c.peak_pF, pF_error(c.peak_se_fF)),
               measured(c.delta_C_fF, c.delta_C_se_fF),
               measured(c.dynamic_range_percent, c.dynamic_range_se_percent),
               c.slope_fF_per_N ? measured(*c.slope_fF_per_N, c.slope_se_fF_per_N) : no_number(),
               text(std::string(to_string(c.peak_method)))});
  }
  if (table.empty()) return {};
  return table.html() + rows_left_out(analysis.cycles.size());
}

std::string hold_table(const RunAnalysis& analysis) {
  Table table{"step",           "from, s",          "to, s",
              "force, N",       "force change, %",  "change of C, fF",
              "per decade, fF", "settled after, s", "remark"};
  const auto optional = [](const std::optional<double>& v, const std::optional<double>& se) {
    return v ? measured(*v, se) : no_number();
  };
  std::size_t resolved = 0;
  for (const HoldResult& h : analysis.holds) {
    if (!h.resolved || ++resolved > kMostRows) continue;
    table.row({text(h.step_id), number(h.begin_s, 1.0), number(h.end_s, 1.0),
               number(h.mean_force_N), number(h.force_change_percent),
               measured(h.change_fF, h.change_se_fF), optional(h.per_decade_fF, h.per_decade_se_fF),
               number(h.settling_s), text(h.reason)});
  }
  if (analysis.holds.empty()) return {};
  std::string out = paragraph(
      fmt::format("{} stretches of steady load; in {} of them C changes by more than its noise.",
                  analysis.holds.size(), resolved));
  if (analysis.creep) {
    out += paragraph("Creep over all: " + measured(analysis.creep) + " % per decade of time.");
  }
  return table.empty() ? out : out + table.html() + rows_left_out(resolved);
}

std::string outlier_table(const RunAnalysis& analysis) {
  if (analysis.outlier_count == 0) return {};
  Table table{"time, s", "level", "reading", "C, pF", "from the median, fF", "standard deviations"};
  for (std::size_t i = 0; i < std::min(analysis.outliers.size(), kMostRows); ++i) {
    const Outlier& o = analysis.outliers[i];
    table.row({number(o.t_s, 1.0), count(o.level), count(o.index), number(o.capacitance_pF),
               number(o.deviation_fF), number(o.deviations)});
  }
  return paragraph(fmt::format("{} readings lie far from the median of their level. They are kept "
                               "in every result but the robust ones, the noise and the drift.",
                               analysis.outlier_count)) +
         table.html() + rows_left_out(static_cast<std::size_t>(analysis.outlier_count));
}

std::string uncertainty_tables(const std::vector<Uncertainty>& uncertainties) {
  std::string out;
  for (const Uncertainty& b : uncertainties) {
    if (b.parts.empty()) continue;
    const double k = b.coverage_factor;
    out += "<h4>" + text(b.quantity) + ": " + number(b.value, b.combined) + " " + text(b.unit) +
           " ± " + at_least(b) +
           fmt::format(" ({:.0f} %, k = {})", b.confidence * 100, plain_number(k)) + "</h4>\n";
    if (!b.estimand.empty()) out += paragraph(text(b.estimand), "small");
    Table table{"part",
                "standard uncertainty, " + text(b.unit),
                "of the variance, %",
                "kind",
                "degrees of freedom",
                "more readings",
                "basis"};
    for (const UncertaintyPart& p : b.parts) {
      if (p.is_gap) continue;
      const double share = b.combined > 0 ? std::pow(p.standard_uncertainty / b.combined, 2) : 0;
      table.row({text(p.name),
                 number(p.standard_uncertainty, p.standard_uncertainty),
                 {fmt::format("<data value='{}'>{:.1f}</data>", share * 100, share * 100),
                  Cell::Kind::number},
                 std::string(to_string(p.kind)),
                 degrees(p.degrees_of_freedom),
                 p.shrinks ? "shrink it" : "do not help",
                 text(p.basis)});
    }
    table.row({"<b>combined</b>", number(b.combined, b.combined), "", "",
               degrees(b.effective_degrees_of_freedom), "", ""});
    out += table.html();
    for (const UncertaintyPart& p : b.parts) {
      if (p.is_gap) {
        out += paragraph("Not included: <b>" + text(p.name) + "</b>: " + text(p.basis) + ".");
      }
    }
  }
  return out;
}

}  // namespace lcrig::report
