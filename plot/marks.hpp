// SPDX-License-Identifier: Apache-2.0
// Writes lines, markers and text as SVG elements. Used by chart.cpp only. Coordinates are pixels.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "plot/chart.hpp"
#include "plot/thin.hpp"

namespace lcrig::plot {

// With at most one decimal, because nobody sees less than a tenth of a pixel.
std::string coordinate(double value);
std::string_view dash_pattern(Dash dash);  // for stroke-dasharray; empty: solid

std::string line_element(Pixel a, Pixel b, std::string_view color, double width, Dash dash);
std::string polyline_element(std::span<const Pixel> points, const Style& style);
std::string marks_element(std::span<const Pixel> points, const Style& style);
// Writes `attributes` unchanged and escapes `text`.
std::string text_element(double x, double y, std::string_view text, std::string_view attributes);

}  // namespace lcrig::plot
