// SPDX-License-Identifier: Apache-2.0
// Judges a stored run again: applies its inputs to a new watch, with the stored samples in between,
// and collects the findings. Pure logic; daemon/replayed_watch reads the rows.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocols/run/frame_watch.hpp"

namespace lcrig {

struct WatchFinding {
  WatchFinding(MonoTime t, EventKind k, std::string w) : at(t), kind(k), why(std::move(w)) {}
  MonoTime at;
  EventKind kind;  // contradiction, limit, overshoot_exceeded
  std::string why;  // as the run writes it into the event
  // The instant does not count: a run writes it when it acts.
  bool operator==(const WatchFinding& other) const {
    return kind == other.kind && why == other.why;
  }
};

class WatchReplay {
 public:
  // Errors: garbled.
  static Result<std::unique_ptr<WatchReplay>> begin(const WatchSetupEvent& setup,
                                                    FrameCapabilities frame);

  // The next sample. Inputs from before it have to be applied first.
  void add(const FrameSample& sample);
  // `rest`: the rest measurement that it names; nullptr: none.
  void apply(const WatchInputEvent& input, const RestMeasurement* rest, MonoTime at);
  // Called with each sample, once the state has taken it.
  using Look = std::function<void(const RigState& rig, const FrameSample& sample, bool is_found)>;
  void set_look(Look look) { look_ = std::move(look); }
  std::int64_t samples() const { return samples_; }
  const std::vector<WatchFinding>& findings() const { return findings_; }

 private:
  WatchReplay(RigFacts facts, std::optional<Forecast> forecast);
  void find(const Finding& finding);

  FrameWatch watch_;
  Look look_;
  MonoTime at_{};
  bool stops_ = false;  // what was found stops the run, and is not carried out yet
  std::int64_t samples_ = 0;
  std::vector<WatchFinding> findings_;
};

}  // namespace lcrig
