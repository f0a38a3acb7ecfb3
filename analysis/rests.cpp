// SPDX-License-Identifier: Apache-2.0
// The stretches without load: the mark of each cycle, the drift of the run, and how much
// neighbouring readings know of each other.
#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr std::int64_t kLeastOfRest = 3;  // readings that tell a mean and a scatter

// Rest k lies before cycle k; the last one after all cycles.
struct Rest {
  double from_s = 0, to_s = 0;
  std::size_t first = 0, last = 0;  // of the readings
  RunningMean capacitance, time;  // pF, s; of what counts
  bool any = false;
};

template <class Visit>
void each_resting(const Scene& scene, const RunAnalysis& out, Visit visit) {
  const auto& readings = scene.data.readings;
  std::size_t k = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    while (k < out.cycles.size() && i >= out.cycles[k].last) ++k;
    if (k < out.cycles.size() && i >= out.cycles[k].first) continue;
    if (scene.uses(readings[i]) && scene.rests(i)) visit(k, i);
  }
}

// After a load the capacitance recovers, which is no drift: of a rest that follows one the later
// half counts.
std::vector<Rest> collect_rests(const Scene& scene, const RunAnalysis& out) {
  const auto& readings = scene.data.readings;
  std::vector<Rest> rests(out.cycles.size() + 1);
  each_resting(scene, out, [&](std::size_t k, std::size_t i) {
    Rest& r = rests[k];
    if (!r.any) r.from_s = readings[i].t_s;
    r.any = true;
    r.to_s = readings[i].t_s;
  });
  for (std::size_t k = 1; k < rests.size(); ++k) {
    rests[k].from_s = (rests[k].from_s + rests[k].to_s) / 2;
  }
  each_resting(scene, out, [&](std::size_t k, std::size_t i) {
    Rest& r = rests[k];
    if (readings[i].t_s < r.from_s) return;
    if (r.capacitance.count == 0) r.first = i;
    r.last = i + 1;
    r.capacitance.add(readings[i].capacitance_F * 1e12);
    r.time.add(readings[i].t_s);
  });
  return rests;
}

// Before anything touched; a run that tells no contact: the rest before the first loading.
Rest baseline_of(const Scene& scene, const std::vector<Rest>& rests) {
  if (!scene.data.contact_s) return rests.front();
  Rest out;
  const auto& readings = scene.data.readings;
  for (std::size_t i = 0; i < readings.size() && readings[i].t_s < *scene.data.contact_s; ++i) {
    if (!scene.uses(readings[i])) continue;
    if (out.capacitance.count == 0) out.first = i;
    out.last = i + 1;
    out.capacitance.add(readings[i].capacitance_F * 1e12);
    out.time.add(readings[i].t_s);
  }
  return out;
}

// A drift is no correlation: the line through the rests is taken out.
double rate_of(const Rest& baseline, const std::vector<Rest>& rests) {
  std::vector<LinePoint> points;
  const auto add = [&points](const Rest& r) {
    const auto n = static_cast<double>(r.capacitance.count);
    if (n >= kLeastOfRest) points.push_back({r.time.mean, r.capacitance.mean * 1e3, n});
  };
  add(baseline);
  for (std::size_t k = 1; k < rests.size(); ++k) add(rests[k]);
  const auto line = fit_line(points);
  return line ? line->slope : 0;
}

EvenStretch stretch_of(const Scene& scene, const Rest& rest, double rate_fF_s) {
  EvenStretch s;
  for (std::size_t i = rest.first; i < rest.last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (scene.uses(r)) s.add(r.capacitance_F * 1e15 - rate_fF_s * r.t_s);
  }
  return s;
}

// Of the stretches in which the readings ought to be equal.
void find_correlation(Scene& scene, const Rest& baseline, const std::vector<Rest>& rests) {
  const double rate = rate_of(baseline, rests);
  std::vector<EvenStretch> stretches{stretch_of(scene, baseline, rate)};
  for (std::size_t k = 1; k < rests.size(); ++k) {
    stretches.push_back(stretch_of(scene, rests[k], rate));
  }
  scene.rest_correlation = fit_correlation(stretches);
  std::vector<EvenStretch> levels(scene.data.levels.size());
  for (EvenStretch& level : levels) level.trend = true;
  for (const RunReading& r : scene.data.readings) {
    const auto k = static_cast<std::size_t>(r.level) - 1;
    if (r.index > 0 && r.level > 0 && k < levels.size() && scene.uses(r)) {
      levels[k].add(r.capacitance_F * 1e15);
    }
  }
  scene.correlation = fit_correlation(levels);
  if (scene.correlation.freedom <= 0) scene.correlation = scene.rest_correlation;
}

std::vector<RestNode> nodes_of(const Scene& scene, const Rest& baseline,
                               const std::vector<Rest>& rests) {
  std::vector<const Rest*> all{&baseline};
  for (std::size_t k = 1; k < rests.size(); ++k) all.push_back(&rests[k]);
  double ss = 0, freedom = 0;  // one scatter for all: a few readings do not tell it
  std::vector<RestNode> nodes;
  for (const Rest* r : all) {
    if (r->capacitance.count < kLeastOfRest) continue;
    const auto n = static_cast<double>(r->capacitance.count);
    ss += r->capacitance.sum_squares * 1e6;
    freedom += (n - 1) * scene.rest_correlation.of_square(n);
    nodes.push_back({r->time.mean, r->capacitance.mean * 1e3, 0, n, r->first, r->last});
  }
  for (RestNode& n : nodes) {
    n.se_fF = std::sqrt(ss / freedom * scene.rest_correlation.of_mean(n.readings));
  }
  return nodes;
}

void mark_cycles(const Scene& scene, const std::vector<Rest>& rests, RunAnalysis& out) {
  for (std::size_t k = 0; k < out.cycles.size(); ++k) {
    CycleResult& c = out.cycles[k];
    const RunningMean& s = rests[k].capacitance;
    c.rest_pF = s.mean;
    c.rest_s = s.count > 0 ? rests[k].time.mean : c.begin_s;
    if (s.count >= 2) {
      const auto n = static_cast<double>(s.count);
      const double square = scene.rest_correlation.of_square(n);
      c.rest_se_fF = std::sqrt(s.variance() / square * scene.rest_correlation.of_mean(n)) * 1e3;
    }
    // A run that begins loaded, or a cycle that follows at once: the first loaded reading.
    if (s.count == 0) c.rest_pF = scene.data.readings[c.first].capacitance_F * 1e12;
  }
}

}  // namespace

void find_drift(Scene& scene, RunAnalysis& out) {
  const auto rests = collect_rests(scene, out);
  const Rest baseline = baseline_of(scene, rests);
  find_correlation(scene, baseline, rests);
  scene.drift = Drift(nodes_of(scene, baseline, rests));
  mark_cycles(scene, rests, out);
  const bool loaded = !out.cycles.empty() || !scene.data.levels.empty();
  if (loaded && !scene.drift.known()) {
    out.notes.emplace_back(
        "no two stretches without load: a drift of the capacitance cannot be told from the "
        "specimen's answer, and none is subtracted");
  }
}

}  // namespace lcrig
