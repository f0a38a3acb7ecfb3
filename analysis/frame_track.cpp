// SPDX-License-Identifier: Apache-2.0
#include "analysis/frame_track.hpp"

#include <algorithm>

#include "storage/flags.hpp"

namespace lcrig {

namespace {

std::optional<double> between(std::optional<double> a, std::optional<double> b, double fraction) {
  if (!a || !b) return std::nullopt;
  return *a + (*b - *a) * fraction;
}

}  // namespace

Result<FrameTrack> FrameTrack::open(const Database& db, std::int64_t run, bool hold,
                                    DeviceClock clock) {
  auto rows = FrameRows::open(db, run);
  if (!rows) return fail(rows.error());
  return FrameTrack(std::move(*rows), hold, std::move(clock));
}

Result<> FrameTrack::advance() {
  auto row = rows_.next();
  if (!row) return fail(row.error());
  before_ = after_;
  after_.reset();
  exhausted_ = *row == nullptr;
  if (exhausted_) return {};
  const FrameRow& stored = **row;
  Sample s;
  const auto time = clock_.at(stored.received_ns, stored.device_time_s);
  s.t_ns = time.t_ns;
  s.of_arrival = time.of_arrival;
  s.clock_s = time.residual_s;
  if (before_) s.t_ns = std::max(s.t_ns, before_->t_ns);
  s.device_seq = stored.device_seq;
  s.after_gap = (stored.flags & frame_flag::kAfterGap) != 0 ||
                (before_ && s.device_seq != before_->device_seq + 1);
  s.force_N = stored.force_N;
  s.travel_m = stored.travel_m;
  after_ = s;
  if (listener_) listener_(s);
  return {};
}

Result<> FrameTrack::drain() {
  while (!exhausted_) {
    if (auto r = advance(); !r) return fail(r.error());
  }
  return {};
}

Result<FrameState> FrameTrack::at(std::int64_t mono_ns) {
  while (!exhausted_ && (!after_ || after_->t_ns < mono_ns)) {
    if (auto r = advance(); !r) return fail(r.error());
  }
  FrameState out;
  if (after_ && after_->t_ns == mono_ns && (hold_ || !before_)) {
    out.force_N = after_->force_N;
    out.travel_m = after_->travel_m;
    return out;
  }
  if (!before_ || before_->t_ns > mono_ns) return out;
  if (hold_) {
    out.force_N = before_->force_N;
    out.travel_m = before_->travel_m;
    return out;
  }
  if (!after_ || after_->after_gap) return out;
  out.clock_s = after_->clock_s;
  out.spacing_ns = after_->t_ns - before_->t_ns;
  const double span = static_cast<double>(out.spacing_ns);
  const double fraction = span > 0 ? static_cast<double>(mono_ns - before_->t_ns) / span : 1.0;
  out.force_N = between(before_->force_N, after_->force_N, fraction);
  out.travel_m = between(before_->travel_m, after_->travel_m, fraction);
  if (out.force_N && span > 0) {
    out.force_rate_N_s = (*after_->force_N - *before_->force_N) / (span * 1e-9);
  }
  return out;
}

}  // namespace lcrig
