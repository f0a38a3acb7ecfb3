// SPDX-License-Identifier: Apache-2.0
#include "plot/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "plot/layout.hpp"
#include "plot/marks.hpp"
#include "plot/text.hpp"

namespace lcrig::plot {

namespace {

// Colours by Okabe and Ito, in an order in which neighbours also differ in grey.
constexpr std::array<std::string_view, 6> kColors{"#0b3d91", "#c8500a", "#2f2f2f",
                                                  "#009e73", "#a0468c", "#7a6a00"};
constexpr std::array<Dash, 5> kDashes{Dash::solid, Dash::dashed, Dash::dash_dot, Dash::dotted,
                                      Dash::long_dash};
constexpr std::array<Marker, 7> kMarkers{Marker::circle,       Marker::square, Marker::triangle,
                                         Marker::diamond,      Marker::cross,  Marker::plus,
                                         Marker::triangle_down};
constexpr std::string_view kShade = "#ececec", kBandShade = "#c9d6e8", kGrid = "#dddddd";
constexpr double kThinMarksFrom = 400;  // points; with fewer than these, all are drawn
constexpr double kColumnGap = 24;

// Draws the part of a panel that is inside its frame.
class Pen {
 public:
  Pen(const Panel& panel, const PanelLayout& at) : panel_(panel), at_(at) {}
  std::string draw();

 private:
  Pixel place(double x, double y) const { return {at_.x(x), at_.y(y)}; }
  void grid();
  void ranges();
  void band(const Band& band);
  void rules();
  void series(const Series& series);
  void errors(const Series& series);
  void tags();
  bool put_tag(Pixel point, const Tag& tag);

  struct Box {
    double left, top, right, bottom;
  };
  const Panel& panel_;
  const PanelLayout& at_;
  std::string out_;
  std::vector<Box> taken_;
};

void Pen::grid() {
  const auto vertical = [&](double v, std::string_view color) {
    out_ += line_element({at_.x(v), at_.y.from}, {at_.x(v), at_.y.to}, color, 1, Dash::solid);
  };
  const auto horizontal = [&](double v, std::string_view color) {
    out_ += line_element({at_.x.from, at_.y(v)}, {at_.x.to, at_.y(v)}, color, 1, Dash::solid);
  };
  for (const double v : at_.x_ticks.minor) vertical(v, "#f1f1f1");
  for (const double v : at_.y_ticks.minor) horizontal(v, "#f1f1f1");
  for (const double v : at_.x_ticks.at) vertical(v, kGrid);
  for (const double v : at_.y_ticks.at) horizontal(v, kGrid);
}

void Pen::ranges() {
  for (const Range& r : panel_.ranges) {
    const double left = at_.x.clamped(r.from), right = at_.x.clamped(r.to);
    out_ += fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='{}'/>\n",
                        coordinate(left), coordinate(at_.y.to), coordinate(right - left),
                        coordinate(at_.y.from - at_.y.to), kShade);
    for (const double edge : {left, right}) {
      out_ += line_element({edge, at_.y.from}, {edge, at_.y.to}, "#999999", 1, Dash::dotted);
    }
  }
}

void Pen::band(const Band& band) {
  std::string points;
  const auto add = [&](double x, double y) {
    if (!at_.x.shows(x) || !at_.y.shows(y)) return;
    const Pixel p = place(x, y);
    points += coordinate(p.x) + "," + coordinate(p.y) + " ";
  };
  const std::size_t n = std::min({band.x.size(), band.low.size(), band.high.size()});
  for (std::size_t i = 0; i < n; ++i) add(band.x[i], band.low[i]);
  for (std::size_t i = n; i-- > 0;) add(band.x[i], band.high[i]);
  out_ += fmt::format("<polygon points='{}' fill='{}' fill-opacity='0.7'/>\n", points, kBandShade);
}

void Pen::rules() {
  for (const Rule& r : panel_.rules) {
    if (!(r.vertical ? at_.x : at_.y).shows(r.at)) continue;
    const Pixel a = r.vertical ? Pixel{at_.x(r.at), at_.y.from} : Pixel{at_.x.from, at_.y(r.at)};
    const Pixel b = r.vertical ? Pixel{at_.x(r.at), at_.y.to} : Pixel{at_.x.to, at_.y(r.at)};
    out_ += line_element(a, b, "#555555", 1, r.dash);
  }
}

void Pen::errors(const Series& s) {
  const std::size_t n = std::min({s.error.size(), s.x.size(), s.y.size()});
  for (std::size_t i = 0; i < n; ++i) {
    if (!at_.x.shows(s.x[i]) || !at_.y.shows(s.y[i]) || !(s.error[i] > 0)) continue;
    const double x = at_.x(s.x[i]);
    const double top = at_.y(s.y[i] + s.error[i]);
    const double low = s.y[i] - s.error[i];
    const double bottom = at_.y.shows(low) ? at_.y(low) : at_.y.from;
    out_ += fmt::format("<path d='M{0} {1}H{2}M{3} {1}V{4}M{0} {4}H{2}' stroke='{5}'/>\n",
                        coordinate(x - 3), coordinate(top), coordinate(x + 3), coordinate(x),
                        coordinate(bottom), s.style.color);
  }
}

void Pen::series(const Series& s) {
  std::vector<Pixel> part, all;
  const auto end_part = [&] {
    if (s.style.line) out_ += polyline_element(thin_line(part, 1), s.style);
    part.clear();
  };
  for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
    if (!at_.x.shows(s.x[i]) || !at_.y.shows(s.y[i])) {
      end_part();
      continue;
    }
    part.push_back(place(s.x[i], s.y[i]));
    all.push_back(part.back());
  }
  end_part();
  if (s.style.marker == Marker::none) return;
  const bool many = static_cast<double>(all.size()) > kThinMarksFrom;
  out_ += marks_element(many ? thin_marks(all, 1) : all, s.style);
}

