// SPDX-License-Identifier: Apache-2.0
#include "analysis/recovery.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// A load leaves no more behind than the creep while it was held: over some two decades of time,
// from the first reading under it to the end of a usual hold.
constexpr double kDecadesOfHold = 2;
constexpr double kWithinErrors = 2;  // standard errors

double change_fF(const Drift& drift, const CycleResult& c) {
  return drift.at(c.peak_s) - drift.at(c.rest_s);
}

// Largest recovery after one load, as the creep of the holds tells it. nullopt: it is not known.
std::optional<double> most_left_fF(const Metric& creep, double delta_C_fF) {
  if (!creep || !creep.estimate->standard_error) return std::nullopt;
  const double part = std::abs(creep.value()) + kWithinErrors * *creep.estimate->standard_error;
  return kDecadesOfHold * part / 100 * std::abs(delta_C_fF);
}

}  // namespace

std::optional<Drift> drift_of_rests(const Scene& scene) {
  std::vector<RestNode> nodes = scene.drift.nodes();
  const bool first_is_baseline = !scene.loadings.empty() && !nodes.empty() &&
                                 nodes.front().t_s < scene.loadings.front().begin_s;
  if (nodes.size() < 3 || !first_is_baseline) return std::nullopt;
  std::vector<LinePoint> after;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    after.push_back({nodes[k].t_s, nodes[k].fF, nodes[k].readings});
  }
  const auto line = fit_line(after);
  if (!line) return std::nullopt;
  nodes.front().fF = line->at(nodes.front().t_s);
  Drift out(nodes);
  out.follow(scene.drift.followed());
  return out;
}

DriftLeft take_out_recovery(const Scene& scene, const Metric& creep,
                            std::vector<CycleResult>& cycles) {
  DriftLeft out;
  if (!scene.drift.known() || cycles.empty()) return out;
  const auto of_rests = drift_of_rests(scene);
  const Drift& used = of_rests ? *of_rests : scene.drift;
  RunningMean all, rests, since_rest_s, delta_C;
  for (CycleResult& c : cycles) {
    all.add(change_fF(scene.drift, c));
    rests.add(change_fF(used, c));
    since_rest_s.add(c.peak_s - c.rest_s);
    c.delta_C_fF += change_fF(scene.drift, c) - change_fF(used, c);
    delta_C.add(c.delta_C_fF);
  }
  const double left = used.rate_se_fF_s() * (1 - used.followed());
  out.rate = {since_rest_s.mean * left, used.rate_freedom()};
  double most_fF =
      std::max({std::abs(all.mean), std::abs(rests.mean), std::abs(all.mean - rests.mean)});
  if (const auto most = most_left_fF(creep, delta_C.mean)) most_fF = std::min(most_fF, *most);
  out.recovery = {rectangular(most_fF)};
  return out;
}

}  // namespace lcrig
