// SPDX-License-Identifier: Apache-2.0
#include "model/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace lcrig {
namespace {

// rounding error of `hyperelastic`, which is exact with free faces
constexpr double kOneDimensional = 1e-13;
constexpr int kRatingMesh = 0;  // mesh of the better level by which the others are rated
constexpr int kMostRetreats = 4;  // tries with smaller loads after a solution was lost
// share of the requested pressure; a solution for less says nothing about it
constexpr double kLeastShare = 1e-3;

bool has_mesh(Level level) {
  return level >= Level::fem_linear;
}

LevelSettings on_mesh(LevelSettings settings, Level level, int refinement, bool mild) {
  settings.level = level;
  settings.mesh.refinement = refinement;
  settings.mesh.mild_corners = mild;
  settings.form = EnergyForm::a;
  settings.lateral = Lateral::free;
  return settings;
}

// The members of a family from which the limit of one mesh is estimated, from coarse to fine. With
// mild corners a single step scatters, so there are four of them, or as many as exist. At small
// strain each is half as fine as the next, where the family goes down that far. The two coarser
// ones then cost a third of the finest; direct neighbours would cost as much as the finest does.
std::vector<int> members_to(int refinement, bool mild) {
  if (!mild) {
    const int middle = std::max(refinement - 2, kCoarsestMember + 1);
    return {std::max(middle - 2, kCoarsestMember), middle, refinement};
  }
  std::vector<int> members;
  for (int mesh = std::max(refinement - 3, kCoarsestMember); mesh <= refinement; ++mesh) {
    members.push_back(mesh);
  }
  return members;
}

MeshSequence sequence_of(const std::vector<int>& members, bool mild) {
  MeshSequence sequence{corner_orders(mild), {}};
  for (std::size_t i = 1; i < members.size(); ++i) {
    sequence.halvings.push_back(halvings(members[i - 1], members[i], mild));
  }
  return sequence;
}

double relative(double difference, double reference) {
  return reference > 0 ? std::abs(difference) / reference : 0;
}

// The largest relative error of `value` that the doubt in `truth` allows.
double at_most(double value, double truth, double doubt) {
  const double least = std::max(truth - kDoubtFactor * doubt, truth / 10);
  return relative(std::abs(value - truth) + kDoubtFactor * doubt, least);
}

}  // namespace

// A contact gap is not strain, and its contribution is known exactly. The errors are therefore
// those of the stack without it.
ErrorEstimator::ErrorEstimator(const Specimen& specimen) : specimen_(specimen) {
  specimen_.contact_gap.reset();
}

ErrorEstimator::Key ErrorEstimator::key_of(const LevelSettings& s) {
  return {s.level,
          s.form,
          s.lateral,
          s.pressure_kind,
          s.nonlinear,
          s.mesh.refinement,
          s.mesh.mild_corners,
          s.electrode_area,
          s.fringe};
}

Result<ErrorEstimator::Solver*> ErrorEstimator::solver(const LevelSettings& settings) {
  Solver& kept = solvers_[key_of(settings)];
  if (!kept.model) {
    auto made = make_level_model(specimen_, settings);
    if (!made) return fail(made.error());
    kept.model = std::move(*made);
    if (settings.level == Level::fem_finite && settings.mesh.refinement > kCoarsestMember) {
      LevelSettings coarser = settings;
      --coarser.mesh.refinement;
      if (const auto found = solver(coarser)) kept.model->start_from(*(*found)->model);
    }
  }
  return &kept;
}

Result<double> ErrorEstimator::delta_F(const LevelSettings& settings, Pressure pressure) {
  auto found = solver(settings);
  if (!found) return fail(found.error());
  Solver& s = **found;
  if (s.lost_beyond && *s.lost_beyond < pressure) {
    lost_ = s.lost_beyond;
    return fail(s.why);
  }
  auto state = s.model->at_pressure(pressure);
  if (state) return state->delta_capacitance_F;
  if (const auto reached = s.model->last_converged(); reached && *reached < pressure) {
    lost_ = s.lost_beyond = reached;
    s.why = state.error();
  }
  return fail(state.error());
}

