// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/prediction.hpp"

#include <algorithm>

#include "protocols/rig/constants.hpp"

namespace lcrig {

bool is_beyond(double observed_N, double predicted_N, ForceClass cell, double noise_N) {
  return observed_N > predicted_N * (1 + cell.part()) + kSampleSigmas * noise_N;
}

void ForcePrediction::judge(ForceComparison& c, double noise_N) const {
  c.exceeded = is_beyond(c.observed_N, c.predicted_N, cell_, noise_N);
}

void ForcePrediction::begin(const Permit& permit) {
  open_ = permit;
  peak_N_.reset();
  if (!permit.presses) return;
  // What the cell still has to show of the last motion may be more than this one presses.
  if (late_) open_->worst_N = std::max(open_->worst_N, late_->first.predicted_N);
  late_.reset();
}

std::optional<ForceComparison> ForcePrediction::add(const FrameSample& sample) {
  if (open_ && sample.force_N) {
    peak_N_ = std::max(peak_N_.value_or(*sample.force_N), *sample.force_N);
  }
  return late_ ? add_late(sample) : std::nullopt;
}

std::optional<ForceComparison> ForcePrediction::add_late(const FrameSample& sample) {
  if (!late_->until) late_->until = sample.received + shown_after_;
  const bool over = sample.received > *late_->until;
  if (!over && sample.force_N) late_->peak_N = std::max(late_->peak_N, *sample.force_N);
  if (!is_beyond(late_->peak_N, late_->first.observed_N, cell_, late_->noise_N)) {
    if (over) late_.reset();
    return std::nullopt;
  }
  ForceComparison c = late_->first;
  c.observed_N = late_->peak_N;
  judge(c, late_->noise_N);
  if (!over && !c.exceeded) return std::nullopt;
  const bool reported = std::exchange(late_, std::nullopt)->reported;
  if (!reported && !c.exceeded) return std::nullopt;
  return c;
}

std::optional<ForceComparison> ForcePrediction::end(const MotionOutcome& outcome, double noise_N) {
  const std::optional<Permit> permit = std::exchange(open_, std::nullopt);
  if (outcome.force_N) peak_N_ = std::max(peak_N_.value_or(*outcome.force_N), *outcome.force_N);
  if (!permit || !permit->presses || !peak_N_) return std::nullopt;
  ForceComparison c;
  c.threshold_N = permit->threshold_N.value_or(permit->limits.force_max.si());
  c.predicted_N = permit->worst_N;
  c.expected_N = permit->expected_N;
  c.observed_N = *peak_N_;
  judge(c, noise_N);
  const bool there = permit->threshold_N && outcome.reason == MotionEnd::target;
  if (!c.exceeded) late_.emplace(c, noise_N, there);
  if (!there && !c.exceeded) return std::nullopt;
  return c;
}

}  // namespace lcrig
