// SPDX-License-Identifier: Apache-2.0
#include "daemon/liveness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace lcrig {

namespace {

constexpr Duration kMostBetweenChecks = std::chrono::seconds(2);

}  // namespace

void Liveness::watch(std::string name, Duration patience, Beats beats) {
  Part part;
  part.name = std::move(name);
  part.patience = patience;
  part.beats = std::move(beats);
  parts_.push_back(std::move(part));
}

std::vector<std::string> Liveness::check(MonoTime now) {
  std::vector<std::string> stuck;
  const Duration between = now - std::exchange(checked_, now).value_or(now);
  const Duration stood = std::max<Duration>(between - kMostBetweenChecks, Duration::zero());
  for (Part& part : parts_) {
    part.moved += stood;
    const auto beats = part.beats();
    if (!beats || beats != part.last) {
      part.last = beats;
      part.moved = now;
    } else if (now - part.moved > part.patience) {
      stuck.push_back(
          fmt::format("{} has not moved for {:.1f} s", part.name, to_seconds(now - part.moved)));
    }
  }
  return stuck;
}

std::optional<Duration> LoopLag::note(MonoTime due, MonoTime now) {
  const Duration lag = std::max<Duration>(now - due, Duration::zero());
  worst_ = std::max(worst_, lag);
  if (lag <= tolerated_) return std::nullopt;
  return lag;
}

}  // namespace lcrig