Result<MeshLimit> ErrorEstimator::mesh_limit(const LevelSettings& settings, Pressure pressure) {
  const bool mild = settings.level == Level::fem_finite || settings.mesh.mild_corners;
  const auto members = members_to(settings.mesh.refinement, mild);
  std::vector<double> values;
  for (const int mesh : members) {
    LevelSettings member = settings;
    member.mesh.refinement = mesh;
    const auto value = delta_F(member, pressure);
    if (!value) return fail(value.error());
    values.push_back(*value);
  }
  return limit_of(values, sequence_of(members, mild));
}

// The ratio of finite to small strain, as the limit over the same coarse meshes. Errors that both
// have on these meshes cancel.
Result<MeshLimit> ErrorEstimator::finite_share(const LevelSettings& settings, Pressure pressure) {
  const auto members = members_to(kRatingMesh, true);
  std::vector<double> ratios;
  for (const int mesh : members) {
    const auto finite = delta_F(on_mesh(settings, Level::fem_finite, mesh, false), pressure);
    if (!finite) return fail(finite.error());
    const auto linear = delta_F(on_mesh(settings, Level::fem_linear, mesh, true), pressure);
    if (!linear) return fail(linear.error());
    ratios.push_back(*linear != 0 ? *finite / *linear : 1);
  }
  // The order of a quotient of two answers does not follow from the grading, so the doubt relies
  // only on the order that every family guarantees.
  MeshSequence sequence = sequence_of(members, true);
  sequence.orders.least = kLeastOrder;
  return limit_of(ratios, sequence);
}

Result<ErrorEstimator::Truth> ErrorEstimator::truth(const LevelSettings& settings,
                                                    Pressure pressure) {
  if (specimen_.faces == Faces::free) {
    LevelSettings exact = settings;
    exact.level = Level::hyperelastic;
    exact.lateral = Lateral::free;
    exact.electrode_area = ElectrodeArea::reference;
    const auto value = delta_F(exact, pressure);
    return value ? Result<Truth>(Truth{*value, kOneDimensional * *value / kDoubtFactor, {}})
                 : fail(value.error());
  }
  if (settings.level == Level::fem_finite) {
    const auto own = mesh_limit(settings, pressure);
    return own ? Result<Truth>(Truth{own->value, own->doubt, *own}) : fail(own.error());
  }
  const auto own = mesh_limit(settings.level == Level::fem_linear
                                  ? settings
                                  : on_mesh(settings, Level::fem_linear, kRatingMesh, false),
                              pressure);
  if (!own) return fail(own.error());
  const auto share = finite_share(settings, pressure);
  if (!share) return fail(share.error());
  return Truth{own->value * share->value,
               own->doubt * share->value + std::abs(own->value) * share->doubt, *own};
}

Result<ErrorEstimate> ErrorEstimator::rate(const LevelSettings& settings, Pressure pressure) {
  const auto mine = delta_F(settings, pressure);
  if (!mine) return fail(mine.error());
  const auto best = truth(settings, pressure);
  if (!best) return fail(best.error());
  ErrorEstimate estimate;
  const double value = best->value_F;
  estimate.relative = at_most(*mine, value, best->doubt_F);
  if (has_mesh(settings.level) && specimen_.faces != Faces::free) {
    const MeshLimit& own = best->own;
    estimate.mesh = at_most(*mine, own.value, own.doubt);
    estimate.left_out = relative(own.value - value, value);
    estimate.order = own.order;
    estimate.settled = own.settled;
  } else {
    estimate.left_out = relative(*mine - value, value);
  }
  return estimate;
}

Result<ErrorEstimate> ErrorEstimator::estimate(const LevelSettings& settings, Pressure pressure) {
  if (auto ok = check_specimen(specimen_); !ok) return fail(ok.error());
  lost_.reset();
  auto estimate = rate(settings, pressure);
  for (int retreat = 0; !estimate && lost_ && retreat < kMostRetreats; ++retreat) {
    const Pressure at = *std::exchange(lost_, std::nullopt);
    if (!(at.si() > kLeastShare * pressure.si())) break;
    estimate = rate(settings, at);
    if (estimate) estimate->lost_beyond = at;
  }
  return estimate;
}

Result<ErrorEstimate> estimate_error(const Specimen& specimen, const LevelSettings& settings,
                                     Pressure pressure) {
  return ErrorEstimator(specimen).estimate(settings, pressure);
}

}  // namespace lcrig