// Puts the tag at the first free place above, below, right or left of the point.
bool Pen::put_tag(Pixel p, const Tag& tag) {
  const double width = text_width(tag.text, kFont - 1), height = kFont;
  const std::array<Pixel, 4> corners{
      Pixel{p.x - width / 2, p.y - 8 - height}, Pixel{p.x - width / 2, p.y + 8},
      Pixel{p.x + 8, p.y - height / 2}, Pixel{p.x - 8 - width, p.y - height / 2}};
  for (const Pixel& c : corners) {
    const Box box{c.x, c.y, c.x + width, c.y + height};
    const bool inside = box.left >= at_.x.from && box.right <= at_.x.to && box.top >= at_.y.to &&
                        box.bottom <= at_.y.from;
    const bool free = std::ranges::none_of(taken_, [&](const Box& b) {
      return box.left < b.right && b.left < box.right && box.top < b.bottom && b.top < box.bottom;
    });
    if (!inside || !free) continue;
    taken_.push_back(box);
    out_ += text_element(c.x, c.y + height - 2, tag.text,
                         "font-size='11.5' stroke='#fff' stroke-width='3' paint-order='stroke'");
    return true;
  }
  return false;
}

void Pen::tags() {
  for (const Tag& tag : panel_.tags) {
    if (at_.x.shows(tag.x) && at_.y.shows(tag.y)) put_tag(place(tag.x, tag.y), tag);
  }
}

std::string Pen::draw() {
  ranges();
  grid();
  for (const Band& b : panel_.bands) band(b);
  rules();
  for (const Series& s : panel_.series) errors(s);
  for (const Series& s : panel_.series) series(s);
  tags();
  return std::move(out_);
}

std::string legend_entry(const LegendEntry& entry) {
  std::string out;
  const double y = entry.y - 4;
  if (!entry.series) {
    out += fmt::format("<rect x='{}' y='{}' width='26' height='9' fill='{}'/>\n",
                       coordinate(entry.x), coordinate(y - 4.5), kBandShade);
  } else {
    const Style& style = entry.series->style;
    const std::array<Pixel, 2> ends{Pixel{entry.x, y}, Pixel{entry.x + 26, y}};
    const std::array<Pixel, 3> marks{Pixel{entry.x + 13, y}, Pixel{entry.x + 6, y + 3},
                                     Pixel{entry.x + 20, y - 3}};
    const bool dots = style.marker == Marker::dot;  // a single dot would be invisible
    if (style.line) out += polyline_element(ends, style);
    out += marks_element(std::span(marks).first(dots ? 3 : 1), style);
  }
  return out + text_element(entry.x + 31, entry.y, entry.text, "");
}

std::string range_labels(const Panel& panel, const PanelLayout& at) {
  std::string out;
  for (const Range& r : panel.ranges) {
    const double left = at.x.clamped(r.from), right = at.x.clamped(r.to);
    out += text_element((left + right) / 2, at.head - 5,
                        cut_to_width(r.label, right - left - 2, kFont - 1),
                        "text-anchor='middle' font-size='11.5' fill='#444'");
  }
  return out;
}

