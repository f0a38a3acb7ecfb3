// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/watch_replay.hpp"

#include <utility>

namespace lcrig {

Result<std::unique_ptr<WatchReplay>> WatchReplay::begin(const WatchSetupEvent& setup,
                                                        FrameCapabilities frame) {
  auto rig = rig_of(setup, std::move(frame));
  if (!rig) return fail(rig.error());
  return std::unique_ptr<WatchReplay>(new WatchReplay(*rig, pressing_of(setup, *rig)));
}

WatchReplay::WatchReplay(const WatchedRig& rig, std::optional<Pressing> pressing)
    : pressing_(std::move(pressing)),
      watch_(
          rig, pressing_ ? &*pressing_ : nullptr,
          {[] { return MonoTime(); }, [](const WatchInputEvent&) {}, [](const WatchFigures&) {}}) {}

void WatchReplay::add(const FrameSample& sample) {
  finish_sample();
  ++samples_;
  find(sample.received, watch_.add_pressed(std::span(&sample, 1)));
  open_ = sample;
  if (!watch_.is_prepared()) return;
  auto no = watch_.check(sample);
  if (no && acts() && !watch_.has_ended()) {
    find(sample.received, EventKind::contradiction, std::move(no->why));
  }
}

void WatchReplay::finish_sample() {
  if (!open_) return;
  const FrameSample sample = *std::exchange(open_, std::nullopt);
  const bool moves = watch_.rig().commands && watch_.rig().frame.motion;
  const bool judged = watch_.is_prepared() || !moves;
  auto why = watch_.check_limits(sample);
  if (why && judged && acts()) find(sample.received, EventKind::limit, std::move(*why));
}

void WatchReplay::apply(const WatchInputEvent& input, const Rest* rest, MonoTime at) {
  if (!input.judging.value_or(false)) finish_sample();
  if (input.what == WatchInput::stopping || input.what == WatchInput::stop_pending) stops_ = false;
  find(at, watch_.apply(input, rest, at));
}

void WatchReplay::find(MonoTime at, EventKind kind, std::string why) {
  findings_.emplace_back(at, kind, std::move(why));
  stops_ = true;
}

void WatchReplay::find(MonoTime at, const std::optional<Comparison>& compared) {
  if (!compared || !compared->exceeded) return;
  constexpr EventKind kKind = EventKind::overshoot_exceeded;
  findings_.emplace_back(at, kKind, to_json(compared->event<kKind>()));
}

}  // namespace lcrig
