// SPDX-License-Identifier: Apache-2.0
// Force against travel, with the corridor that the watch judged it by.
#include <algorithm>
#include <cmath>

#include "analysis/report/figures.hpp"

namespace lcrig::report {

namespace {

plot::Series edge(const WatchPicture& watch, const std::vector<double>& force_N,
                  std::string label) {
  plot::Series series;
  series.label = std::move(label);
  series.x = watch.travel_mm;
  series.y = force_N;
  series.style = plot::line_style(1);
  series.style.width = 1;
  return series;
}

// The lowest of the forces and of the edge, but not below `least_N`.
double nearest(const std::vector<double>& force_N, const std::vector<double>& edge_N,
               double least_N) {
  double low = std::ranges::min(force_N);
  for (const double e : edge_N) low = std::min(low, std::isnan(e) ? low : std::max(e, least_N));
  return low - 0.05 * std::abs(low) - 0.005;
}

std::vector<double> negative(std::vector<double> values) {
  for (double& v : values) v = -v;
  return values;
}

}  // namespace

std::string watch_figure(const ReportRun& run) {
  if (!run.watch || run.watch->force_N.empty()) return {};
  const WatchPicture& watch = *run.watch;
  plot::Panel panel;
  panel.x.label = "travel, mm";
  panel.y.label = "force, N";
  // An edge may be far from everything that happened.
  const double most_N = std::ranges::max(watch.force_N, {}, [](double f) { return std::abs(f); });
  panel.y.low = nearest(watch.force_N, watch.low_N, -std::abs(most_N));
  panel.y.high = -nearest(negative(watch.force_N), negative(watch.high_N), -2.5 * std::abs(most_N));
  plot::Series shown;
  shown.label = "shown force";
  shown.x = watch.travel_mm;
  shown.y = watch.force_N;
  shown.style = plot::line_style(0);
  panel.series.push_back(edge(watch, watch.low_N, "lowest force that the order allows"));
  panel.series.push_back(edge(watch, watch.high_N, "highest force that was predicted"));
  panel.series.back().style = plot::line_style(2);
  panel.series.push_back(std::move(shown));
  if (watch.outside) {
    plot::Series outside;
    outside.label = "the sample that stopped the run";
    outside.style = plot::mark_style(0);
    outside.add(watch.travel_mm[*watch.outside], watch.force_N[*watch.outside]);
    panel.series.push_back(std::move(outside));
  }
  const std::string caption =
      watch.outside
          ? "The motion in which the watch over the frame stopped the run. Every edge is a "
            "sum of terms (docs/watch.md)."
          : "The motion with the largest force. A sample outside the edges would have "
            "stopped the run. Every edge is a sum of terms (docs/watch.md).";
  return figure_html(std::move(panel), "Force against travel between the edges of the corridor",
                     caption);
}

}  // namespace lcrig::report