std::string axes(const Panel& panel, const PanelLayout& at) {
  std::string out = fmt::format("<rect x='{}' y='{}' width='{}' height='{}' stroke='#444'/>\n",
                                coordinate(at.x.from), coordinate(at.y.to),
                                coordinate(at.x.to - at.x.from), coordinate(at.y.from - at.y.to));
  for (std::size_t i = 0; i < at.x_ticks.at.size(); ++i) {
    out += text_element(at.x(at.x_ticks.at[i]), at.y.from + 16, at.x_ticks.labels[i],
                        "text-anchor='middle'");
  }
  for (std::size_t i = 0; i < at.y_ticks.at.size(); ++i) {
    out += text_element(at.x.from - 6, at.y(at.y_ticks.at[i]) + 4, at.y_ticks.labels[i],
                        "text-anchor='end'");
  }
  const double width = at.x.to - at.x.from;
  out += text_element(at.x.from + width / 2, at.y.from + 34,
                      cut_to_width(panel.x.label, at.width - 8, kFont), "text-anchor='middle'");
  return out;
}

std::string draw_panel(const Panel& panel, const PanelLayout& at, double x, double y) {
  std::string out = fmt::format("<g transform='translate({} {})'>\n", coordinate(x), coordinate(y));
  double line = 14;
  for (const auto& text : at.title) {
    out += text_element(0, line, text, "font-weight='bold' font-size='13.5'");
    line += kLine;
  }
  for (const auto& entry : at.legend) out += legend_entry(entry);
  line = (at.legend.empty() ? line - 14 + 4 : at.legend.back().y - 10 + kLine) + 10;
  for (const auto& text : at.y_label) {
    out += text_element(0, line, text, "");
    line += kLine;
  }
  // A nested svg clips what is outside the axes.
  out += fmt::format("<svg x='{0}' y='{1}' width='{2}' height='{3}' viewBox='{0} {1} {2} {3}'>\n",
                     coordinate(at.x.from), coordinate(at.y.to), coordinate(at.x.to - at.x.from),
                     coordinate(at.y.from - at.y.to));
  out += Pen(panel, at).draw();
  out += "</svg>\n" + range_labels(panel, at) + axes(panel, at);
  if (at.empty) {
    out += text_element((at.x.from + at.x.to) / 2, (at.y.from + at.y.to) / 2, "no data",
                        "text-anchor='middle' fill='#666'");
  }
  return out + "</g>\n";
}

}  // namespace

Style line_style(std::size_t n) {
  return {.color = kColors[n % kColors.size()], .dash = kDashes[n % kDashes.size()]};
}

Style mark_style(std::size_t n) {
  return {.color = kColors[n % kColors.size()],
          .marker = kMarkers[n % kMarkers.size()],
          .line = false,
          .filled = n % 2 == 0};
}

std::string to_svg(const Figure& figure, bool embedded) {
  const auto columns = static_cast<std::size_t>(std::max(figure.columns, 1));
  const double gaps = kColumnGap * static_cast<double>(columns - 1);
  const double width = (figure.width - gaps) / static_cast<double>(columns);
  std::vector<double> left(columns, 0.0);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    left[i % columns] = std::max(left[i % columns], wanted_left_margin(figure.panels[i]));
  }
  std::string body;
  double y = 0;
  for (std::size_t first = 0; first < figure.panels.size(); first += columns) {
    const std::size_t end = std::min(first + columns, figure.panels.size());
    double head = 0, height = 0;
    for (std::size_t i = first; i < end; ++i) {
      head = std::max(head, lay_out(figure.panels[i], width, left[i - first]).head);
    }
    for (std::size_t i = first; i < end; ++i) {
      const PanelLayout at = lay_out(figure.panels[i], width, left[i - first], head);
      const double x = static_cast<double>(i - first) * (width + kColumnGap);
      body += draw_panel(figure.panels[i], at, x, y);
      height = std::max(height, at.height);
    }
    y += height;
  }
  return fmt::format(
      "<svg{} viewBox='0 0 {} {}' width='{}' font-family='Helvetica, Arial, sans-serif' "
      "font-size='{}' fill='none' role='img' aria-label='{}'>\n<g>\n<rect width='{}' height='{}' "
      "fill='#fff'/>\n{}</g>\n</svg>\n",
      embedded ? "" : " xmlns='http://www.w3.org/2000/svg'", coordinate(figure.width),
      coordinate(y), coordinate(figure.width), kFont, escape(figure.description),
      coordinate(figure.width), coordinate(y), body);
}

}  // namespace lcrig::plot
