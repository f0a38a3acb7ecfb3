// SPDX-License-Identifier: Apache-2.0
#include "protocols/rest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

constexpr double kStanding_m = 10e-6;
constexpr double kLeastStep_m = 1e-10;  // below any drive's resolution: rounding

}  // namespace

void Rest::add(std::span<const FrameSample> samples) {
  for (const FrameSample& s : samples) {
    moving_ = moving_ || (s.flags & frame_flag::kMoving) != 0;
    if (s.travel_m) {
      travel_min_m_ = travels_ == 0 ? *s.travel_m : std::min(travel_min_m_, *s.travel_m);
      travel_max_m_ = travels_ == 0 ? *s.travel_m : std::max(travel_max_m_, *s.travel_m);
      travel_sum_m_ += *s.travel_m;
      ++travels_;
    }
    if (!s.force_N) continue;
    if (last_N_ && *last_N_ != *s.force_N) ++different_;
    last_N_ = s.force_N;
    ++n_;
    const double d = *s.force_N - mean_;
    mean_ += d / static_cast<double>(n_);
    squares_ += d * (*s.force_N - mean_);
  }
}

double Rest::scatter_N() const {
  return n_ > 1 ? std::sqrt(squares_ / static_cast<double>(n_ - 1)) : 0;
}

double Rest::error_N() const {
  return n_ > 0 ? scatter_N() / std::sqrt(static_cast<double>(n_)) : 0;
}

std::optional<double> Rest::travel_m() const {
  if (travels_ == 0) return std::nullopt;
  return travel_sum_m_ / static_cast<double>(travels_);
}

bool Rest::stands() const {
  return !moving_ && travel_max_m_ - travel_min_m_ <= kStanding_m;
}

std::string Rest::to_json_text() const {
  std::string text = fmt::format(R"({{"force_N":{},"scatter_N":{},"samples":{}}})", force_N(),
                                 scatter_N(), forces());
  if (const auto t = travel_m()) text.insert(text.size() - 1, fmt::format(R"(,"travel_m":{})", *t));
  return text;
}

void TravelStep::add(std::optional<double> travel_m) {
  if (!travel_m) return;
  const double step = last_m_ ? std::abs(*travel_m - *last_m_) : 0;
  last_m_ = travel_m;
  if (step > kLeastStep_m && (!step_m_ || step < *step_m_)) step_m_ = step;
}

}  // namespace lcrig
