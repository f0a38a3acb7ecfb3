// SPDX-License-Identifier: Apache-2.0
#include "analysis/fit_data.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "analysis/load_memory.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

// A level in three pieces shows whether it creeps, and whether it settles.
constexpr std::size_t kFitPieces = 3, kLeastOfFitPiece = 3;

struct FitPiece {
  std::int32_t repeat = 0, cell = 0;
  std::vector<std::size_t> readings;
  bool loaded = false;  // otherwise at rest
  double target_N = 0;  // where the frame reports no force
};

// Names cells: the same level (or rest) and the same piece of it.
class CellNames {
 public:
  std::int32_t of(const std::string& what, std::size_t piece) {
    return names_.try_emplace({what, piece}, std::ssize(names_) + 1).first->second;
  }

 private:
  std::map<std::pair<std::string, std::size_t>, std::int32_t> names_;
};

void cut_pieces(const std::vector<std::size_t>& readings, const std::string& what,
                std::int32_t repeat, std::optional<double> target_N, CellNames& names,
                std::vector<FitPiece>& out) {
  const std::size_t n = readings.size();
  const std::size_t pieces = n >= kFitPieces * kLeastOfFitPiece ? kFitPieces : 1;
  for (std::size_t k = 0; k < pieces; ++k) {
    FitPiece p;
    p.repeat = repeat;
    p.cell = names.of(what, k);
    p.loaded = target_N.has_value();
    p.target_N = target_N.value_or(0);
    const auto begin = readings.begin() + static_cast<std::ptrdiff_t>(n * k / pieces);
    p.readings.assign(begin, readings.begin() + static_cast<std::ptrdiff_t>(n * (k + 1) / pieces));
    if (!p.readings.empty()) out.push_back(std::move(p));
  }
}

struct Shown {
  std::vector<FitPiece> pieces;
  std::map<std::int32_t, std::pair<double, double>> span_s;  // first and last level of each repeat
};

void cut_levels(const RunView& view, const RunAnalysis& a, CellNames& names, Shown& out) {
  std::map<std::pair<std::int32_t, std::string>, int> visits;
  for (const LevelResult& l : a.levels) {
    auto [it, fresh] = out.span_s.try_emplace(l.repeat, l.t_s, l.t_s);
    it->second.second = std::max(it->second.second, l.t_s);
    if (l.direction != a.line_direction || !(l.pressure_kPa > 0)) continue;
    std::vector<std::size_t> readings;
    for (std::size_t i = l.first; i < l.last; ++i) {
      const RunReading& r = view.data.readings[i];
      if (r.level == l.level && r.index > 0 && view.uses(r)) readings.push_back(i);
    }
    std::string what = std::to_string(key_of(l).what);
    const int visit = ++visits[{l.repeat, what}];
    what.append("/").append(std::to_string(visit));  // `+` makes g++ 12 warn of overlapping copies
    cut_pieces(readings, what, l.repeat, l.pressure_kPa * 1e3 * *view.data.area_m2, names,
               out.pieces);
  }
}

// The readings without a load after the last level of each repeat.
void cut_rests(const RunView& view, CellNames& names, Shown& out) {
  for (auto it = out.span_s.begin(); it != out.span_s.end(); ++it) {
    const auto next = std::next(it);
    const double from_s = it->second.second;
    const double to_s = next != out.span_s.end() ? next->second.first : view.data.duration_s;
    std::vector<std::size_t> readings;
    for (std::size_t i = 0; i < view.data.readings.size(); ++i) {
      const RunReading& r = view.data.readings[i];
      if (r.t_s > from_s && r.t_s < to_s && view.uses(r) && view.is_at_rest(i)) {
        readings.push_back(i);
      }
    }
    if (readings.size() >= kLeastOfFitPiece) {
      cut_pieces(readings, "rest", it->first, std::nullopt, names, out.pieces);
    }
  }
}

