// SPDX-License-Identifier: Apache-2.0
// Estimates the error of a level from solutions alone. Nested meshes give the limit of the level's
// own mesh. The next better level, on coarse meshes, gives what the level leaves out.
// docs/model.md, "Auto". Used by the choice of a level, by `lcrig model ladder` and by curves.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "model/level.hpp"
#include "model/mesh_limit.hpp"

namespace lcrig {

// Errors of delta C, relative to the finite-strain continuum with the same boundary.
struct ErrorEstimate {
  double relative = 0;  // difference to the best limit, plus kDoubtFactor times its doubt
  double mesh = 0;  // the part that a finer mesh would remove; 0 without a mesh
  double left_out = 0;  // the part that only a better level would remove
  double order = 0;  // observed order of the mesh; 0: none
  bool settled = true;  // the meshes are fine enough for their order to be trusted
  // Finite strain has no solution above this pressure, which is below the one asked for. The values
  // above then hold at this pressure, and values beyond it are extrapolated.
  std::optional<Pressure> lost_beyond;
};

// The only safety factor. It is the same for all levels and specimens.
inline constexpr double kDoubtFactor = 1.5;

// Keeps its solutions, so several levels and pressures of one specimen cost little more than the
// finest. Not thread-safe.
class ErrorEstimator {
 public:
  explicit ErrorEstimator(const Specimen& specimen);

  // Errors: the level cannot describe the specimen or the pressure at all; finite strain, which
  // serves to rate the level, has no solution even at a thousandth of the pressure.
  Result<ErrorEstimate> estimate(const LevelSettings& settings, Pressure pressure);
  // The limit of the meshes of the level's own continuum (small strains for fem_linear). FEM only.
  Result<MeshLimit> mesh_limit(const LevelSettings& settings, Pressure pressure);
  // The level's own answer.
  Result<double> delta_F(const LevelSettings& settings, Pressure pressure);
  const Specimen& specimen() const { return specimen_; }

 private:
  struct Solver {
    std::unique_ptr<LevelModel> model;
    // it failed above this pressure, and a new attempt would take long
    std::optional<Pressure> lost_beyond;
    Error why;
  };
  struct Truth {
    double value_F, doubt_F;
    MeshLimit own;  // limit of the level's own meshes, FEM levels only
  };
  using Key =
      std::tuple<Level, EnergyForm, Lateral, PressureKind, bool, int, bool, ElectrodeArea, bool>;
  static Key key_of(const LevelSettings& settings);
  Result<Solver*> solver(const LevelSettings& settings);
  Result<Truth> truth(const LevelSettings& settings, Pressure pressure);
  Result<MeshLimit> finite_share(const LevelSettings& settings, Pressure pressure);
  Result<ErrorEstimate> rate(const LevelSettings& settings, Pressure pressure);

  Specimen specimen_;
  std::map<Key, Solver> solvers_;
  std::optional<Pressure> lost_;  // pressure at which the last failed attempt lost the solution
};

// For a single question. Errors: as ErrorEstimator::estimate.
Result<ErrorEstimate> estimate_error(const Specimen& specimen, const LevelSettings& settings,
                                     Pressure pressure);

}  // namespace lcrig
