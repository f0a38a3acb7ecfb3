// SPDX-License-Identifier: Apache-2.0
// Pictures of model_study's CSV: a histogram of estimate over error by level, and the race against
// another code.
//   model_study_plot < study.csv > histogram.svg
//   model_study_plot race < race.csv > race.svg
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "plot/chart.hpp"

namespace lcrig {
namespace {

constexpr int kPerDecade = 6;
constexpr int kFirstBin = -kPerDecade;  // a tenth
constexpr int kBins = 3 * kPerDecade + 1;  // to a hundred

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  return cells;
}

using Counts = std::map<std::string, std::vector<double>>;

Counts read_counts(std::istream& in) {
  Counts counts;
  for (std::string line; std::getline(in, line);) {
    const auto cells = split(line);
    const bool answer = cells.size() == 10 && cells[2].find("refused") == std::string::npos;
    if (!answer || cells[9] != "1") continue;
    const double ratio =
        std::strtod(cells[4].c_str(), nullptr) / std::strtod(cells[5].c_str(), nullptr);
    const int bin = static_cast<int>(std::lround(std::log10(ratio) * kPerDecade)) - kFirstBin;
    auto& level = counts[cells[2]];
    level.resize(kBins);
    level[static_cast<std::size_t>(std::min(std::max(bin, 0), kBins - 1))] += 1;
  }
  return counts;
}

plot::Series series_of(const std::string& level, const std::vector<double>& counts,
                       std::size_t number) {
  double all = 0;
  for (const double count : counts) all += count;
  plot::Series series;
  series.label = fmt::format("{} ({:.0f})", level, all);
  series.style = plot::line_style(number);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    series.x.push_back(std::pow(10, (static_cast<double>(i) + kFirstBin) / kPerDecade));
    series.y.push_back(100 * counts[i] / all);
  }
  return series;
}

int print(plot::Panel panel) {
  plot::Figure figure;
  figure.description = panel.title;
  figure.panels.push_back(std::move(panel));
  std::cout << plot::to_svg(figure);
  return 0;
}

int plot_histogram() {
  plot::Panel panel;
  panel.title = "Estimated over true error, random stacks";
  panel.x.label = "estimate / error";
  panel.x.log = true;
  panel.y.label = fmt::format("% of answers, {} bins a decade", kPerDecade);
  panel.height = 300;
  for (const auto& [level, counts] : read_counts(std::cin)) {
    panel.series.push_back(series_of(level, counts, panel.series.size()));
  }
  return print(std::move(panel));
}

// Both codes at the error of the other one's coarsest mesh; our mesh is no less accurate than that.
int plot_race() {
  plot::Panel panel;
  panel.title = "Small strain: seconds to the error of FEniCSx's coarsest mesh, random stacks";
  panel.x.label = "relative error of Delta C, FEniCSx";
  panel.y.label = "processor seconds, one thread";
  panel.x.log = panel.y.log = true;
  panel.height = 300;
  panel.series.resize(3);
  for (std::size_t i = 0; i < 3; ++i) panel.series[i].style = plot::mark_style(i);
  panel.series[0].label = "FEniCSx";
  panel.series[1].label = "lcrig with its estimate";
  panel.series[2].label = "lcrig alone";
  for (std::string line; std::getline(std::cin, line);) {
    const auto cells = split(line);
    if (cells.size() < 7 || cells[0] == "seed") continue;
    const auto number = [&](std::size_t i) { return std::strtod(cells[i].c_str(), nullptr); };
    const double seconds[] = {number(6), number(5), number(4)};
    for (std::size_t i = 0; i < 3; ++i) {
      panel.series[i].x.push_back(number(3));
      panel.series[i].y.push_back(seconds[i]);
    }
  }
  return print(std::move(panel));
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  return argc == 2 && std::string(argv[1]) == "race" ? lcrig::plot_race() : lcrig::plot_histogram();
}
