// SPDX-License-Identifier: Apache-2.0
// What the rest of the program knows of a load frame, or of a rod with dead weights.
// Compression is positive, travel grows towards the specimen.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"
#include "drivers/lcr_meter.hpp"

namespace lcrig {

// What a closed force loop is bounded by, in the worst case (docs/frame-link.md, section 2).
struct ForceLoop {
  ForceLoop() = default;
  Velocity approach;  // fastest before contact is made ...
  Force contact;  // ... which is when this force is felt
  ForceRate rate_max;
  Duration lag{};  // a ramp passes its target by at most its rate times this
  Force ripple;  // of a held force, either side
  Stiffness stiffness_max;  // of the contact for which all this holds
  bool operator==(const ForceLoop&) const = default;
};

struct FrameCapabilities {
  FrameCapabilities() = default;
  bool motion = false;  // can move by itself
  bool force_hold = false;  // closed force loop in the device
  bool device_stop =
      false;  // stops at a force by itself; else the host's latency adds to overshoot
  bool weights = false;  // dead weights placed by a person
  bool force_channel = true;  // reports force
  bool travel_channel = true;
  bool zero_force = false, zero_travel = false;
  Force force_max;  // nominal of the load cell
  Velocity speed_min, speed_max;
  Length travel_min, travel_max;
  double sample_rate_max_Hz = 0;
  std::optional<ForceLoop> force_loop;  // absent: nobody has said how it behaves
  // For the predicted overshoot (load-frame reference, section 2): reaction time and deceleration.
  Duration reaction{};
  Acceleration deceleration;
  bool operator==(const FrameCapabilities&) const = default;
};

// Accepted by the device before any motion.
struct FrameLimits {
  FrameLimits() = default;
  Force force_min, force_max;
  Length travel_min, travel_max;
  Velocity speed_max;
};

namespace frame_flag {
constexpr std::uint32_t kMoving = 1U << 0U;
constexpr std::uint32_t kForceControl = 1U << 1U;
constexpr std::uint32_t kForceOverload = 1U << 2U;  // beyond the load cell: force is NULL
constexpr std::uint32_t kAfterGap = 1U << 3U;  // device samples are missing before this one
}  // namespace frame_flag

struct FrameSample {
  FrameSample() = default;
  std::int64_t device_seq = 0;
  std::optional<double> device_time_s;
  std::optional<double> force_N;
  std::optional<double> travel_m;  // machine travel, not gap
  std::uint32_t flags = 0;
  MonoTime received;  // when the line that carried it was complete
};

// Why a motion ended.
enum class MotionEnd { target, force_limit, travel_limit, stopped, fault };
std::string_view to_string(MotionEnd e);

struct MotionOutcome {
  MotionOutcome() = default;
  MotionEnd reason = MotionEnd::target;
  std::string detail;  // the device's own words
  std::optional<double> force_N;  // at the end
  std::optional<double> travel_m;
};

std::string to_json_text(const MotionOutcome& outcome);  // for events

// A person at the rig. `confirm` returns when the person says that it is done.
class Operator {
 public:
  virtual ~Operator() = default;
  virtual Task<Result<>> confirm(std::string prompt) = 0;
  virtual const std::string& prompt() const = 0;  // what is asked now; empty: nothing
};

// What a frame reports of itself that leaves it to a person (docs/frame-link.md, section 6): kinds
// of `on_frame_event`.
namespace frame_event {
constexpr std::string_view kOrigin = "device_origin";  // a zero changed
constexpr std::string_view kWatchdog = "device_watchdog";  // it heard nothing from us
bool is_fault(std::string_view kind);  // E-stop, drive off, shield, a motion that a fault ended
constexpr std::string_view kMotionFault = "motion_fault";  // DONE reason=fault
}  // namespace frame_event

// One motion at a time. A motion task returns when the device says that it ended; cancelling the
// task does not stop the frame, `stop` does.
class LoadFrame {
 public:
  virtual ~LoadFrame() = default;
  virtual const FrameCapabilities& capabilities() const = 0;
  // Changes whenever the zero of force or of travel may have changed, by whomever; valid after
  // `identify` or `observe`. nullopt: this frame does not say.
  virtual std::optional<std::string> origin() const { return std::nullopt; }
  // Capabilities are valid after this returned. Takes command: a machine that moves is stopped,
  // also one that does not say who it is.
  virtual Task<Result<Identity>> identify() = 0;
  // Looks without touching: as `identify`, then samples at this rate (0: none), but nothing at the
  // machine changes, and every command is refused until `identify`. Errors: as `identify`;
  // unsupported (this frame can only be commanded, so nothing was asked of it).
  virtual Task<Result<Identity>> observe(double rate_Hz) = 0;
  // The device refuses motion before this.
  virtual Task<Result<>> arm(FrameLimits limits) = 0;
  virtual Task<Result<>> set_sample_rate(double rate_Hz) = 0;
  virtual Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) = 0;
  // Moves in the direction of `speed`'s sign (positive: towards the specimen) until the force is
  // reached from either side; the device stops by itself. `guard` ends it with travel_limit.
  virtual Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed,
                                                       Length guard) = 0;
  // Force-controlled ramp to `force`, then held in force control.
  virtual Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) = 0;
  virtual Task<Result<>> hold_travel() = 0;
  virtual Task<Result<>> hold_force(Force force) = 0;
  virtual Task<Result<>> zero(bool force, bool travel) = 0;
  // Dead weights: asks the person, returns when the mass is on the rod. 0 kg: everything off.
  virtual Task<Result<MotionOutcome>> place_mass(Mass mass) = 0;
  // Stops now. Valid in every state, never queued behind another command, idempotent; returns when
  // the device confirmed standstill.
  virtual Task<Result<>> stop() = 0;
  virtual Task<Result<>> resync() = 0;
  // One attempt to bring a lost frame back (reopening.hpp). It stands, is not armed, sends no
  // samples. Errors as LcrMeter::reconnect.
  virtual Task<Result<Identity>> reconnect();
  virtual void close() = 0;

  // Called for every batch that arrived, and once when the link is lost.
  struct Listener {
    virtual ~Listener() = default;
    virtual void on_samples(std::span<const FrameSample> samples) = 0;
    virtual void on_frame_event(std::string kind, std::string detail) = 0;
    virtual void on_frame_lost(Error error) = 0;
  };
  virtual void set_listener(Listener* listener) = 0;
};

}  // namespace lcrig
