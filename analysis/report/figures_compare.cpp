// SPDX-License-Identifier: Apache-2.0
// Pictures that show several runs.
#include <algorithm>
#include <cmath>

#include "analysis/report/figures.hpp"

namespace lcrig::report {

namespace {

constexpr int kMostColumns = 3;

// A panel for one run that stands beside others: single points and repeated labels are left out.
plot::Panel slim_curve_panel(const ReportRun& run) {
  plot::Panel panel = curve_panel(run, Labels::brief);
  panel.title = run_label(run);
  panel.height = 260;
  std::erase_if(panel.series,
                [&](const plot::Series& s) { return s.style.marker == plot::Marker::dot; });
  return panel;
}

int columns_for(std::size_t panels) {
  return std::clamp(static_cast<int>(panels), 1, kMostColumns);
}

// Gives all panels the same y axis, so that heights can be compared.
void share_y(std::vector<plot::Panel>& panels) {
  double low = INFINITY, high = -INFINITY;
  for (const auto& panel : panels) {
    for (const auto& series : panel.series) {
      for (const double y : series.y) {
        if (!std::isfinite(y)) continue;
        low = std::min(low, y);
        high = std::max(high, y);
      }
    }
  }
  if (!(high > low)) return;
  const double air = 0.08 * (high - low);
  for (auto& panel : panels) {
    panel.y.low = low - air;
    panel.y.high = high + air;
  }
}

}  // namespace

std::string overlay_figure(std::span<const ReportRun> runs) {
  plot::Panel panel;
  panel.x.label = "pressure, kPa";
  panel.y.label = "ΔC, fF";
  panel.x.with_zero = panel.y.with_zero = true;
  panel.height = 300;
  std::size_t n = 0;
  for (const ReportRun& run : runs) {
    plot::Series series;
    series.label = run_label(run);
    series.style = plot::mark_style(n);
    series.style.dash = plot::line_style(n).dash;
    series.style.line = true;
    ++n;
    add_curve(run, Direction::up, std::move(series), panel);
  }
  if (panel.series.empty()) return {};
  return figure_html(std::move(panel), "Change of capacitance against pressure of all runs",
                     "Rising pressure, means of the repeats.");
}

std::string side_by_side_figure(std::span<const ReportRun> runs) {
  plot::Figure figure;
  figure.description = "Change of capacitance against pressure with fits, run by run";
  for (const ReportRun& run : runs) {
    auto panel = slim_curve_panel(run);
    if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  }
  if (figure.panels.empty()) return {};
  figure.columns = columns_for(figure.panels.size());
  return figure_html(figure, "Each with an axis of its own; shaded: the ranges of the fits.");
}

std::string cycles_side_by_side_figure(std::span<const ReportRun> runs) {
  plot::Figure figure;
  figure.description = "Relative change of capacitance over time, run by run";
  for (const ReportRun& run : runs) {
    auto panel = cycle_panel(run);
    if (panel.series.empty()) continue;
    panel.title = run_label(run);
    panel.height = 170;
    figure.panels.push_back(std::move(panel));
  }
  if (figure.panels.empty()) return {};
  share_y(figure.panels);
  return figure_html(figure, "The numbers are the dynamic range of each cycle.");
}

}  // namespace lcrig::report
