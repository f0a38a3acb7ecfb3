// SPDX-License-Identifier: Apache-2.0
#include "analysis/load_memory.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

constexpr std::size_t kElements = 9;
constexpr double kFastest_s = 1;  // levels settle for about this long before they are read
constexpr double kSlowestOfRun = 1;  // slower elements look like a line in time, as drift does
constexpr double kLoadReached = 0.02;  // relative distance within which a load counts as reached

// Advances an element over a stretch in which the pressure goes straight from `from` to `to`.
double advance_element(double q, double from, double to, double dt_s, double time_s) {
  const double x = dt_s / time_s, decay = std::exp(-x), rate = (to - from) / x;
  return (q - from + rate) * decay + to - rate;
}

// The state at one instant while the force is followed.
struct History {
  const std::vector<double>& times_s;
  double Pa_per_N;
  std::vector<double> q_Pa;
  double t_s = 0, N = 0, reached_s = 0, reached_N = 0;

  void follow(double to_s, double to_N, double noise_N) {
    if (to_s <= t_s) return;
    for (std::size_t k = 0; k < q_Pa.size(); ++k) {
      q_Pa[k] = advance_element(q_Pa[k], N * Pa_per_N, to_N * Pa_per_N, to_s - t_s, times_s[k]);
    }
    if (std::abs(to_N - reached_N) > std::max(kLoadReached * std::abs(reached_N), noise_N)) {
      reached_s = to_s;
      reached_N = to_N;
    }
    t_s = to_s;
    N = to_N;
  }
};

}  // namespace

LoadMemory::LoadMemory(const RunView& view, double Pa_per_N,
                       const std::vector<std::size_t>& readings) {
  const RunData& data = view.data;
  if (!data.has_frame() || readings.empty()) {
    for (const std::size_t i : readings) states_.try_emplace(i);
    return;
  }
  const double slowest = std::max(4 * kFastest_s, kSlowestOfRun * data.duration_s);
  for (std::size_t k = 0; k < kElements; ++k) {
    const double part = static_cast<double>(k) / (kElements - 1);
    times_s_.push_back(kFastest_s * std::pow(slowest / kFastest_s, part));
  }
  History history{times_s_, Pa_per_N, std::vector<double>(kElements, 0.0)};
  history.t_s = history.reached_s = data.readings.front().t_s;
  std::size_t next = 0;
  for (const std::size_t i : readings) {
    const double t_s = data.readings[i].t_s;
    for (; next < data.frame.size() && data.frame[next].t_s <= t_s; ++next) {
      const FramePoint& p = data.frame[next];
      if (std::isnan(p.force_N)) continue;
      history.follow(p.t_s, std::max(0.0, p.force_N - view.rest_N), 6 * view.force_noise_N);
    }
    history.follow(t_s, history.N, 0);
    states_[i] = {history.q_Pa, std::log10(1 + std::max(0.0, t_s - history.reached_s))};
  }
}

}  // namespace lcrig
