// SPDX-License-Identifier: Apache-2.0
#include "plot/layout.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "plot/text.hpp"

namespace lcrig::plot {

namespace {

constexpr double kSymbol = 34;  // width of a legend entry's symbol and the gap after it
constexpr double kMostLegendText = 330;
constexpr double kTickGap = 6;

struct Extent {
  double low = INFINITY, high = -INFINITY;
  bool log = false;
  void add(double v) {
    if (!std::isfinite(v) || (log && v <= 0)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  void add(std::span<const double> values) {
    for (const double v : values) add(v);
  }
};

Extent extent_x(const Panel& p) {
  Extent e;
  e.log = p.x.log;
  for (const auto& s : p.series) e.add(s.x);
  for (const auto& b : p.bands) e.add(b.x);
  for (const auto& r : p.ranges) {
    e.add(r.from);
    e.add(r.to);
  }
  for (const auto& r : p.rules) {
    if (r.vertical) e.add(r.at);
  }
  if (p.x.with_zero) e.add(0.0);
  return e;
}

Extent extent_y(const Panel& p) {
  Extent e;
  e.log = p.y.log;
  for (const auto& s : p.series) {
    e.add(s.y);
    for (std::size_t i = 0; i < std::min(s.error.size(), s.y.size()); ++i) {
      e.add(s.y[i] - s.error[i]);
      e.add(s.y[i] + s.error[i]);
    }
  }
  for (const auto& b : p.bands) {
    e.add(b.low);
    e.add(b.high);
  }
  for (const auto& r : p.rules) {
    if (!r.vertical) e.add(r.at);
  }
  if (p.y.with_zero) e.add(0.0);
  return e;
}

// An axis that covers the data, with a small margin on both sides.
Scale scale_of(const Axis& axis, Extent e, bool& empty) {
  Scale s;
  s.log = axis.log;
  empty = empty || (e.low > e.high && !(axis.low && axis.high));
  if (e.low > e.high) {
    e.low = axis.low.value_or(s.log ? 1 : 0);
    e.high = axis.high.value_or(s.log ? 10 : 1);
  }
  if (s.log) {
    const double air = std::pow(10, std::max(0.04 * std::log10(e.high / e.low), 0.1));
    s.low = e.low / air;
    s.high = e.high * air;
  } else {
    const double span = e.high - e.low;
    const double about = std::max(std::abs(e.high), std::abs(e.low));
    const double flat = about > 0 ? 0.05 * about : 1;
    const double air = span > 1e-12 * about ? 0.04 * span : flat;
    s.low = e.low - (axis.with_zero && e.low == 0 ? 0 : air);
    s.high = e.high + air;
  }
  s.low = axis.low.value_or(s.low);
  s.high = axis.high.value_or(s.high);
  if (!(s.high > s.low)) s.high = s.low + std::max(1.0, std::abs(s.low));
  return s;
}

Ticks ticks_of(const Scale& s, int most) {
  return s.log ? log_ticks(s.low, s.high, most) : linear_ticks(s.low, s.high, most);
}

double widest(const Ticks& ticks) {
  double w = 0;
  for (const auto& label : ticks.labels) w = std::max(w, text_width(label, kFont));
  return w;
}

int y_tick_count(double height) {
  return std::max(4, static_cast<int>(height / 34));
}

// As many ticks as fit beside each other.
Ticks x_ticks_of(const Scale& s, double width) {
  for (int most = std::max(2, static_cast<int>(width / 48)); most > 2; --most) {
    Ticks ticks = ticks_of(s, most);
    const double each = widest(ticks) + 14;
    bool fits = true;
    for (std::size_t i = 1; i < ticks.at.size(); ++i) {
      fits = fits && std::abs(s(ticks.at[i]) - s(ticks.at[i - 1])) >= each;
    }
    if (fits) return ticks;
  }
  return ticks_of(s, 2);
}

double place_legend(const Panel& panel, PanelLayout& out, double top) {
  const double right = out.width - 4;
  double x = out.left, y = top;
  const auto add = [&](const Series* series, const std::string& label) {
    if (label.empty()) return;
    const double most = std::min(kMostLegendText, right - out.left - kSymbol);
    LegendEntry entry;
    entry.series = series;
    entry.text = cut_to_width(label, most, kFont);
    const double width = kSymbol + text_width(entry.text, kFont);
    if (x > out.left && x + width > right) {
      x = out.left;
      y += kLine;
    }
    entry.x = x;
    entry.y = y + 13;
    x += width + 16;
    out.legend.push_back(std::move(entry));
  };
  for (const auto& s : panel.series) add(&s, s.label);
  for (const auto& b : panel.bands) add(nullptr, b.label);
  return out.legend.empty() ? top : y + kLine + 3;
}

}  // namespace

double Scale::operator()(double value) const {
  const double part =
      log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return from + part * (to - from);
}

double Scale::clamped(double value) const {
  if (!shows(value)) return value == INFINITY ? to : from;
  const double pixel = (*this)(value);
  return std::clamp(pixel, std::min(from, to), std::max(from, to));
}

double wanted_left_margin(const Panel& panel) {
  bool empty = false;
  const Scale y = scale_of(panel.y, extent_y(panel), empty);
  return widest(ticks_of(y, y_tick_count(panel.height))) + kTickGap + 6;
}

PanelLayout lay_out(const Panel& panel, double width, double left, double least_head) {
  PanelLayout out;
  out.width = width;
  out.left = left;
  out.x = scale_of(panel.x, extent_x(panel), out.empty);
  out.y = scale_of(panel.y, extent_y(panel), out.empty);
  out.right = 14;
  out.x.from = left;
  out.x.to = width - out.right;
  out.x_ticks = x_ticks_of(out.x, out.x.to - out.x.from);
  for (std::size_t i = 0; i < out.x_ticks.at.size(); ++i) {  // the last label may stick out
    const double half = text_width(out.x_ticks.labels[i], kFont) / 2;
    out.right = std::max(out.right, out.x(out.x_ticks.at[i]) + half - width + out.right + 2);
  }
  out.x.to = width - out.right;
  out.y_ticks = ticks_of(out.y, y_tick_count(panel.height));
  out.title = wrap(panel.title, width - 8, kFont + 1);
  out.y_label = wrap(panel.y.label, width - 8, kFont);
  double head = 4 + kLine * static_cast<double>(out.title.size());
  head = place_legend(panel, out, head);
  head += kLine * static_cast<double>(out.y_label.size());
  const bool strip =
      std::ranges::any_of(panel.ranges, [](const Range& r) { return !r.label.empty(); });
  out.head = std::max(head + (strip ? kLine : 6), least_head);
  out.y.from = out.head + panel.height;
  out.y.to = out.head;
  out.height = out.y.from + 2 * kLine + 14;
  return out;
}

}  // namespace lcrig::plot
