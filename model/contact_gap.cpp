// SPDX-License-Identifier: Apache-2.0
#include "model/level_parts.hpp"

#include <utility>
#include <vector>

namespace lcrig {
namespace {

class GapModel final : public LevelModel {
 public:
  GapModel(const Specimen& s, std::unique_ptr<LevelModel> model)
      : model_(std::move(model)), gap_(*s.contact_gap) {
    const double scale = model_->c0_F() / s.c0_F();  // fringe factor of the inner level
    for (const auto& capacitor : s.capacitors) {
      inner_m_.push_back(s.dielectric_gap_m(capacitor) / scale);
    }
    plate_F_m_ = kVacuumPermittivity_F_m * s.area_m2();
  }

  std::optional<Pressure> last_converged() const override { return model_->last_converged(); }
  double c0_F() const override {
    double sum = 0;
    for (const double inner : inner_m_) sum += plate_F_m_ / (inner + gap_.height_m);
    return sum;
  }

  Result<StackState> at_pressure(Pressure pressure) override {
    auto state = model_->at_pressure(pressure);
    if (!state) return state;
    const double p = pressure.si();
    const double pressed_out = gap_.height_m * p / (p + gap_.half_pressure_Pa);
    state->delta_capacitance_F = 0;
    for (std::size_t i = 0; i < inner_m_.size(); ++i) {
      double& delta = state->capacitor_delta_F[i];
      const double inner_F = plate_F_m_ / inner_m_[i];
      const double closing = inner_m_[i] * delta / (inner_F + delta) + pressed_out;
      const double whole_m = inner_m_[i] + gap_.height_m;
      delta = lcrig::delta_capacitance_F(plate_F_m_ / whole_m, whole_m, closing);
      state->delta_capacitance_F += delta;
      state->shortening_m += pressed_out;
    }
    return state;
  }

 private:
  std::unique_ptr<LevelModel> model_;
  ContactGap gap_;
  double plate_F_m_ = 0;  // eps0 A
  std::vector<double> inner_m_;  // electrical gap of each capacitor without the contact gap
};

}  // namespace

std::unique_ptr<LevelModel> with_contact_gap(const Specimen& specimen,
                                             std::unique_ptr<LevelModel> model) {
  return std::make_unique<GapModel>(specimen, std::move(model));
}

}  // namespace lcrig
