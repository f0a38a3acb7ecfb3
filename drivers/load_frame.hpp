// SPDX-License-Identifier: Apache-2.0
// The interface of every load frame, including a rod with dead weights. Protocols and daemon know
// the machine only through it. Compression is positive; travel grows towards the specimen.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/flags.hpp"
#include "base/force_class.hpp"
#include "base/pressure_area.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "drivers/identity.hpp"
#include "events/payloads.hpp"

namespace lcrig {

// Worst-case bounds of a closed force loop (docs/frame-link.md, section 2).
struct ForceLoop {
  Velocity approach;  // highest speed before contact
  Force contact;  // the force that counts as contact
  ForceRate rate_max;
  Duration lag{};  // a ramp overshoots its target by at most its rate times this
  Force ripple;  // of a held force, to either side
  Stiffness stiffness_max;  // stiffest contact for which these bounds hold
  bool operator==(const ForceLoop&) const = default;
};

struct FrameCapabilities {
  bool motion = false;  // can move by itself
  bool force_hold = false;  // closed force loop in the device
  bool device_stop =
      false;  // stops at a force by itself; otherwise the host's latency adds to the overshoot
  bool weights = false;  // dead weights placed by a person
  bool force_channel = true;  // reports force
  bool travel_channel = true;
  bool zero_force = false, zero_travel = false;
  Force force_max;  // nominal of the load cell
  std::optional<ForceClass> force_class;  // of the load cell; absent: not stated
  Velocity speed_min, speed_max;
  Length travel_min, travel_max;
  double sample_rate_max_Hz = 0;
  std::optional<ForceLoop> force_loop;  // absent: the loop's behaviour is unknown
  // Reaction time and deceleration predict the overshoot (docs/frame-link.md, section 2).
  Duration reaction{};
  Acceleration deceleration;
  // What the samples show, and what the drive does. Absent: not stated.
  std::optional<Length> travel_step;  // all shown travels are multiples of it
  std::optional<Force> force_step;
  std::optional<Duration>
      filter;  // time constant of the cell's filter, at most; part of `reaction`
  std::optional<Length> play;  // lost motion of the drive when it turns round, at most
  ForceClass cell() const { return force_class.value_or(kAssumedForceClass); }
  bool operator==(const FrameCapabilities&) const = default;
};

// Limits that the device supervises. It must have accepted them before any motion.
struct FrameLimits {
  Force force_min, force_max;
  Length travel_min, travel_max;
  Velocity speed_max;
  bool operator==(const FrameLimits&) const = default;
};

struct FrameSample {
  std::int64_t device_seq = 0;
  std::optional<double> device_time_s;
  std::optional<double> force_N;
  std::optional<double> travel_m;  // machine travel, not gap
  std::uint32_t flags = 0;
  MonoTime received;  // when the line that carried it was complete
};

enum class MotionEnd { target, force_limit, travel_limit, stopped, fault };
template <>
inline constexpr EnumWords<5> kWordsOf<MotionEnd>{"target", "force_limit", "travel_limit",
                                                  "stopped", "fault"};

struct MotionOutcome {
  MotionEnd reason = MotionEnd::target;
  std::string detail;  // the device's own words
  std::optional<double> force_N;  // at the end
  std::optional<double> travel_m;
};

template <EventKind kind>
MotionEnded<kind> ended_event(const MotionOutcome& o) {
  return {std::string(to_string(o.reason)), o.force_N, o.travel_m};
}

// A person at the rig, who confirms prompts. `confirm` returns when the person has confirmed.
class Operator {
 public:
  virtual ~Operator() = default;
  virtual Task<Result<>> confirm(std::string prompt) = 0;
  virtual const std::string& prompt() const = 0;  // the open prompt; empty: none
};

// Words for an event that only a person can clear (docs/frame-link.md, section 6): E-stop, drive
// off, shield, a motion that a fault ended. nullopt: not such an event.
std::optional<std::string_view> frame_fault_words(EventKind kind);

// One motion at a time. A motion task returns when the device reports the end of the motion.
// Cancelling the task does not stop the frame; `stop` does.
class LoadFrame {
 public:
  virtual ~LoadFrame() = default;
  virtual const FrameCapabilities& capabilities() const = 0;
  // A token that changes whenever the zero of force or travel may have changed, for any reason.
  // Valid after `identify` or `observe`. nullopt: this frame does not report it.
  virtual std::optional<std::string> origin() const { return std::nullopt; }
  // Sentences about values that the frame and a person state differently. `capabilities` has the
  // worse ones.
  virtual std::vector<std::string> differences() const { return {}; }
  // Takes command and makes the capabilities valid. Stops a moving machine, even if it does not
  // identify itself.
  virtual Task<Result<Identity>> identify() = 0;
  // Like `identify`, but only observes: samples come at this rate (0: none), nothing at the machine
  // changes, and every command is refused until `identify`. Errors: as `identify`; unsupported
  // (this frame cannot be observed without taking command, so nothing was sent).
  virtual Task<Result<Identity>> observe(double rate_Hz) = 0;
  // Sets the limits. The device refuses motion before this.
  virtual Task<Result<>> arm(FrameLimits limits) = 0;
  virtual Task<Result<>> set_sample_rate(double rate_Hz) = 0;
  virtual Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) = 0;
  // Moves in the direction of `speed`'s sign (positive: towards the specimen) until the force is
  // reached from either side. The device stops by itself. Reaching the travel `guard` ends the
  // motion with travel_limit.
  virtual Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed,
                                                       Length guard) = 0;
  // Force-controlled ramp to `force`, which is then held in force control.
  virtual Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) = 0;
  virtual Task<Result<>> hold_travel() = 0;
  virtual Task<Result<>> hold_force(Force force) = 0;
  virtual Task<Result<>> zero(bool force, bool travel) = 0;
  // Dead weights: asks the person, and returns when the mass is on the rod. 0 kg: no weights.
  virtual Task<Result<MotionOutcome>> place_mass(Mass mass) = 0;
  // What dead weights press, to say in the prompts which pressure the force is.
  virtual void show_pressure(const PressureArea& /*pressure*/) {}
  // Stops at once. Valid in every state, never queued behind another command, idempotent. Returns
  // when the device has confirmed standstill.
  virtual Task<Result<>> stop() = 0;
  virtual Task<Result<>> resync() = 0;
  // One attempt to bring back a lost frame (reopening.hpp). Afterwards it stands still, is not
  // armed and sends no samples. Errors as LcrMeter::reconnect.
  virtual Task<Result<Identity>> reconnect();
  virtual void close() = 0;

  // Called for every batch of samples, for every event, and once when the link is lost.
  struct Listener {
    virtual ~Listener() = default;
    virtual void on_samples(std::span<const FrameSample> samples) = 0;
    virtual void on_frame_event(EventName kind, std::string detail) = 0;
    virtual void on_frame_lost(Error error) = 0;
  };
  virtual void set_listener(Listener* listener) = 0;
};

}  // namespace lcrig
