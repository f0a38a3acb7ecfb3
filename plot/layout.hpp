// SPDX-License-Identifier: Apache-2.0
// Computes where the parts of one panel go. Used by chart.cpp only.
#pragma once

#include <cmath>

#include "plot/chart.hpp"
#include "plot/ticks.hpp"

namespace lcrig::plot {

constexpr double kFont = 12.5;  // pixels
constexpr double kLine = 18;  // of text

// Converts a value to a pixel.
struct Scale {
  double low = 0, high = 1;
  bool log = false;
  double from = 0, to = 1;
  // true if finite, and positive on a logarithmic axis
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0); }
  double operator()(double value) const;
  // As operator(), limited to the axis. A value that the axis cannot show goes to its low end.
  double clamped(double value) const;
};

struct LegendEntry {
  const Series* series = nullptr;  // nullptr: a band
  std::string text;
  double x = 0, y = 0;  // of the symbol's left end and of the text's base line
};

struct PanelLayout {
  std::vector<std::string> title;
  std::vector<std::string> y_label;
  std::vector<LegendEntry> legend;  // relative to the panel's corner
  Ticks x_ticks, y_ticks;
  Scale x, y;  // pixels relative to the panel's corner
  double head = 0;  // height of everything above the plot
  double left = 0, right = 0;  // margins
  double width = 0, height = 0;  // of the panel
  bool empty = false;
};

// The left margin that the labels of the y axis need.
double wanted_left_margin(const Panel& panel);
// Lays out one panel. `left` is the margin that a column of panels shares. The head is at least
// `head` high, so that plots side by side are aligned.
PanelLayout lay_out(const Panel& panel, double width, double left, double head = 0);

}  // namespace lcrig::plot
