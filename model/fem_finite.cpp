// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "model/fem_capacitance.hpp"
#include "model/fem_levels.hpp"
#include "model/fem_system.hpp"

namespace lcrig {
namespace {

// number of first steps; later ones are smaller where needed and larger where possible
constexpr double kFirstSteps = 8;
// A step smaller than both means that the solution is lost. The first is a share of the load
// reached so far, the second of the requested load.
constexpr double kLeastStep = 1.0 / 32, kLeastStart = 1.0 / 4096;
// Limit of Newton's iterations from the solution of a coarser mesh. Good starts take four, and a
// long search may end on another branch.
constexpr int kMostFromCoarser = 6;
constexpr std::size_t kMostKept = 40;  // converged loads that are kept
constexpr int kMostSecants = 60;
constexpr double kSameLoad = 1e-9;  // relative; as exact as Newton's method is

// Lagrange weights of the points x at t.
std::vector<double> weights_at(const std::vector<double>& x, double t) {
  std::vector<double> w(x.size(), 1.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < x.size(); ++j) w[i] *= i == j ? 1 : (t - x[j]) / (x[i] - x[j]);
  }
  return w;
}

void add(double factor, const FemState& other, FemState& state) {
  for (std::size_t i = 0; i < state.u.size(); ++i) state.u[i] += factor * other.u[i];
  for (std::size_t i = 0; i < state.p.size(); ++i) state.p[i] += factor * other.p[i];
}

}  // namespace

Result<std::unique_ptr<FemFinite>> FemFinite::make(const Specimen& specimen,
                                                   const LevelSettings& settings) {
  auto space = StackSpace::make(specimen, settings.mesh, true);
  if (!space) return fail(space.error());
  std::unique_ptr<FemFinite> model(new FemFinite(std::move(*space), settings, specimen.c0_F()));
  model->known_[0] = model->system_.rest();
  return model;
}

void FemFinite::start_from(LevelModel& coarser) {
  coarser_ = dynamic_cast<FemFinite*>(&coarser);
}

// Extrapolates along the line through the two known loads nearest to the requested one. A parabola
// through three is a worse start, because the corner cells do not follow it. With a coarser mesh,
// the difference to the coarser solution is extrapolated.
FemState FemFinite::guess(double pressure_Pa, bool from_coarser) const {
  std::vector<std::pair<double, const FemState*>> near;
  near.reserve(known_.size());
  for (const auto& [p, state] : known_) near.emplace_back(p, &state);
  std::sort(near.begin(), near.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.first - pressure_Pa) < std::abs(b.first - pressure_Pa);
  });
  const double reach = std::abs(near.front().first - pressure_Pa);
  std::vector<double> at;
  for (const auto& [p, state] : near) {
    const bool helps = at.empty() || std::abs(p - near.front().first) >= reach / 3;
    if (helps && at.size() < 2) at.push_back(p);
  }
  const auto w = weights_at(at, pressure_Pa);
  FemState result = from_coarser ? coarse_state(pressure_Pa) : system_.rest();
  for (std::size_t k = 0; k < at.size(); ++k) {
    add(w[k], known_.at(at[k]), result);
    if (from_coarser && coarser_->known_.contains(at[k])) {
      add(-w[k], coarse_state(at[k]), result);
    }
  }
  return result;
}

void FemFinite::keep(double pressure_Pa, FemState state) {
  if (known_.size() >= kMostKept) {  // drop the load that its neighbours replace best
    auto least = std::next(known_.begin());
    double least_gap = 1e300;
    for (auto it = std::next(known_.begin()); std::next(it) != known_.end(); ++it) {
      const double gap = std::next(it)->first - std::prev(it)->first;
      if (gap < least_gap) {
        least_gap = gap;
        least = it;
      }
    }
    known_.erase(least);
  }
  known_[pressure_Pa] = std::move(state);
}

FemState FemFinite::coarse_state(double pressure_Pa) const {
  return prolong(coarser_->space_, coarser_->known_.at(pressure_Pa), space_);
}

bool FemFinite::step_from_coarser(double pressure_Pa) {
  if (pressure_Pa >= coarser_->lost_Pa_ || !coarser_->reach(pressure_Pa)) return false;
  FemState state = guess(pressure_Pa, true);
  report_ = system_.solve(pressure_Pa, state, kMostFromCoarser);
  iterations_ += report_.iterations;
  // after a large step, a solution that is not stable may lie on another branch
  const bool good = report_.converged && stable();
  if (good) keep(pressure_Pa, std::move(state));
  return good;
}

bool FemFinite::step_to(double pressure_Pa) {
  FemState state = guess(pressure_Pa, false);
  report_ = system_.solve(pressure_Pa, state);
  iterations_ += report_.iterations;
  if (!report_.converged) {  // an extrapolation may be a worse start than the load below
    const auto above = known_.upper_bound(pressure_Pa);
    state = std::prev(above)->second;
    report_ = system_.solve(pressure_Pa, state);
    iterations_ += report_.iterations;
  }
  if (report_.converged) keep(pressure_Pa, std::move(state));
  return report_.converged;
}

double FemFinite::last_below(double pressure_Pa) const {
  return std::prev(known_.upper_bound(pressure_Pa))->first;
}

