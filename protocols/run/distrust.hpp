// SPDX-License-Identifier: Apache-2.0
// What follows when the frame is not believed any more: the run stops at once, and what is still
// allowed depends on what cannot be believed. The run feeds it with samples and events.
#pragma once

#include <optional>
#include <string>

#include "protocols/run/scoped_flag.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/plausibility.hpp"

namespace lcrig {

struct RunParts;  // run_parts.hpp

class Distrust {
 public:
  explicit Distrust(RunParts& run) : run_(run) {}

  // Every sample of a frame that was prepared: whether it contradicts what the frame was told.
  void judge(const FrameSample& sample);
  // What the frame tells by itself.
  void heed(const EventName& kind, const std::string& detail);
  // While it lives, a new zero is what this run asked for.
  ScopedFlag expect_zero() { return ScopedFlag(zeroing_); }

  void disbelieve(const Contradiction& contradiction);
  // The force means nothing any more: every force is allowed, but no motion except away from the
  // specimen.
  void distrust_force();
  // The places that are known belong to another zero, so not even the way back is known.
  void lose_origin(const std::string& why);

  // The frame was stopped for the last time: what moves now is only noted.
  void run_ended() { ended_ = true; }
  const std::optional<std::string>& moves_again() const { return moves_again_; }

 private:
  void heed_fault(const EventName& kind, const std::string& detail);
  void distrust_zero(const std::string& detail);
  void forget_places(const std::string& why);

  RunParts& run_;
  bool zeroing_ = false, ended_ = false;
  std::optional<std::string> moves_again_;  // what was seen then
};

}  // namespace lcrig
