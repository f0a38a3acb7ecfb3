// SPDX-License-Identifier: Apache-2.0
// Judges a stored run again: applies its inputs to a new watch, with the stored samples in between,
// and collects the findings. Pure logic; daemon/replayed_watch reads the rows.
#pragma once

#include <cstdint>
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
  void apply(const WatchInputEvent& input, const Rest* rest, MonoTime at);
  void end() { finish_sample(); }
  std::int64_t samples() const { return samples_; }
  const std::vector<WatchFinding>& findings() const { return findings_; }

 private:
  WatchReplay(const WatchedRig& rig, std::optional<Pressing> pressing);
  bool acts() const { return !watch_.stop_pending() && !stops_; }
  void find(MonoTime at, EventKind kind, std::string why);
  void find(MonoTime at, const std::optional<Comparison>& compared);
  void finish_sample();

  std::optional<Pressing> pressing_;
  FrameWatch watch_;
  std::optional<FrameSample> open_;  // judged, but not yet by the limits
  bool stops_ = false;  // what was found stops the run, and is not carried out yet
  std::int64_t samples_ = 0;
  std::vector<WatchFinding> findings_;
};

}  // namespace lcrig
