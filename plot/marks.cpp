// SPDX-License-Identifier: Apache-2.0
#include "plot/marks.hpp"

#include <fmt/format.h>

#include "plot/text.hpp"

namespace lcrig::plot {

namespace {

std::string mark_path(Pixel p, Marker marker) {
  const std::string x = coordinate(p.x), y = coordinate(p.y);
  switch (marker) {
    case Marker::none: return {};
    case Marker::dot: return fmt::format("M{} {}h0", x, y);
    case Marker::circle:
      return fmt::format("M{} {}a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0", coordinate(p.x - 3.5), y);
    case Marker::square: return fmt::format("M{} {}m-3.2-3.2h6.4v6.4h-6.4z", x, y);
    case Marker::triangle: return fmt::format("M{} {}m0-4.4l4.2 7.4h-8.4z", x, y);
    case Marker::triangle_down: return fmt::format("M{} {}m0 4.4l4.2-7.4h-8.4z", x, y);
    case Marker::diamond: return fmt::format("M{} {}m0-4.6l4.6 4.6l-4.6 4.6l-4.6-4.6z", x, y);
    case Marker::plus: return fmt::format("M{} {}m-4 0h8m-4-4v8", x, y);
    case Marker::cross: return fmt::format("M{} {}m-3.4-3.4l6.8 6.8m0-6.8l-6.8 6.8", x, y);
  }
  return {};
}

}  // namespace

std::string coordinate(double value) {
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

std::string_view dash_pattern(Dash dash) {
  switch (dash) {
    case Dash::solid: return "";
    case Dash::dashed: return "7 4";
    case Dash::dotted: return "1.5 3";
    case Dash::dash_dot: return "8 3 1.5 3";
    case Dash::long_dash: return "14 5";
  }
  return "";
}

std::string line_element(Pixel a, Pixel b, std::string_view color, double width, Dash dash) {
  const auto pattern = dash_pattern(dash);
  return fmt::format("<path d='M{} {}L{} {}' stroke='{}' stroke-width='{}'{}/>\n", coordinate(a.x),
                     coordinate(a.y), coordinate(b.x), coordinate(b.y), color, width,
                     pattern.empty() ? "" : fmt::format(" stroke-dasharray='{}'", pattern));
}

std::string polyline_element(std::span<const Pixel> points, const Style& style) {
  if (points.size() < 2) return {};
  std::string out = "<polyline points='";
  for (const Pixel& p : points) {
    if (out.back() != '\'') out += ' ';
    out += coordinate(p.x) + "," + coordinate(p.y);
  }
  const auto pattern = dash_pattern(style.dash);
  if (!pattern.empty()) out += fmt::format("' stroke-dasharray='{}", pattern);
  return out + fmt::format("' stroke='{}' stroke-width='{}' stroke-linejoin='round'/>\n",
                           style.color, style.width);
}

std::string marks_element(std::span<const Pixel> points, const Style& style) {
  if (points.empty() || style.marker == Marker::none) return {};
  std::string path;
  for (const Pixel& p : points) path += mark_path(p, style.marker);
  if (style.marker == Marker::dot) {
    return fmt::format("<path d='{}' stroke='{}' stroke-width='3' stroke-linecap='round'/>\n", path,
                       style.color);
  }
  return fmt::format("<path d='{}' stroke='{}' stroke-width='1.3' fill='{}'/>\n", path, style.color,
                     style.filled ? style.color : "#fff");
}

std::string text_element(double x, double y, std::string_view text, std::string_view attributes) {
  const bool colored = attributes.find("fill=") != std::string_view::npos;
  return fmt::format("<text x='{}' y='{}' {}{}>{}</text>\n", coordinate(x), coordinate(y),
                     colored ? "" : "fill='#222' ", attributes, escape(text));
}

}  // namespace lcrig::plot
