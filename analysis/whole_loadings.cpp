// SPDX-License-Identifier: Apache-2.0
// Decides which loadings are cycles of the same experiment. A loading that broke off, or has a
// lower peak on purpose, has another capacitance there; a mean over both kinds would describe
// neither.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

// Shares of the peak. If most loadings are within the first of each other, a loading that is
// further below is left out. If the peaks scatter by more, the second applies.
constexpr double kAlikePeaks = 0.02, kScatteringPeaks = 0.1;
constexpr double kTouches = 0.01;  // of the largest force; less is not a contact
constexpr std::size_t kNamed = 5;  // most numbers in a remark

// The value about which most values lie. If they are not close together: the largest value.
struct Common {
  double value = 0, below = 0;  // `below`: how far below `value` a value may lie
  bool has(double v) const { return v >= value - below && v <= value * (1 + kScatteringPeaks); }
};
Common common_of(const std::vector<double>& values, double noise) {
  const double middle = median(values);
  for (const double part : {kAlikePeaks, kScatteringPeaks}) {
    const double near = std::max(part * middle, noise);
    const auto count =
        std::ranges::count_if(values, [&](double v) { return std::abs(v - middle) <= near; });
    if (2 * count > std::ssize(values)) return {middle, near};
  }
  const double most = *std::ranges::max_element(values);
  return {most, std::max(kScatteringPeaks * most, noise)};
}

// True if the run may have ended inside the last loading: it went wrong, or has nothing after it.
bool may_be_broken_off(const Scene& scene) {
  if (scene.data.listing.exit_status != ExitStatus::success) return true;
  const auto& all = scene.data.readings;
  const auto after = all.begin() + static_cast<std::ptrdiff_t>(scene.loadings.back().last);
  return std::none_of(after, all.end(),
                      [&](const RunReading& r) { return r.has_force() && scene.uses(r); });
}

bool any_is_deep(const std::vector<double>& depths_mm) {
  return std::ranges::any_of(depths_mm, [](double mm) { return mm > 0; });
}

std::string numbers_of(const std::vector<CycleResult>& cycles) {
  std::string out;
  for (std::size_t k = 0; k < std::min(cycles.size(), kNamed); ++k) {
    out += fmt::format("{}{}", k > 0 ? ", " : "", cycles[k].number);
  }
  return cycles.size() > kNamed ? out + ", ..." : out;
}

std::string why_lower(const std::vector<CycleResult>& cycles, double common_N, std::size_t all) {
  const auto [low, high] = std::ranges::minmax_element(cycles, {}, &CycleResult::peak_force_N);
  const std::string peaks =
      cycles.size() == 1
          ? fmt::format("peak of {:.3g} N is", low->peak_force_N)
          : fmt::format("peaks of {:.3g} to {:.3g} N are", low->peak_force_N, high->peak_force_N);
  return fmt::format("{} of {} loadings ({}) left out: their {} not that of the others, {:.3g} N",
                     cycles.size(), all, numbers_of(cycles), peaks, common_N);
}

}  // namespace

std::optional<double> contact_mm(const Scene& scene) {
  if (scene.loadings.empty()) return std::nullopt;
  const auto& frame = scene.data.frame;
  const double touches_N = std::max(kTouches * scene.peak_N, 4 * scene.force_noise_N);
  auto it = std::ranges::lower_bound(frame, scene.loadings.front().begin_s, {}, &FramePoint::t_s);
  while (it != frame.begin()) {
    --it;
    if (it->force_N - scene.rest_N <= touches_N && !std::isnan(it->travel_m)) {
      return it->travel_m * 1e3;
    }
  }
  return std::nullopt;
}

void leave_out_other_loadings(const Scene& scene, CycleResults& out) {
  const std::size_t all = out.cycles.size();
  if (all < 2) return;
  const auto contact = contact_mm(scene);
  std::vector<double> forces_N, depths_mm;
  for (const CycleResult& c : out.cycles) {
    forces_N.push_back(c.peak_force_N);
    depths_mm.push_back(contact && c.peak_travel_mm ? std::abs(*c.peak_travel_mm - *contact) : 0);
  }
  const Common force = common_of(forces_N, 5 * scene.force_noise_N);
  const Common depth = common_of(depths_mm, 0);
  const bool deep = any_is_deep(depths_mm), ended = may_be_broken_off(scene);
  std::vector<CycleResult> whole, broken, lower;
  for (std::size_t k = 0; k < all; ++k) {
    const CycleResult& c = out.cycles[k];
    const double below_N = force.value - c.peak_force_N;
    const double alike_N = std::max(kAlikePeaks * force.value, 5 * scene.force_noise_N);
    if (ended && k + 1 == all && below_N > alike_N) {
      broken.push_back(c);
    } else if (force.has(c.peak_force_N) ||
               // A specimen that has softened needs less force for the same travel.
               (deep && depths_mm[k] > 0 && depth.has(depths_mm[k]))) {
      whole.push_back(c);
    } else {
      lower.push_back(c);
    }
  }
  if (whole.empty() || whole.size() == all) return;
  if (!broken.empty()) {
    out.why_left_out =
        fmt::format("loading {} left out: the run ended inside it, at {:.3g} of {:.3g} N",
                    broken.front().number, broken.front().peak_force_N, force.value);
  }
  if (!lower.empty()) add_remark(out.why_left_out, why_lower(lower, force.value, all));
  lower.insert(lower.end(), broken.begin(), broken.end());
  out.left_out = std::move(lower);
  out.cycles = std::move(whole);
}

}  // namespace lcrig
