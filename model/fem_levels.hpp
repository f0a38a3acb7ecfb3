// SPDX-License-Identifier: Apache-2.0
// The two finite-element levels, `fem_linear` and `fem_finite`. make_level_model makes them; the
// design search, the comparison with the paper and tests use them directly.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "model/bracket.hpp"
#include "model/fem_linear_system.hpp"
#include "model/fem_system.hpp"
#include "model/level.hpp"

namespace lcrig {

// Linear elasticity. It is solved once, for unit pressure. Every other pressure scales this field,
// and every partition of a block of one material uses it.
class FemLinear final : public LevelModel {
 public:
  static Result<std::unique_ptr<FemLinear>> make(const Specimen& specimen,
                                                 const LevelSettings& settings);
  Result<StackState> at_pressure(Pressure pressure) override;
  double c0_F() const override { return c0_F_; }
  // The same block cut into other capacitors, with thicknesses from base to top in m. Errors: the
  // specimen is not one block of one soft material, or the sum is not the block's thickness.
  Result<StackState> at_pressure(Pressure pressure, const std::vector<double>& partition_m);
  // Volume that the plane at a height (m, base 0) sweeps downwards, m3 per Pa. The contribution of
  // a layer to the sensitivity is eps times the difference of this volume between its two faces,
  // divided by the square of its thickness.
  double swept_volume_m3_Pa(double height_m);
  const LinearSystem::Report& report() const { return report_; }
  int unknowns() const { return space_.equations(); }

 private:
  FemLinear(StackSpace space, ElectrodeArea area, double c0_F)
      : space_(std::move(space)), area_(area), c0_F_(c0_F) {}
  void sweep();
  Result<StackState> state(Pressure pressure, const std::vector<StackSpace::Capacitor>& capacitors);

  StackSpace space_;
  ElectrodeArea area_;
  double c0_F_;
  std::vector<double> u_;  // per Pa
  // m3/Pa, by row of cells and line from bottom to top
  std::vector<std::array<double, kMostNodes>> swept_;
  LinearSystem::Report report_;
};

// Finite strain, neo-Hooke form A. Loads are reached in steps as large as Newton's method can take.
// Converged loads are kept as starting points for the next ones. The load is vertical and uniform
// over the reference area. True pressure is that force over the current area of the uppermost soft
// face.
class FemFinite final : public LevelModel {
 public:
  static Result<std::unique_ptr<FemFinite>> make(const Specimen& specimen,
                                                 const LevelSettings& settings);
  // Errors: the solution was lost on the way. The message gives the last converged load and the
  // reason.
  Result<StackState> at_pressure(Pressure pressure) override;
  double c0_F() const override { return c0_F_; }
  std::optional<Pressure> last_converged() const override;
  void start_from(LevelModel& coarser) override;
  int iterations() const { return iterations_; }  // of Newton's method, in total
  const FemSystem::Newton& report() const { return report_; }  // of the last step
  int unknowns() const { return space_.equations(); }
  bool stable() const { return system_.stable(); }

 private:
  FemFinite(StackSpace space, const LevelSettings& settings, double c0_F)
      : space_(std::move(space)),
        area_(settings.electrode_area),
        kind_(settings.pressure_kind),
        c0_F_(c0_F),
        system_(space_) {}
  // Pressures are dead pressures. from_coarser: start from the solution on a coarser mesh.
  FemState guess(double pressure_Pa, bool from_coarser) const;
  FemState coarse_state(double pressure_Pa) const;
  bool step_from_coarser(double pressure_Pa);
  bool step_to(double pressure_Pa);
  double last_below(double pressure_Pa) const;
  bool climb(double pressure_Pa, double step, bool from_coarser);
  Result<> reach(double pressure_Pa);
  Result<double> true_of(double dead_Pa);
  Result<double> dead_of(double true_Pa);
  Result<double> close_bracket(double true_Pa, Bracket dead_Pa);
  void keep(double pressure_Pa, FemState state);

  StackSpace space_;
  ElectrodeArea area_;
  PressureKind kind_;
  double c0_F_;
  FemSystem system_;
  std::map<double, FemState> known_;  // by dead pressure, Pa
  double lost_Pa_ = std::numeric_limits<double>::infinity();  // the lowest load not reached
  FemFinite* coarser_ = nullptr;
  int iterations_ = 0;
  FemSystem::Newton report_;
};

Result<std::unique_ptr<LevelModel>> make_fem_linear(const Specimen& specimen,
                                                    const LevelSettings& settings);
Result<std::unique_ptr<LevelModel>> make_fem_finite(const Specimen& specimen,
                                                    const LevelSettings& settings);

}  // namespace lcrig