// Difference of the branches against pressure, for the pressures that both have.
class BranchGap {
 public:
  BranchGap(const RunAnalysis& a, double kPa_per_N) {
    std::vector<std::pair<double, double>> up, down;
    for (const CurvePoint& c : a.curve) {
      (c.direction == a.line_direction ? up : down).emplace_back(c.pressure_kPa, c.capacitance_pF);
    }
    const double sign = a.line_direction == Direction::up ? 1 : -1;
    for (const auto& [kPa, pF] : down) {
      for (const auto& [other_kPa, other_pF] : up) {
        if (std::abs(kPa - other_kPa) > 0.02 * kPa) continue;
        gaps_.emplace_back(kPa, sign * (pF - other_pF) * 1e-12);
      }
    }
    if (gaps_.empty() && a.hysteresis.resolved) {
      for (const LoopPoint& p : a.hysteresis.loop) {
        gaps_.emplace_back(p.force_N * kPa_per_N, (p.down_fF - p.up_fF) * 1e-15);
      }
    }
    std::sort(gaps_.begin(), gaps_.end());
  }
  double at(double kPa) const {
    if (gaps_.empty()) return 0;
    const auto above = std::lower_bound(gaps_.begin(), gaps_.end(), std::pair(kPa, -1e9));
    // The branches meet where nothing presses.
    const auto low = above == gaps_.begin() ? std::pair(0.0, 0.0) : *std::prev(above);
    if (above == gaps_.end()) return gaps_.back().second;
    const double part = (kPa - low.first) / (above->first - low.first);
    return low.second + part * (above->second - low.second);
  }

 private:
  std::vector<std::pair<double, double>> gaps_;
};

// Before contact: when, on average, C0 was measured.
double time_of_c0(const RunView& view) {
  RunningMean t;
  for (const RunReading& r : view.data.readings) {
    if (view.touch_s && r.t_s >= *view.touch_s) break;
    if (view.uses(r)) t.add(r.t_s);
  }
  return t.mean;
}

// Rate of values at rest over the repeats, and what makes its error. The shift of the first rest
// against C0 is no drift: the specimen may not have recovered. Hence only rests after a load.
struct RestRate {
  std::vector<double> weight;  // of each rest
  double error = 0;
  double of(const std::vector<double>& values) const {
    return std::inner_product(values.begin(), values.end(), weight.begin(), 0.0);
  }
};

RestRate rate_over(const std::vector<double>& t_s, const std::vector<double>& fF, double noise) {
  RestRate out;
  const auto n = static_cast<double>(t_s.size());
  const double mean = std::accumulate(t_s.begin(), t_s.end(), 0.0) / n;
  double stt = 0, left = 0;
  for (const double t : t_s) stt += (t - mean) * (t - mean);
  for (const double t : t_s) out.weight.push_back((t - mean) / stt);
  const double rate = out.of(fF);
  const double middle = std::accumulate(fF.begin(), fF.end(), 0.0) / n;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    left += std::pow(fF[i] - middle - rate * (t_s[i] - mean), 2);
  }
  const double seen = n > 2 ? left / (n - 2) : 0;
  out.error = std::sqrt(std::max(seen, noise * noise) / stt);
  return out;
}

struct FitRest {
  RunningMean t_s, F;
  std::vector<RunningMean> memory_Pa;
};

void subtract_drift(const RunAnalysis& a, const std::vector<FitPiece>& pieces, FitData& out) {
  std::map<std::int32_t, FitRest> rests;
  double noise_F = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].loaded) continue;
    const FitPoint& p = out.points[i];
    FitRest& rest = rests[p.repeat];
    rest.memory_Pa.resize(p.memory_Pa.size());
    rest.t_s.add(p.time_s);
    rest.F.add(p.delta_capacitance_F);
    for (std::size_t k = 0; k < p.memory_Pa.size(); ++k) rest.memory_Pa[k].add(p.memory_Pa[k]);
    noise_F = std::max(noise_F, p.standard_error_F);
  }
  if (rests.size() < 2) {
    // Drift and recovery look alike: limits of what the rest shows, either way.
    if (a.drift) out.drift_error_F_s = rectangular(std::abs(a.drift.value()) * 1e-15 / 3600);
    return;
  }
  std::vector<double> t_s, F;
  for (const auto& [repeat, rest] : rests) {
    t_s.push_back(rest.t_s.mean);
    F.push_back(rest.F.mean);
  }
  const RestRate rate = rate_over(t_s, F, noise_F);
  const double drift_F_s = rate.of(F);
  for (FitPoint& p : out.points) p.delta_capacitance_F -= drift_F_s * p.time_s;
  out.drift_error_F_s = rate.error;
  for (std::size_t k = 0; k < out.creep_times_s.size(); ++k) {
    std::vector<double> memory;
    for (const auto& [repeat, rest] : rests) memory.push_back(rest.memory_Pa[k].mean);
    out.memory_drift_Pa_s.push_back(rate.of(memory));
  }
}

