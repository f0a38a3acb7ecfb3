// SPDX-License-Identifier: Apache-2.0
// All levels of the stack model behind one interface: pressure in, shortening and capacitance out.
// Used wherever the model is evaluated: curves, fits, error estimates and the table of the bench.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/enum_words.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"
#include "model/fem_mesh.hpp"
#include "model/specimen.hpp"
#include "model/stretch.hpp"

namespace lcrig {

enum class Level { linear, hyperelastic, bonded, fem_linear, fem_finite };  // cheapest first
template <>
inline constexpr EnumWords<5> kWordsOf<Level>{"linear", "hyperelastic", "bonded", "fem_linear",
                                              "fem_finite"};

struct LevelSettings {
  Level level = Level::hyperelastic;
  EnergyForm form = EnergyForm::a;  // hyperelastic only
  Lateral lateral = Lateral::free;  // hyperelastic only
  // Both kinds are equal at small strain, and under films that keep their area (`bonded`).
  PressureKind pressure_kind = PressureKind::dead;
  bool nonlinear = true;  // bonded only: confined neo-Hookean strain instead of P/E_a
  MeshSettings mesh;  // FEM levels only
  ElectrodeArea electrode_area = ElectrodeArea::reference;  // FEM levels only
  bool fringe = false;  // multiply each capacitor by Love's factor: one medium, no shielding
  bool operator==(const LevelSettings&) const = default;
};

// The stack under load. SI.
struct StackState {
  double pressure_Pa = 0;
  double shortening_m = 0;  // of the whole stack
  double delta_capacitance_F = 0;  // from the change of thickness, never as C - C0
  std::vector<double> capacitor_delta_F;  // base to top
};

// A specimen prepared at one level. It is a copy. Not thread-safe, because solvers keep state.
class LevelModel {
 public:
  virtual ~LevelModel() = default;
  // Compressive pressure >= 0 over the disc. Errors: no equilibrium; the pressure is beyond the
  // level's validity.
  virtual Result<StackState> at_pressure(Pressure pressure) = 0;
  // After a failure, the largest pressure that has an answer; nullopt if it is not known.
  virtual std::optional<Pressure> last_converged() const { return std::nullopt; }
  virtual double c0_F() const = 0;  // unloaded, with the same options (fringe)
  // Offers the model of the same specimen and level on a coarser mesh, whose solutions are good
  // starts. It must live as long as this one. Most levels do not use it.
  virtual void start_from(LevelModel& /*coarser*/) {}
};

// Errors: the specimen is wrong; the level cannot describe it or lacks an option (the message says
// why).
Result<std::unique_ptr<LevelModel>> make_level_model(const Specimen& specimen,
                                                     const LevelSettings& settings);

// C0 k e / (1 - k e) for dielectrics in series. gap_m and closing_m are sums of t/eps_r.
double delta_capacitance_F(double c0_F, double gap_m, double closing_m);

// What every LevelModel refuses.
Result<> check_pressure(Pressure pressure);

}  // namespace lcrig
