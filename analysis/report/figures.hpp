// SPDX-License-Identifier: Apache-2.0
// The pictures of a report. Private to the report. An empty text: the run has nothing to show.
#pragma once

#include <span>
#include <string>

#include "analysis/report/report.hpp"
#include "plot/chart.hpp"

namespace lcrig::report {

// ΔC against pressure with fits, ranges and the model; below it the residuals.
std::string curve_figure(const ReportRun& run);
// Measured minus modelled ΔC.
std::string model_figure(const ReportRun& run);
// C(t) above F(t).
std::string time_figure(const ReportRun& run);
// ΔC/C0 over time with the extrema of each cycle.
std::string cycle_figure(const ReportRun& run);
// Loading and unloading against force, and the gap between them.
std::string loop_figure(const ReportRun& run);
// Force against travel with the corridor of the watch.
std::string watch_figure(const ReportRun& run);
// C in the longest holds against the logarithm of time.
std::string hold_figure(const ReportRun& run);

// Several runs: ΔC against pressure in one picture and side by side, and their cycles.
std::string overlay_figure(std::span<const ReportRun> runs);
std::string side_by_side_figure(std::span<const ReportRun> runs);
std::string cycles_side_by_side_figure(std::span<const ReportRun> runs);

// Parts that several pictures share.
enum class Labels { whole, brief };  // brief: ranges without unit, fits without errors
plot::Panel curve_panel(const ReportRun& run, Labels labels = Labels::whole);
plot::Panel cycle_panel(const ReportRun& run);
// Adds the means of the repeats in one direction of the pressure.
void add_curve(const ReportRun& run, Direction direction, plot::Series series, plot::Panel& panel);
std::string figure_html(const plot::Figure& figure, const std::string& caption);
std::string figure_html(plot::Panel panel, std::string description, const std::string& caption);
std::string run_label(const ReportRun& run);  // "run 3, paper-2 (simulated)"; plain text

}  // namespace lcrig::report