std::vector<std::size_t> readings_of(const std::vector<FitPiece>& pieces) {
  std::vector<std::size_t> out;
  for (const FitPiece& p : pieces) out.insert(out.end(), p.readings.begin(), p.readings.end());
  std::sort(out.begin(), out.end());
  return out;
}

// Means over the readings of a piece; its capacitance and time are not yet relative to C0's.
struct PointMaker {
  const RunView& view;
  const LoadMemory& memory;
  BranchGap gap;
  double disc_area_m2, noise_F;

  FitPoint operator()(const FitPiece& piece) const {
    RunningMean F, t_s, N, held;
    std::vector<RunningMean> remembered(memory.times_s().size());
    for (const std::size_t i : piece.readings) {
      const RunReading& r = view.data.readings[i];
      F.add(r.capacitance_F);
      t_s.add(r.t_s);
      if (r.has_force()) N.add(view.above_rest_N(r));
      const LoadMemory::State& at = memory.at(i);
      for (std::size_t k = 0; k < remembered.size(); ++k) remembered[k].add(at.memory_Pa[k]);
      held.add(at.held_decades);
    }
    FitPoint p(0, F.mean, noise_F / std::sqrt(static_cast<double>(F.count)), piece.repeat);
    p.cell = piece.cell;
    p.time_s = t_s.mean;
    for (const RunningMean& m : remembered) p.memory_Pa.push_back(m.mean);
    if (!piece.loaded) return p;
    p.pressure_Pa = (N.count > 0 ? N.mean : piece.target_N) / disc_area_m2;
    p.held_decades = held.mean;
    p.gap_F = gap.at((N.count > 0 ? N.mean : piece.target_N) / *view.data.area_m2 * 1e-3);
    return p;
  }
};

}  // namespace

Result<FitData> fit_data_of(const RunData& run, const RunAnalysis& a, double disc_area_m2) {
  if (!run.area_m2) return fail(Errc::invalid_request, "the area of the probe is not known");
  if (!a.c0 || !(a.c0.estimate->standard_error.value_or(0) > 0) || a.levels.empty()) {
    return fail(Errc::invalid_request, "run {} has no levels with a C0 and its error", run.run);
  }
  const RunData data = a.hum ? without(*a.hum, run) : run;
  const RunView view = look_at(data, a.options);
  CellNames names;
  Shown shown;
  cut_levels(view, a, names, shown);
  cut_rests(view, names, shown);
  const LoadMemory memory(view, 1 / disc_area_m2, readings_of(shown.pieces));
  const PointMaker make{view, memory, BranchGap(a, 1e-3 / *run.area_m2), disc_area_m2,
                        a.noise ? a.noise.value() * 1e-15 : 0};
  FitData out;
  out.creep_times_s = memory.times_s();
  out.measured_c0_F = a.c0.value() * 1e-12;
  const double t0_s = time_of_c0(view);
  for (const FitPiece& piece : shown.pieces) {
    FitPoint& p = out.points.emplace_back(make(piece));
    p.delta_capacitance_F -= out.measured_c0_F;
    p.time_s -= t0_s;
  }
  subtract_drift(a, shown.pieces, out);
  out.c0 = C0Error(*a.c0.estimate->standard_error * 1e-12,
                   a.c0.estimate->degrees_of_freedom.value_or(C0Error().degrees_of_freedom));
  for (const Uncertainty& u : a.uncertainties) {
    if (u.result == UncertainResult::c0) out.c0_tolerance = u.expanded / u.value;
  }
  return out;
}

}  // namespace lcrig
