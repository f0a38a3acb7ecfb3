// SPDX-License-Identifier: Apache-2.0
#include "model/fit_curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lcrig {
namespace {

// Chebyshev interpolation converges by a constant factor per point. The finite elements are smooth
// but slow. The others cost microseconds, and a contact gap bends them sharply near 0.
constexpr std::size_t kCurveNodes = 48, kCurveNodesOfFem = 12;
constexpr double kSlopeStep = 1e-5;  // of the highest pressure, for the slope

}  // namespace

Result<FitCurve> FitCurve::solve(const Specimen& specimen, const LevelSettings& settings,
                                 double highest_Pa) {
  auto model = make_level_model(specimen, settings);
  if (!model) return fail(model.error());
  const bool fem = settings.level == Level::fem_linear || settings.level == Level::fem_finite;
  const std::size_t n = fem ? kCurveNodesOfFem : kCurveNodes;
  FitCurve out;
  out.highest_Pa_ = highest_Pa;
  out.c0_F_ = (*model)->c0_F();
  for (std::size_t k = 0; k < n; ++k) {
    const double angle =
        std::numbers::pi * (2 * static_cast<double>(k) + 1) / (2 * static_cast<double>(n));
    const double place = (1 - std::cos(angle)) / 2, pressure_Pa = place * highest_Pa;
    const auto state = (*model)->at_pressure(Pressure::from_si(pressure_Pa));
    if (!state) return fail(state.error());
    out.place_.push_back(place);
    out.weight_.push_back((k % 2 == 0 ? 1 : -1) * std::sin(angle));
    out.compliance_F_Pa_.push_back(state->delta_capacitance_F / pressure_Pa);
  }
  return out;
}

double FitCurve::at(double pressure_Pa) const {
  if (!(pressure_Pa > 0)) return 0;
  if (pressure_Pa > highest_Pa_) {
    return at(highest_Pa_) + slope(highest_Pa_) * (pressure_Pa - highest_Pa_);
  }
  double above = 0, below = 0;
  for (std::size_t k = 0; k < place_.size(); ++k) {
    const double distance = pressure_Pa / highest_Pa_ - place_[k];
    if (distance == 0) return compliance_F_Pa_[k] * pressure_Pa;
    above += weight_[k] / distance * compliance_F_Pa_[k];
    below += weight_[k] / distance;
  }
  return above / below * pressure_Pa;
}

double FitCurve::slope(double pressure_Pa) const {
  const double step_Pa = kSlopeStep * highest_Pa_;
  const double low_Pa = std::clamp(pressure_Pa - step_Pa, 0.0, highest_Pa_ - 2 * step_Pa);
  return (at(low_Pa + 2 * step_Pa) - at(low_Pa)) / (2 * step_Pa);
}

}  // namespace lcrig
