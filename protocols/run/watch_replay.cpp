// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/watch_replay.hpp"

#include <utility>

namespace lcrig {

Result<std::unique_ptr<WatchReplay>> WatchReplay::begin(const WatchSetupEvent& setup,
                                                        FrameCapabilities frame) {
  auto facts = rig_of(setup, std::move(frame));
  if (!facts) return fail(facts.error());
  auto forecast = forecast_of(setup, *facts);
  return std::unique_ptr<WatchReplay>(new WatchReplay(std::move(*facts), std::move(forecast)));
}

WatchReplay::WatchReplay(RigFacts facts, std::optional<Forecast> forecast)
    : watch_(std::move(facts), std::move(forecast),
             {[] { return MonoTime(); }, [](const WatchInputEvent&) {}, [](const Tolerances&) {},
              [this](std::string why) { findings_.emplace_back(at_, EventKind::fault, why); }}) {}

void WatchReplay::add(const FrameSample& sample) {
  at_ = sample.received;
  ++samples_;
  const std::vector<Finding> findings = watch_.add(sample);
  for (const Finding& f : findings) {
    if (f.check->response == Response::no_pressing) find(f);
  }
  const Finding* worst = most_severe(findings);
  const RigState& rig = watch_.rig();
  if (look_) look_(rig, sample, worst != nullptr);
  if (worst == nullptr || rig.is_stop_pending || stops_ || rig.phase == RunPhase::ended) return;
  find(*worst);
  stops_ = true;
}

void WatchReplay::apply(const WatchInputEvent& input, const RestMeasurement* rest, MonoTime at) {
  at_ = at;
  if (input.what == WatchInput::stopping || input.what == WatchInput::stop_pending) stops_ = false;
  const auto compared = watch_.apply(input, rest, at);
  if (!compared || !compared->exceeded) return;
  constexpr EventKind kKind = EventKind::overshoot_exceeded;
  findings_.emplace_back(at, kKind, to_json(compared->event<kKind>()));
}

void WatchReplay::find(const Finding& finding) {
  findings_.emplace_back(at_, finding.check->event, finding.why);
}

}  // namespace lcrig
