// SPDX-License-Identifier: Apache-2.0
// How wrong a level is, from solutions: three nested meshes give the limit of its own mesh, and the
// next better level on coarse meshes gives what it leaves out. docs/model.md, "Auto".
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "model/level.hpp"
#include "model/mesh_limit.hpp"

namespace lcrig {

// Of delta C, relative, against the finite-strain continuum with the same boundary.
struct ErrorEstimate {
  double relative = 0;  // difference to the best limit, and kDoubtFactor times the doubt in that
  double mesh = 0;  // the part that a finer mesh would take away; 0 without a mesh
  double left_out = 0;  // the part that only a better level would take away
  double order = 0;  // observed order of the mesh; 0: none
  bool settled = true;  // the meshes are in the range where their order can be trusted
  // Finite strain loses its solution here, below the pressure asked for: everything above holds
  // here, and what lies beyond is extrapolated.
  std::optional<Pressure> lost_beyond;
};

// The one safety factor, for all levels and scenes.
inline constexpr double kDoubtFactor = 1.5;

// Keeps what it has solved: several levels and pressures of one specimen cost little more than the
// finest. Not thread-safe.
class ErrorEstimator {
 public:
  explicit ErrorEstimator(const Specimen& specimen);

  // Errors: the level cannot describe the specimen or the pressure at all; finite strain, which
  // rates it, has no solution at any load worth the name.
  Result<ErrorEstimate> estimate(const LevelSettings& settings, Pressure pressure);
  // Of the level's own continuum (of small strains for fem_linear). FEM levels only.
  Result<MeshLimit> mesh_limit(const LevelSettings& settings, Pressure pressure);
  // The level's own answer.
  Result<double> delta_F(const LevelSettings& settings, Pressure pressure);
  const Specimen& specimen() const { return specimen_; }

 private:
  struct Solver {
    std::unique_ptr<LevelModel> model;
    std::optional<Pressure> lost_beyond;  // it has failed above; trying again is long work
    Error why;
  };
  struct Truth {
    double value_F, doubt_F;
    MeshLimit own;  // of the level's mesh, FEM levels only
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
  std::optional<Pressure> lost_;  // by whatever failed last
};

// For one question. Errors as ErrorEstimator::estimate.
Result<ErrorEstimate> estimate_error(const Specimen& specimen, const LevelSettings& settings,
                                     Pressure pressure);

}  // namespace lcrig
