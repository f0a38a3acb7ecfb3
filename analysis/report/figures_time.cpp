// SPDX-License-Identifier: Apache-2.0
// The pictures over time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/report/figures.hpp"
#include "analysis/report/html.hpp"
#include "base/online.hpp"

namespace lcrig::report {

namespace {

constexpr double kBreak = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostTags = 24;
constexpr std::size_t kMostHolds = 4;

// The time between readings beyond which a line is broken: several times the usual one.
double longest_step(const std::vector<RunReading>& readings) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    steps.push_back(readings[i].t_s - readings[i - 1].t_s);
  }
  if (steps.empty()) return 1;
  return 8 * upper_median(steps);
}

// Readings over time, converted by `value`. The line is broken where no readings were taken.
template <class Value>
plot::Series over_time(const ReportRun& run, Value value) {
  plot::Series series;
  const double most = longest_step(run.data.readings);
  double before = -INFINITY;
  for (const RunReading& r : run.data.readings) {
    if (r.t_s - before > most && !series.x.empty()) {
      series.add(r.t_s, kBreak);
    }
    series.add(r.t_s, value(r));
    before = r.t_s;
  }
  series.style = plot::line_style(0);
  series.style.width = 1;
  return series;
}

plot::Series force_over_time(const RunData& data) {
  plot::Series series;
  for (const FramePoint& p : data.frame) {
    if (p.after_gap && !series.x.empty()) {
      series.add(p.t_s, kBreak);
    }
    series.add(p.t_s, p.force_N);
  }
  series.style = plot::line_style(0);
  series.style.width = 1.2;
  return series;
}

// Adds the peaks and rests of the cycles, in percent of C0.
void add_extrema(const ReportRun& run, double c0_pF, plot::Panel& panel) {
  plot::Series peak, rest;
  const bool rises = std::ranges::all_of(run.analysis.cycles,
                                         [](const CycleResult& c) { return c.delta_C_fF >= 0; });
  peak.label = rises ? "maximum of the cycle" : "at the largest force of the cycle";
  peak.style = plot::mark_style(0);
  peak.style.color = "#000000";
  rest.label = rises ? "minimum (mean at rest)" : "mean at rest";
  rest.style = plot::mark_style(1);
  const auto percent_of = [&](double pF) { return (pF / c0_pF - 1) * 100; };
  double lowest = INFINITY, highest = -INFINITY;  // the tags must stand clear of the noise
  for (const double y : panel.series.front().y) {
    if (std::isnan(y)) continue;
    lowest = std::min(lowest, y);
    highest = std::max(highest, y);
  }
  panel.y.low = lowest - 0.12 * (highest - lowest);
  panel.y.high = highest + 0.16 * (highest - lowest);
  for (const CycleResult& c : run.analysis.cycles) {
    peak.add(c.peak_s, percent_of(c.peak_pF));
    rest.add(c.rest_s, percent_of(c.rest_pF));
    if (run.analysis.cycles.size() > kMostTags) continue;
    plot::Tag tag;
    tag.x = c.peak_s;
    tag.y = rises ? highest : peak.y.back();
    tag.text = plain_number(c.dynamic_range_percent, c.dynamic_range_se_percent) + " %";
    panel.tags.push_back(std::move(tag));
  }
  panel.series.push_back(std::move(peak));
  panel.series.push_back(std::move(rest));
}

}  // namespace

plot::Panel cycle_panel(const ReportRun& run) {
  plot::Panel panel;
  panel.x.label = "time, s";
  panel.y.label = "ΔC/C0, %";
  panel.height = 260;
  if (!run.analysis.c0 || run.analysis.cycles.empty()) return panel;
  const double c0_pF = run.analysis.c0.value();
  auto line = over_time(
      run, [&](const RunReading& r) { return (r.capacitance_F * 1e12 / c0_pF - 1) * 100; });
  line.label = "each reading";
  line.style.color = "#7f9cc9";
  panel.series.push_back(std::move(line));
  add_extrema(run, c0_pF, panel);
  return panel;
}

std::string cycle_figure(const ReportRun& run) {
  auto panel = cycle_panel(run);
  if (panel.series.empty()) return {};
  return figure_html(std::move(panel),
                     "Relative change of capacitance over time with the extrema of each cycle",
                     "The numbers are the dynamic range of each cycle: at the largest force less "
                     "at rest, over C0.");
}

std::string time_figure(const ReportRun& run) {
  plot::Figure figure;
  figure.description = "Capacitance and force over time";
  plot::Panel panel;
  panel.y.label = "C, pF";
  panel.height = 190;
  panel.series.push_back(
      over_time(run, [](const RunReading& r) { return r.capacitance_F * 1e12; }));
  figure.panels.push_back(std::move(panel));
  auto force = force_over_time(run.data);
  if (!force.x.empty()) {
    plot::Panel below;
    below.y.label = "force, N";
    below.height = 150;
    below.series.push_back(std::move(force));
    figure.panels.push_back(std::move(below));
  }
  for (auto& p : figure.panels) {
    p.x.label = "time since the start of the run, s";
    p.x.low = 0;
    p.x.high = std::max(run.data.duration_s, 1e-3);
  }
  return figure_html(figure, "");
}

namespace {

plot::Series hold_series(const ReportRun& run, const HoldResult& hold) {
  plot::Series series;
  double first = kBreak;
  for (const RunReading& r : run.data.readings) {
    if (r.t_s <= hold.begin_s || r.t_s > hold.end_s) continue;
    if (std::isnan(first)) first = r.capacitance_F;
    series.add(r.t_s - hold.begin_s, (r.capacitance_F - first) * 1e15);
  }
  series.label = fmt::format("{} at {:.0f} s, {} N", hold.step_id, hold.begin_s,
                             plain_number(hold.mean_force_N));
  return series;
}

}  // namespace

std::string hold_figure(const ReportRun& run) {
  std::vector<const HoldResult*> holds;
  for (const HoldResult& h : run.analysis.holds) {
    if (h.resolved && h.readings >= 10) holds.push_back(&h);
  }
  std::ranges::sort(holds, [](const auto* a, const auto* b) {
    return a->end_s - a->begin_s > b->end_s - b->begin_s;
  });
  holds.resize(std::min(holds.size(), kMostHolds));
  std::ranges::sort(holds, {}, &HoldResult::begin_s);
  plot::Panel panel;
  panel.x.label = "time since the hold began, s";
  panel.x.log = true;
  panel.y.label = "C − C at the begin of the hold, fF";
  panel.height = 200;
  for (const HoldResult* h : holds) {
    auto series = hold_series(run, *h);
    series.style = plot::line_style(panel.series.size());
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  if (panel.series.empty()) return {};
  return figure_html(std::move(panel), "Capacitance during holds against the logarithm of time",
                     "The longest holds whose change is larger than the noise.");
}

}  // namespace lcrig::report
