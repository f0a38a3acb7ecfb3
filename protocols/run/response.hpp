// SPDX-License-Identifier: Apache-2.0
// Acts on what the checks of the frame find: the run stops at once, and what it may still do
// depends on what is in doubt. The run passes it findings and the events of the frame.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocols/run/scoped_flag.hpp"

namespace lcrig {

class EventLog;
class EventName;
class FrameDrive;
class FrameWatch;
class InterruptQueue;
enum class Doubt;  // checks/check.hpp
enum class Response;
struct Finding;
struct RunSetup;

class Responses {
 public:
  // All must outlive it.
  Responses(const RunSetup& setup, const EventLog& log, InterruptQueue& interrupts,
            FrameWatch& watch, FrameDrive& drive)
      : setup_(setup), log_(log), interrupts_(interrupts), watch_(watch), drive_(drive) {}

  // Acts on the most severe finding of a sample; the others that only note become events.
  void act(const std::vector<Finding>& findings);
  // Acts on what a step found out about the frame.
  void act(Doubt doubt, Response response, const std::string& why);
  // Takes an event that the frame reports by itself.
  void handle(const EventName& kind, const std::string& detail);
  // A zero is being ordered, also of the travel. While the flag lives, a new zero is the one that
  // this run asked for. A stop or a loss may cut the step, and the frame zeroes all the same.
  ScopedFlag expect_zero(bool travel);
  void zero_settled() { cut_zero_ = false; }
  bool has_cut_zero() const { return cut_zero_; }
  // Why the zero may be another one than this run knows.
  std::string_view cause_of_zero() const;

  // Gives up the known places, which belong to another zero. Not even the retreat is known then.
  // Returns the same as FrameDrive::keep_hands_off.
  bool lose_origin(const std::string& why);

  // What was seen of a motion after the end of the run.
  const std::optional<std::string>& moves_again() const { return moves_again_; }

 private:
  void note(const Finding& finding) const;
  void note_motion(const std::vector<Finding>& findings);
  void handle_zero(const std::string& detail);
  void forget_places(const std::string& why);

  const RunSetup& setup_;
  const EventLog& log_;
  InterruptQueue& interrupts_;
  FrameWatch& watch_;
  FrameDrive& drive_;
  bool zeroing_ = false;
  bool cut_zero_ = false;  // a zero was ordered, and this run has not learned the new one
  std::optional<std::string> moves_again_;
};

}  // namespace lcrig
