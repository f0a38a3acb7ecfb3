// SPDX-License-Identifier: Apache-2.0
// Love's integral equation: f(x) - (1/pi) int_-1^1 k/(k^2 + (x-y)^2) f(y) dy = 1, and C/C_plate =
// (k/pi) 2 int_0^1 ... f. f is even and has a boundary layer of width k at 1. Panels shrink
// geometrically towards 1, and f is a polynomial on each. The kernel is sharp where x meets y, so
// it is integrated over pieces no longer than its width.
#include "model/fringe.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace lcrig {
namespace {

constexpr int kOrder = 12;
using Nodes = std::array<double, kOrder>;
struct Rule {
  Nodes x, w;
};

// Gauss-Legendre by Newton's method on the recurrence.
Rule make_rule() {
  Rule rule{};
  for (int i = 0; i < kOrder; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (kOrder + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p0 = 1, p1 = x;
      for (int n = 2; n <= kOrder; ++n) {
        const double p2 = ((2 * n - 1) * x * p1 - (n - 1) * p0) / n;
        p0 = p1;
        p1 = p2;
      }
      slope = kOrder * (x * p1 - p0) / (x * x - 1);
      x -= p1 / slope;
    }
    const auto at = static_cast<std::size_t>(i);
    rule.x[at] = x;
    rule.w[at] = 2 / ((1 - x * x) * slope * slope);
  }
  return rule;
}
const Rule& rule() {
  static const Rule kRule = make_rule();
  return kRule;
}

struct Panel {
  double a, b;
  double at(double xi) const { return (a + b) / 2 + (b - a) / 2 * xi; }
};

std::vector<Panel> make_panels(double k) {
  std::vector<double> edges{0};
  for (double rest = 0.5; rest > k / 4; rest /= 2) edges.push_back(1 - rest);
  edges.push_back(1);
  std::vector<Panel> panels;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) panels.push_back({edges[i], edges[i + 1]});
  return panels;
}

// Barycentric Lagrange values of all node polynomials of a panel at xi.
Nodes lagrange(double xi) {
  static const Nodes kBary = [] {
    Nodes w{};
    for (std::size_t i = 0; i < kOrder; ++i) {
      w[i] = 1;
      for (std::size_t j = 0; j < kOrder; ++j) w[i] /= i == j ? 1 : rule().x[i] - rule().x[j];
    }
    return w;
  }();
  Nodes values{};
  double sum = 0;
  for (std::size_t i = 0; i < kOrder; ++i) {
    const double distance = xi - rule().x[i];
    if (distance == 0) {
      values = {};
      values[i] = 1;
      return values;
    }
    values[i] = kBary[i] / distance;
    sum += values[i];
  }
  for (double& v : values) v /= sum;
  return values;
}

// Adds int_c^d kernel(x - y) L_j(y) dy for each node j of the panel.
void add_kernel(double x, double k, const Panel& panel, double c, double d, double* row) {
  const double nearest = std::clamp(x, c, d);
  if (d - c > std::max(k, std::abs(x - nearest))) {
    const double middle = (c + d) / 2;
    add_kernel(x, k, panel, c, middle, row);
    add_kernel(x, k, panel, middle, d, row);
    return;
  }
  for (std::size_t q = 0; q < kOrder; ++q) {
    const double y = (c + d) / 2 + (d - c) / 2 * rule().x[q];
    const double weight = rule().w[q] * (d - c) / 2 * k / (k * k + (x - y) * (x - y));
    const auto shape = lagrange((2 * y - panel.a - panel.b) / (panel.b - panel.a));
    for (std::size_t j = 0; j < kOrder; ++j) row[j] += weight / std::numbers::pi * shape[j];
  }
}

}  // namespace

double love_factor(double k) {
  const auto panels = make_panels(k);
  const auto n = static_cast<Eigen::Index>(panels.size() * kOrder);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd weights(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Panel& own = panels[static_cast<std::size_t>(i) / kOrder];
    const double x = own.at(rule().x[static_cast<std::size_t>(i) % kOrder]);
    weights(i) = rule().w[static_cast<std::size_t>(i) % kOrder] * (own.b - own.a) / 2;
    for (std::size_t p = 0; p < panels.size(); ++p) {
      double row[kOrder] = {};
      add_kernel(x, k, panels[p], panels[p].a, panels[p].b, row);
      add_kernel(-x, k, panels[p], panels[p].a, panels[p].b, row);  // the mirrored half
      for (int j = 0; j < kOrder; ++j) {
        matrix(i, static_cast<Eigen::Index>(p) * kOrder + j) -= row[j];
      }
    }
  }
  const Eigen::VectorXd f = matrix.partialPivLu().solve(Eigen::VectorXd::Ones(n));
  return 2 * k / std::numbers::pi * 2 * weights.dot(f);
}

double kirchhoff_factor(double k) {
  return 1 + k / std::numbers::pi * (std::log(16 * std::numbers::pi / k) - 1);
}

double fringe_in_air(double k, double relative_permittivity) {
  return (kirchhoff_factor(k) - 1) / relative_permittivity;
}

}  // namespace lcrig
