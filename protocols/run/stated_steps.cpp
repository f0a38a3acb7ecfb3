// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/stated_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// A ZERO between two samples shifts the grid of the values once, so a single finer step proves
// nothing.
constexpr int kProof = 3, kTogether = 20;  // finer steps, within so many changes
constexpr double kFiner = 0.75;  // part of the stated step; a true one shows whole multiples
// A gateway may round to whole nanometres and micronewtons; each step has two such errors.
constexpr double kRounding_m = 1.2e-9, kRounding_N = 1.2e-6;

std::optional<double> si_of(const auto& quantity) {
  return quantity ? std::optional(quantity->si()) : std::nullopt;
}

}  // namespace

StatedSteps::StatedSteps(const FrameCapabilities& stated)
    : travel_m_(si_of(stated.travel_step), kRounding_m),
      force_N_(si_of(stated.force_step), kRounding_N) {}

std::optional<double> StatedSteps::Steps::add(std::optional<double> value) {
  if (!stated_ || told_ || !value) return std::nullopt;
  const double step = last_ ? std::abs(*value - *last_) : 0;
  last_ = value;
  if (step <= rounding_) return std::nullopt;
  if (++since_first_ > kTogether) finer_ = 0;
  if (step >= kFiner * *stated_ - rounding_) return std::nullopt;
  if (finer_ == 0) since_first_ = 0;
  finest_ = finer_ == 0 ? step : std::min(finest_, step);
  if (++finer_ < kProof) return std::nullopt;
  told_ = true;
  return finest_;
}

std::vector<StatedSteps::News> StatedSteps::add(std::span<const FrameSample> batch) {
  std::vector<News> out;
  for (const FrameSample& sample : batch) {
    if (const auto finer_m = travel_m_.add(sample.travel_m)) {
      out.emplace_back(EventKind::device_travel_step,
                       fmt::format("the travel changed by {:.4g} um, but steps of {:.4g} um are "
                                   "stated for it: travel_step_um of CAPS or of the config is "
                                   "false",
                                   *finer_m * 1e6, travel_m_.stated() * 1e6));
    }
    if (const auto finer_N = force_N_.add(sample.force_N)) {
      out.emplace_back(EventKind::device_force_step,
                       fmt::format("the force changed by {:.4g} mN, but steps of {:.4g} mN are "
                                   "stated for it: force_step_mN of CAPS or of the config is false",
                                   *finer_N * 1e3, force_N_.stated() * 1e3));
    }
  }
  return out;
}

}  // namespace lcrig
