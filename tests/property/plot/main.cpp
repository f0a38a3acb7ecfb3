// SPDX-License-Identifier: Apache-2.0
// property_plot FILE.csv... > overshoot.svg: predicted against observed overshoot of a sweep.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <sstream>

#include "plot/chart.hpp"

namespace lcrig::property {
namespace {

struct Points {
  Points() = default;
  plot::Series held, broken;
  double low = 1e9, high = 0;
};

// Rises above the threshold. Those within the noise of the cell are left out.
void read(const std::string& path, Points& points) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    double seed = 0, threshold = 0, predicted = 0, observed = 0, noise = 0;
    char comma = 0;
    std::istringstream row(line);
    row >> seed >> comma >> threshold >> comma >> predicted >> comma >> observed >> comma >> noise;
    const double x = predicted - threshold, y = observed - threshold;
    if (!row || x <= 10 * noise || y <= 10 * noise) continue;
    plot::Series& s = y > x + 0.01 * predicted + 8 * noise ? points.broken : points.held;
    s.x.push_back(x);
    s.y.push_back(y);
    points.low = std::min(points.low, std::min(x, y));
    points.high = std::max(points.high, std::max(x, y));
  }
}

void draw(Points points) {
  plot::Figure figure;
  figure.width = 640;
  figure.description = "Observed against predicted overshoot of force-stopped motions";
  plot::Panel panel;
  panel.height = 520;
  panel.title = fmt::format("{} motions that stopped at a force, on random rigs",
                            points.held.x.size() + points.broken.x.size());
  panel.x.label = "predicted overshoot (N)";
  panel.y.label = "observed overshoot (N)";
  for (plot::Axis* axis : {&panel.x, &panel.y}) {
    axis->log = true;
    axis->low = points.low;
    axis->high = points.high;
  }
  points.held.style = plot::mark_style(0);
  points.broken.style = plot::mark_style(1);
  points.held.style.marker = plot::Marker::dot;
  points.held.label = "within the prediction";
  points.broken.label = "beyond it";
  plot::Series line;
  line.x = line.y = {points.low, points.high};
  line.label = "as predicted";
  panel.series.push_back(points.held);
  if (!points.broken.x.empty()) panel.series.push_back(points.broken);
  panel.series.push_back(line);
  figure.panels.push_back(panel);
  std::cout << to_svg(figure) << "\n";
}

}  // namespace
}  // namespace lcrig::property

int main(int argc, char** argv) {
  lcrig::property::Points points;
  for (int i = 1; i < argc; ++i) lcrig::property::read(argv[i], points);
  if (points.held.x.empty()) {
    std::cerr << "no points; usage: property_plot overshoot-*.csv > overshoot.svg\n";
    return 2;
  }
  lcrig::property::draw(std::move(points));
  return 0;
}