// Goes up in load steps. `step` is the first one.
bool FemFinite::climb(double pressure_Pa, double step, bool from_coarser) {
  double from = last_below(pressure_Pa);
  while (from < pressure_Pa) {
    const double next = from + step >= pressure_Pa * (1 - 1e-12) ? pressure_Pa : from + step;
    if (from_coarser ? step_from_coarser(next) : step_to(next)) {
      from = next;
      step = report_.iterations <= 5 ? 1.5 * step : step;
      continue;
    }
    step = (next - from) / 2;
    const double least = from_coarser ? pressure_Pa / kFirstSteps
                                      : std::max(kLeastStep * from, kLeastStart * pressure_Pa);
    if (step < least) return false;
  }
  return true;
}

Result<> FemFinite::reach(double pressure_Pa) {
  if (known_.contains(pressure_Pa)) return {};
  if (coarser_ != nullptr && climb(pressure_Pa, pressure_Pa, true)) return {};
  // Not in a single step, even if Newton's method could take it: it might land on another branch.
  if (climb(pressure_Pa, pressure_Pa / kFirstSteps, false)) return {};
  lost_Pa_ = std::min(lost_Pa_, pressure_Pa);
  return fail(Errc::invalid_request,
              "fem_finite: no equilibrium found beyond {:.5g} kPa (asked for {:.5g} kPa): {}; "
              "smallest volume ratio there {:.3g}. At a bonded rim the surface folds onto its "
              "neighbour, and contact is not modelled",
              last_below(pressure_Pa) / 1e3, pressure_Pa / 1e3, report_.why, report_.min_j);
}

Result<double> FemFinite::true_of(double dead_Pa) {
  if (auto ok = reach(dead_Pa); !ok) return fail(ok.error());
  return dead_Pa / space_.top_area_ratio(known_.at(dead_Pa).u);
}

Result<double> FemFinite::close_bracket(double true_Pa, Bracket dead_Pa) {
  for (int i = 0; i < kMostSecants; ++i) {
    const double dead = dead_Pa.next();
    auto found = true_of(dead);
    if (!found) return found;
    const double error = *found - true_Pa;
    if (std::abs(error) <= kSameLoad * true_Pa) return dead;
    dead_Pa.narrow({dead, error});
  }
  return fail(Errc::bug, "fem_finite: the search for {:.5g} kPa true pressure did not end",
              true_Pa / 1e3);
}

// Finds the dead pressure that belongs to a true pressure. The face grows under load, so the search
// goes upwards from the true pressure until it has a bracket, and then closes it.
Result<double> FemFinite::dead_of(double true_Pa) {
  if (kind_ == PressureKind::dead || true_Pa == 0) return true_Pa;
  double low = 0, low_error = -true_Pa, high = true_Pa;
  for (int i = 0; i < kMostSecants; ++i) {
    auto found = true_of(high);
    if (!found) return found;
    const double error = *found - true_Pa;
    if (std::abs(error) <= kSameLoad * true_Pa) return high;
    if (error < 0) {
      low = high;
      low_error = error;
      high *= std::min(1.01 * true_Pa / *found, 1.5);
      continue;
    }
    return close_bracket(true_Pa, Bracket({low, low_error}, {high, error}));
  }
  return fail(Errc::invalid_request,
              "fem_finite: no load gives a true pressure of {:.5g} kPa: the face grows as fast",
              true_Pa / 1e3);
}

// The largest load reached at which no layer has folded over and closed.
std::optional<Pressure> FemFinite::last_converged() const {
  const bool dead = kind_ == PressureKind::dead;
  for (auto it = known_.rbegin(); it != known_.rend(); ++it) {
    const auto& [load_Pa, state] = *it;
    if (capacitance_changes(space_, space_.capacitors(), state.u, 1, area_)) {
      return Pressure::from_si(load_Pa / (dead ? 1 : space_.top_area_ratio(state.u)));
    }
  }
  return std::nullopt;
}

Result<StackState> FemFinite::at_pressure(Pressure pressure) {
  if (auto ok = check_pressure(pressure); !ok) return fail(ok.error());
  const double p = pressure.si();
  const auto dead = dead_of(p);
  if (!dead) return fail(dead.error());
  if (auto ok = reach(*dead); !ok) return fail(ok.error());
  const FemState& state = known_.at(*dead);
  auto changes = capacitance_changes(space_, space_.capacitors(), state.u, 1, area_);
  if (!changes) {
    const auto open = last_converged();
    return fail(changes.error().code, "fem_finite: {} at {:.5g} kPa; the largest load before is {}",
                changes.error().what, p / 1e3,
                open ? fmt::format("{:.5g} kPa", open->si() / 1e3) : "not known");
  }
  StackState result;
  result.pressure_Pa = p;
  result.shortening_m = space_.shortening_m(state.u);
  result.delta_capacitance_F = std::accumulate(changes->begin(), changes->end(), 0.0);
  result.capacitor_delta_F = std::move(*changes);
  return result;
}

Result<std::unique_ptr<LevelModel>> make_fem_finite(const Specimen& specimen,
                                                    const LevelSettings& settings) {
  auto model = FemFinite::make(specimen, settings);
  if (!model) return fail(model.error());
  return std::unique_ptr<LevelModel>(std::move(*model));
}

}  // namespace lcrig
