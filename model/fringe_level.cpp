// SPDX-License-Identifier: Apache-2.0
#include "model/level_parts.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "model/fringe.hpp"

namespace lcrig {
namespace {

constexpr std::size_t kNodes = 10;
constexpr double kMostClosed = 0.2;  // smallest share of the gap that the interpolation covers

// Interpolates L(k0 s) - L(k0) for s = 1 to kMostClosed as (s - 1) q(s), with q at Chebyshev nodes.
// The difference then keeps its digits however small the closing is.
class FringeCurve {
 public:
  explicit FringeCurve(double gap_over_radius) : start_(love_factor(gap_over_radius)) {
    for (std::size_t i = 0; i < kNodes; ++i) {
      const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / kNodes;
      s_[i] = kMostClosed + (1 - kMostClosed) * (1 + std::cos(angle)) / 2;
      q_[i] = (love_factor(gap_over_radius * s_[i]) - start_) / (s_[i] - 1);
      weight_[i] = (i % 2 == 0 ? 1 : -1) * std::sin(angle);
    }
  }
  double start() const { return start_; }
  // closed = 1 - s, 0 to 1.
  double change(double closed) const {
    double top = 0, bottom = 0;
    for (std::size_t i = 0; i < kNodes; ++i) {
      const double distance = (1 - closed) - s_[i];
      if (distance == 0) return -closed * q_[i];
      top += weight_[i] / distance * q_[i];
      bottom += weight_[i] / distance;
    }
    return -closed * top / bottom;
  }

 private:
  double start_;
  std::array<double, kNodes> s_{}, q_{}, weight_{};
};

class FringeModel final : public LevelModel {
 public:
  FringeModel(const Specimen& specimen, std::unique_ptr<LevelModel> model)
      : model_(std::move(model)) {
    for (const auto& capacitor : specimen.capacitors) {
      double thickness = 0;
      for (const auto& layer : capacitor.layers) thickness += layer.thickness_m;
      const double k = thickness / (specimen.disc_diameter_m / 2);
      if (k_.empty() || k != k_.back()) {
        k_.push_back(k);
        curves_.emplace_back(k);
      }
      parts_.push_back({specimen.c0_F(capacitor), curves_.size() - 1});
    }
  }

  std::optional<Pressure> last_converged() const override { return model_->last_converged(); }
  double c0_F() const override {
    double sum = 0;
    for (const auto& part : parts_) sum += curves_[part.curve].start() * part.c0_F;
    return sum;
  }

  Result<StackState> at_pressure(Pressure pressure) override {
    auto state = model_->at_pressure(pressure);
    if (!state) return state;
    state->delta_capacitance_F = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      double& delta = state->capacitor_delta_F[i];
      const double c0 = parts_[i].c0_F;
      const FringeCurve& curve = curves_[parts_[i].curve];
      const double closed = delta / (c0 + delta);  // electrical share of the gap
      if (closed > 1 - kMostClosed) {
        return fail(Errc::invalid_request, "fringe: a gap closed to less than {} of itself",
                    kMostClosed);
      }
      const double change = curve.change(closed);
      delta = (curve.start() + change) * delta + change * c0;
      state->delta_capacitance_F += delta;
    }
    return state;
  }

 private:
  struct Part {
    double c0_F;
    std::size_t curve;
  };
  std::unique_ptr<LevelModel> model_;
  std::vector<double> k_;
  std::vector<FringeCurve> curves_;
  std::vector<Part> parts_;
};

}  // namespace

Result<std::unique_ptr<LevelModel>> with_fringe(const Specimen& specimen,
                                                std::unique_ptr<LevelModel> model) {
  for (const auto& capacitor : specimen.capacitors) {
    double thickness = 0;
    for (const auto& layer : capacitor.layers) thickness += layer.thickness_m;
    const double k = thickness / (specimen.disc_diameter_m / 2);
    if (k > 100 || k < 1e-4) {
      return fail(Errc::invalid_request, "fringe: gap over radius {} is not in 1e-4 to 100", k);
    }
  }
  return std::unique_ptr<LevelModel>(std::make_unique<FringeModel>(specimen, std::move(model)));
}

}  // namespace lcrig
