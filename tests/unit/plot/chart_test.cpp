// SPDX-License-Identifier: Apache-2.0
#include "plot/chart.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "plot/text.hpp"
#include "tests/support/hostile_texts.hpp"
#include "tests/support/xml.hpp"

namespace lcrig::plot {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Figure example() {
  Panel panel;
  panel.title = "Capacitance";
  panel.x.label = "pressure, kPa";
  panel.y.label = "ΔC, fF";
  Range range;
  range.to = 30;
  range.label = "0 to 30 kPa";
  panel.ranges.push_back(range);
  Band band;
  band.label = "95 %";
  band.x = {0, 100};
  band.low = {0, 500};
  band.high = {10, 700};
  panel.bands.push_back(band);
  Series s;
  s.label = "measured";
  s.x = {0, 25, 50, 75, 100};
  s.y = {0, 150, 290, 430, 560};
  s.error = {3, 3, 3, 3, 3};
  s.style = mark_style(0);
  panel.series.push_back(s);
  Tag tag;
  tag.x = 50;
  tag.y = 290;
  tag.text = "here";
  panel.tags.push_back(tag);
  panel.rules.push_back(Rule());
  Figure figure;
  figure.description = "ΔC against pressure";
  figure.panels = {panel, panel};
  figure.columns = 2;
  return figure;
}

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// Every text element: x, anchor, text.
struct Text {
  double x, y;
  std::string anchor, text;
};
std::string between(const std::string& text, const std::string& before, const std::string& after,
                    std::size_t from = 0) {
  const auto begin = text.find(before, from) + before.size();
  return text.substr(begin, text.find(after, begin) - begin);
}
std::vector<Text> texts(const std::string& svg) {
  std::vector<Text> out;
  for (auto at = svg.find("<text "); at != svg.npos; at = svg.find("<text ", at + 1)) {
    const std::string attributes = between(svg, "<text ", ">", at);
    const auto has = [&](const char* word) { return attributes.find(word) != attributes.npos; };
    Text t;
    t.x = std::stod(between(attributes, "x='", "'"));
    t.y = std::stod(between(attributes, "y='", "'"));
    t.anchor = has("middle") ? "middle" : has("'end'") ? "end" : "start";
    t.text = between(svg, ">", "<", at);
    out.push_back(t);
  }
  return out;
}

TEST(Chart, IsWellFormed) {
  EXPECT_EQ(XmlCheck::fault(to_svg(example())), "");
  EXPECT_EQ(XmlCheck::fault(to_svg(example(), true)), "");
  EXPECT_EQ(XmlCheck::fault(to_svg(Figure())), "");
}

TEST(Chart, ShowsAxesWithUnitsLegendAndRanges) {
  const std::string svg = to_svg(example());
  for (const char* text : {"Capacitance", "pressure, kPa", "ΔC, fF", "0 to 30 kPa", "measured",
                           "95 %", ">here<", ">100<", ">600<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

TEST(Chart, EveryTextIsEscaped) {
  std::string hostile;
  for (const auto& t : support::hostile_texts()) hostile += t.text.substr(0, 300);
  Figure figure = example();
  figure.description = hostile;
  for (Panel& p : figure.panels) {
    p.title = p.x.label = p.y.label = hostile;
    p.series[0].label = p.bands[0].label = p.ranges[0].label = p.tags[0].text = hostile;
  }
  const std::string svg = to_svg(figure);
  EXPECT_EQ(XmlCheck::fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(svg, Not(HasSubstr("\x1b")));
  EXPECT_THAT(svg, HasSubstr("&lt;script&gt;"));
  EXPECT_EQ(svg, printable_lines(svg)) << "nothing steers whoever opens it in a terminal";
}

TEST(Chart, NoTextLeavesThePicture) {
  Figure figure = example();
  figure.panels.resize(1);
  figure.columns = 1;
  Panel& p = figure.panels[0];
  p.title =
      "A title that goes on and on, far beyond the width of any figure that is printed, "
      "so that it has to be broken into lines; it names a specimen and all its layers";
  p.series[0].label = std::string(300, 'W');
  p.x.label = std::string(300, 'M');
  p.series[0].x = {1e8, 1e8 + 1, 1e8 + 2, 1e8 + 3, 1e8 + 4};
  p.ranges.clear();
  p.bands.clear();
  const auto found = texts(to_svg(figure));
  ASSERT_GT(found.size(), 8U);
  for (const Text& t : found) {
    const double width = text_width(t.text, 12.5);
    const double left = t.anchor == "start" ? t.x : t.x - width / (t.anchor == "end" ? 1 : 2);
    EXPECT_GE(left, -0.5) << t.text;
    EXPECT_LE(left + width, figure.width + 8) << t.text;
  }
}

TEST(Chart, LegendStandsAboveThePlot) {
  Figure figure = example();
  figure.panels.resize(1);
  Panel& p = figure.panels[0];
  for (int i = 0; i < 12; ++i) {
    Series more = p.series[0];
    more.label = "series with a name " + std::to_string(i);
    p.series.push_back(more);
  }
  const std::string svg = to_svg(figure);
  const double plot_top = std::stod(between(svg.substr(svg.find("<svg x=")), " y='", "'"));
  int entries = 0;
  for (const Text& t : texts(svg)) {
    if (!t.text.starts_with("series with")) continue;
    ++entries;
    EXPECT_LT(t.y, plot_top) << t.text;
  }
  EXPECT_EQ(entries, 12);
}

TEST(Chart, AMissingValueBreaksTheLine) {
  Figure figure;
  Panel panel;
  Series s;
  s.x = {0, 1, 2, 3, 4, 5};
  s.y = {0, 1, kNan, 1, 0, 1};
  s.style = line_style(0);
  panel.series.push_back(s);
  figure.panels.push_back(panel);
  EXPECT_EQ(count(to_svg(figure), "<polyline"), 2);
}

TEST(Chart, LogarithmicAxisLeavesOutWhatIsNotPositive) {
  Figure figure = example();
  for (Panel& p : figure.panels) {
    p.x.log = p.y.log = true;
    p.series[0].error = {400, 400, 400, 400, 400};  // bars that reach below zero
  }
  const std::string svg = to_svg(figure);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_EQ(XmlCheck::fault(svg), "");
}

TEST(Chart, NoDataIsSaid) {
  Figure figure;
  figure.panels.emplace_back();
  EXPECT_THAT(to_svg(figure), HasSubstr("no data"));
}

TEST(Chart, EqualValuesHaveAnAxis) {
  Figure figure = example();
  figure.panels.resize(1);
  Panel& p = figure.panels[0];
  p.ranges.clear();
  p.bands.clear();
  p.rules.clear();
  p.series[0].x = {5, 5};
  p.series[0].y = {3.65, 3.65};
  p.series[0].error.clear();
  const std::string svg = to_svg(figure);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Chart, LongSeriesStaySmall) {
  Figure figure;
  Panel panel;
  Series s;
  for (int i = 0; i < 300'000; ++i) {
    s.x.push_back(i * 0.05);
    s.y.push_back(std::sin(i * 1e-3) + 0.1 * std::sin(i * 0.9));
  }
  s.style = line_style(0);
  panel.series = {s, s};
  panel.series[1].style = mark_style(1);
  panel.series[1].style.marker = Marker::dot;
  figure.panels.push_back(panel);
  EXPECT_LT(to_svg(figure).size(), 1'000'000U);
}

TEST(Styles, DifferWithoutColor) {
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_NE(line_style(i).dash, line_style(j).dash);
      EXPECT_NE(mark_style(i).marker, mark_style(j).marker);
    }
  }
}

}  // namespace
}  // namespace lcrig::plot
