// SPDX-License-Identifier: Apache-2.0
// The pictures over pressure and over force.
#include "analysis/report/figures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/report/html.hpp"

namespace lcrig::report {

namespace {

constexpr std::string_view kGrey = "#8a8a8a";

plot::Style dots(std::string_view color) {
  return {.color = color, .marker = plot::Marker::dot, .line = false};
}

plot::Style marks(Direction direction) {
  return plot::mark_style(direction == Direction::up ? 0 : 1);
}

// Calls `take` with each loaded reading of the cycles, relative to the rest before it.
template <class Take>
void each_loaded(const ReportRun& run, Take take) {
  const double rest_N = run.data.rest_force_N.value_or(0);
  for (const CycleResult& cycle : run.analysis.cycles) {
    for (std::size_t i = cycle.first; i < cycle.last; ++i) {
      const RunReading& r = run.data.readings[i];
      if (!r.has_force()) continue;
      take(r.force_N - rest_N, (r.capacitance_F * 1e12 - cycle.rest_pF) * 1e3,
           r.t_s <= cycle.peak_s);
    }
  }
}

// Adds every level of every repeat. A run without levels shows every loaded reading.
void add_single_points(const ReportRun& run, plot::Panel& panel) {
  plot::Series up, down;
  if (!run.analysis.levels.empty()) {
    for (const auto& level : run.analysis.levels) {
      if (!level.delta_C_fF) continue;
      up.add(level.pressure_kPa, *level.delta_C_fF);
    }
    up.label = "each level of each repeat";
    up.style = dots(kGrey);
  } else {
    if (!run.data.area_m2) return;
    each_loaded(run, [&](double force_N, double delta_fF, bool loading) {
      plot::Series& to = loading ? up : down;
      to.add(force_N / *run.data.area_m2 * 1e-3, delta_fF);
    });
    up.label = "loading, each reading";
    up.style = plot::mark_style(0);
    down.label = "unloading, each reading";
    down.style = plot::mark_style(1);
  }
  for (plot::Series* series : {&up, &down}) {
    if (!series->x.empty()) panel.series.push_back(std::move(*series));
  }
}

void add_means(const ReportRun& run, plot::Panel& panel) {
  for (const Direction direction : {Direction::up, Direction::down}) {
    plot::Series series;
    series.style = marks(direction);
    series.label = direction == Direction::up ? "mean, rising pressure" : "mean, falling pressure";
    add_curve(run, direction, std::move(series), panel);
  }
}

bool has_line(const RangeResult& r) {
  return r.sensitivity && r.mean_kPa && r.mean_delta_C_fF;
}

double line_at(const RangeResult& r, double kPa) {
  return *r.mean_delta_C_fF + r.sensitivity.value() * (kPa - *r.mean_kPa);
}

// The part of a range in which something was measured.
std::vector<double> measured_part(const plot::Panel& panel, const PressureRange& range) {
  double low = range.to_kPa, high = range.from_kPa;
  for (const auto& series : panel.series) {
    for (const double kPa : series.x) {
      if (kPa < range.from_kPa - 0.5 || kPa > range.to_kPa + 0.5) continue;  // noise of the force
      low = std::min(low, kPa);
      high = std::max(high, kPa);
    }
  }
  return {low, high};
}

void add_fits(const ReportRun& run, Labels labels, plot::Panel& panel) {
  std::size_t n = 0;
  std::vector<plot::Series> lines;
  for (const RangeResult& r : run.analysis.ranges) {
    plot::Range shade;
    shade.from = r.range.from_kPa;
    shade.to = r.range.to_kPa;
    shade.label = labels == Labels::whole ? range_name(r.range) : range_numbers(r.range);
    panel.ranges.push_back(shade);
    ++n;
    if (!has_line(r)) continue;
    plot::Series line;
    line.x = measured_part(panel, r.range);
    for (const double kPa : line.x) line.y.push_back(line_at(r, kPa));
    const auto se = r.sensitivity.estimate->standard_error;
    line.label =
        fmt::format("{}: {}{} fF/kPa", range_name(r.range), plain_number(r.sensitivity.value(), se),
                    se && labels == Labels::whole ? " ± " + plain_number(*se, se) : "");
    line.style = plot::line_style(n);
    line.style.width = 2;
    lines.push_back(std::move(line));
  }
  for (auto& line : lines) panel.series.push_back(std::move(line));
}

void add_model(const ReportRun& run, plot::Panel& panel) {
  if (!run.model) return;
  plot::Series line;
  line.x = run.model->pressure_kPa;
  line.y = run.model->smooth_delta_C_fF;
  line.label = fmt::format("model, level {}", run.model->level);
  line.style.color = "#555555";
  line.style.dash = plot::Dash::dotted;
  panel.series.push_back(std::move(line));
}

// Residuals of the points that the fit used: levels, or the readings at rising pressure.
plot::Panel residual_panel(const ReportRun& run) {
  plot::Panel panel;
  panel.title = "Residuals of the fits";
  panel.y.label = "ΔC − fit, fF";
  panel.height = 95;
  panel.rules.emplace_back();
  std::size_t n = 0;
  for (const RangeResult& r : run.analysis.ranges) {
    plot::Series series;
    series.style = plot::mark_style(n++);
    if (!has_line(r)) continue;
    series.label = range_name(r.range);
    const auto add = [&](double kPa, double delta_fF, double error) {
      if (kPa < r.range.from_kPa || kPa > r.range.to_kPa) return;
      series.add(kPa, delta_fF - line_at(r, kPa), error);
    };
    for (const auto& l : run.analysis.levels) {
      if (l.delta_C_fF) add(l.pressure_kPa, *l.delta_C_fF, l.standard_error_fF.value_or(0));
    }
    if (run.analysis.levels.empty() && run.data.area_m2) {
      each_loaded(run, [&](double force_N, double delta_fF, bool loading) {
        if (loading) add(force_N / *run.data.area_m2 * 1e-3, delta_fF, 0);
      });
    }
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

std::string run_label(const ReportRun& run) {
  return fmt::format("run {}, {}{}", run.data.run, run.data.row.specimen_name,
                     run.data.replayed        ? " (replayed)"
                     : run.data.row.simulated ? " (simulated)"
                                              : "");
}

void add_curve(const ReportRun& run, Direction direction, plot::Series series, plot::Panel& panel) {
  for (const CurvePoint& p : run.analysis.curve) {
    if (p.direction != direction || !p.delta_C_fF) continue;
    series.add(p.pressure_kPa, *p.delta_C_fF, p.standard_error_fF.value_or(0));
  }
  if (!series.x.empty()) panel.series.push_back(std::move(series));
}

std::string figure_html(const plot::Figure& figure, const std::string& caption) {
  return "<figure>\n" + plot::to_svg(figure, true) +
         (caption.empty() ? "" : "<figcaption>" + paragraph(caption, "small") + "</figcaption>\n") +
         "</figure>\n";
}

std::string figure_html(plot::Panel panel, std::string description, const std::string& caption) {
  plot::Figure figure;
  figure.description = std::move(description);
  figure.panels.push_back(std::move(panel));
  return figure_html(figure, caption);
}

plot::Panel curve_panel(const ReportRun& run, Labels labels) {
  plot::Panel panel;
  panel.x.label = "pressure, kPa";
  panel.y.label = "ΔC, fF";
  panel.x.with_zero = true;
  panel.height = 245;
  add_single_points(run, panel);
  add_means(run, panel);
  if (panel.series.empty()) return panel;
  add_fits(run, labels, panel);
  add_model(run, panel);
  return panel;
}

std::string curve_figure(const ReportRun& run) {
  plot::Figure figure;
  figure.description = "Change of capacitance against pressure with fits, and their residuals";
  figure.panels.push_back(curve_panel(run));
  if (figure.panels[0].series.empty()) return {};
  double most = 0;
  for (const auto& s : figure.panels[0].series) {
    for (const double kPa : s.x) most = std::max(most, kPa);
  }
  auto residuals = residual_panel(run);
  if (!residuals.series.empty()) figure.panels.push_back(std::move(residuals));
  for (auto& panel : figure.panels) {
    panel.x.label = "pressure, kPa";
    panel.x.low = -0.02 * most;
    panel.x.high = 1.03 * most;
  }
  return figure_html(figure,
                     "Bars are one standard error of the scatter. Shaded: the ranges of the fits.");
}

std::string model_figure(const ReportRun& run) {
  if (!run.model) return {};
  plot::Panel panel;
  panel.x.label = "pressure, kPa";
  panel.y.label = "ΔC measured − ΔC of the model, fF";
  panel.height = 150;
  panel.rules.emplace_back();
  for (const Direction direction : {Direction::up, Direction::down}) {
    plot::Series series;
    series.style = marks(direction);
    series.label = direction == Direction::up ? "rising pressure" : "falling pressure";
    for (std::size_t i = 0; i < run.analysis.curve.size(); ++i) {
      const CurvePoint& p = run.analysis.curve[i];
      if (p.direction != direction || !p.delta_C_fF) continue;
      series.add(p.pressure_kPa, *p.delta_C_fF - run.model->delta_C_fF[i],
                 p.standard_error_fF.value_or(0));
    }
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  if (panel.series.empty()) return {};
  return figure_html(std::move(panel), "Measured minus modelled change of capacitance",
                     "Bars are one standard error of the scatter.");
}

namespace {

// Loaded readings of one branch over all cycles, relative to the rest of their cycle.
plot::Series branch(const ReportRun& run, bool loading) {
  plot::Series series;
  series.label = loading ? "loading, each reading" : "unloading, each reading";
  series.style = dots(loading ? "#7f9cc9" : "#dba27c");
  each_loaded(run, [&](double force_N, double delta_fF, bool is_loading) {
    if (is_loading != loading) return;
    series.add(force_N, delta_fF);
  });
  return series;
}

void add_loop_means(const std::vector<LoopPoint>& loop, plot::Panel& panel) {
  plot::Series up, down;
  up.label = "loading, mean of the cycles";
  down.label = "unloading, mean of the cycles";
  up.style = plot::line_style(0);
  down.style = plot::line_style(1);
  up.style.width = down.style.width = 2;
  for (const LoopPoint& p : loop) {
    up.add(p.force_N, p.up_fF);
    down.add(p.force_N, p.down_fF);
  }
  panel.series.push_back(std::move(up));
  panel.series.push_back(std::move(down));
}

plot::Panel gap_panel(const std::vector<LoopPoint>& loop) {
  plot::Panel panel;
  panel.title = "Gap between the branches";
  panel.x.label = "force, N";
  panel.y.label = "C unloading − C loading, fF";
  panel.rules.emplace_back();
  plot::Series line;
  plot::Band band;
  band.label = "± 2 standard errors";
  line.label = "gap";
  line.style = plot::line_style(0);
  for (const LoopPoint& p : loop) {
    const double gap = p.down_fF - p.up_fF;
    line.add(p.force_N, gap);
    band.x.push_back(p.force_N);
    band.low.push_back(gap - 2 * p.gap_se_fF);
    band.high.push_back(gap + 2 * p.gap_se_fF);
  }
  panel.series.push_back(std::move(line));
  panel.bands.push_back(std::move(band));
  return panel;
}

}  // namespace

std::string loop_figure(const ReportRun& run) {
  const Metric& gap = run.analysis.hysteresis.largest_gap;
  if (run.analysis.cycles.empty()) return {};
  if (run.analysis.hysteresis.loop.empty()) return paragraph(text(gap.reason) + ".");
  plot::Panel panel;
  panel.title = "Loading and unloading";
  panel.x.label = "force, N";
  panel.y.label = "C − C at rest, fF";
  for (const bool loading : {true, false}) {
    auto series = branch(run, loading);
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  if (panel.series.empty()) return {};
  plot::Figure figure;
  figure.description = "Capacitance against force while loading and unloading";
  figure.columns = 2;
  add_loop_means(run.analysis.hysteresis.loop, panel);
  figure.panels.push_back(std::move(panel));
  figure.panels.push_back(gap_panel(run.analysis.hysteresis.loop));
  return figure_html(figure, "Force is that of the middle of each measuring window. Largest gap: " +
                                 measured(gap) + " % of the span" +
                                 (gap.reason.empty() ? "." : " (" + text(gap.reason) + ")."));
}

}  // namespace lcrig::report
