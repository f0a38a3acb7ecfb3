// SPDX-License-Identifier: Apache-2.0
// Acts when the frame can no longer be believed: the run stops at once, and what it may still do
// depends on what cannot be believed. The run passes it samples and events.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "protocols/run/contact_place.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_drive.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/scoped_flag.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

class Distrust {
 public:
  // All must outlive it.
  Distrust(const RunSetup& setup, const EventLog& log, InterruptQueue& interrupts,
           FrameWatch& watch, ContactPlace& contact, FrameDrive& drive)
      : setup_(setup),
        log_(log),
        interrupts_(interrupts),
        watch_(watch),
        contact_(contact),
        drive_(drive) {}

  // Checks every sample of a prepared frame against its orders.
  void judge(const FrameSample& sample);
  // Takes an event that the frame reports by itself.
  void heed(const EventName& kind, const std::string& detail);
  // A zero is being ordered. While the flag lives, a new zero is the one that this run asked for.
  // A stop or a loss may cut the step, and the frame zeroes all the same.
  ScopedFlag expect_zero() {
    cut_zero_ = true;
    return ScopedFlag(zeroing_);
  }
  void zero_settled() { cut_zero_ = false; }
  bool has_cut_zero() const { return cut_zero_; }
  // Why the zero may be another one than this run knows.
  std::string_view cause_of_zero() const;

  void disbelieve(const Contradiction& contradiction);
  // Stops trusting the force: every force is allowed, but no motion except away from the specimen.
  void distrust_force() { watch_.distrust_force(); }
  // Gives up the known places, which belong to another zero. Not even the way back is known then.
  // Returns the same as FrameDrive::keep_hands_off.
  bool lose_origin(const std::string& why);

  // Call after the last stop of the frame: a motion from then on is only noted.
  void run_ended() { watch_.end(); }
  const std::optional<std::string>& moves_again() const { return moves_again_; }

 private:
  void heed_fault(std::string_view what, const std::string& detail);
  void distrust_zero(const std::string& detail);
  void forget_places(const std::string& why);

  const RunSetup& setup_;
  const EventLog& log_;
  InterruptQueue& interrupts_;
  FrameWatch& watch_;
  ContactPlace& contact_;
  FrameDrive& drive_;
  bool zeroing_ = false;
  bool cut_zero_ = false;  // a zero was ordered, and this run has not learned the new one
  std::optional<std::string> moves_again_;  // what was seen of a motion after the end
};

}  // namespace lcrig
