// SPDX-License-Identifier: Apache-2.0
// Charts as data, and their conversion to self-contained SVG. Reports and the command line use
// them. Series differ in dash pattern and marker, so a chart is legible in grey; colour only helps.
// Nothing but data is drawn over data.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lcrig::plot {

enum class Dash { solid, dashed, dotted, dash_dot, long_dash };
enum class Marker { none, dot, circle, square, triangle, diamond, plus, cross, triangle_down };

struct Style {
  std::string_view color = "#222222";
  Dash dash = Dash::solid;
  Marker marker = Marker::none;
  bool line = true;
  bool filled = true;  // the marker is filled
  double width = 1.5;  // of the line, pixels
};
// The n-th style of a set that can be told apart without colour: lines only, or markers only.
Style line_style(std::size_t n);
Style mark_style(std::size_t n);

// A value that is not finite (or not positive on a logarithmic axis) interrupts the line.
struct Series {
  std::string label;  // for the legend; empty: no entry
  std::vector<double> x, y;
  std::vector<double> error;  // half length of the error bars; empty: none
  Style style;

  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
  void add(double at_x, double at_y, double its_error) {
    add(at_x, at_y);
    error.push_back(its_error);
  }
};

struct Band {  // the area between two curves
  Band() = default;
  std::string label;
  std::vector<double> x, low, high;
};

struct Range {  // a shaded range of x; its label stands above the plot
  Range() = default;
  double from = 0, to = 0;
  std::string label;
};

struct Rule {  // a straight line across the plot
  Rule() = default;
  double at = 0;
  bool vertical = false;
  Dash dash = Dash::solid;
};

struct Tag {  // a word beside a point; left out where it would cover another tag
  Tag() = default;
  double x = 0, y = 0;
  std::string text;
};

struct Axis {
  std::string label;  // with its unit
  bool log = false;
  std::optional<double> low, high;  // absent: taken from the data
  bool with_zero = false;
};

struct Panel {
  std::string title;
  Axis x, y;
  std::vector<Range> ranges;
  std::vector<Band> bands;
  std::vector<Rule> rules;
  std::vector<Series> series;
  std::vector<Tag> tags;
  double height = 240;  // of the plot itself, pixels
};

struct Figure {
  std::string description;  // read to people who cannot see the figure
  double width = 820;
  int columns = 1;
  std::vector<Panel> panels;  // row by row
};

// `embedded` leaves out the XML name space, which HTML does not need.
std::string to_svg(const Figure& figure, bool embedded = false);

}  // namespace lcrig::plot
