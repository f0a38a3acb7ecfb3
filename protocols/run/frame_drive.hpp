// SPDX-License-Identifier: Apache-2.0
// Commands to the frame that are no motions: its limits, STOP, a hold; and whether anything may
// move at all. Motions, steps, the recovery and the end of the run command the frame through this.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocols/run/contact_place.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_truth.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/guard.hpp"

namespace lcrig {

class FrameDrive {
 public:
  // All outlive it.
  FrameDrive(const RunSetup& setup, const EventLog& log, InterruptQueue& interrupts, Guard& guard,
             FrameTruth& truth, const ContactPlace& contact)
      : setup_(setup),
        log_(log),
        interrupts_(interrupts),
        guard_(guard),
        truth_(truth),
        contact_(contact) {}

  // Limits and samples of a frame that this run commands; only samples of another one.
  Task<Result<>> take_command();
  Task<Result<>> arm(FrameLimits limits);  // the device watches these; asked once for each change
  void forget_limits() { armed_.reset(); }  // the device may watch others
  // Stops now, and says whether standstill was confirmed.
  Task<> stop();
  // The same after the link came back, when nothing was under way. Errors: as LoadFrame::stop.
  Task<Result<>> stop_silently();

  Task<Result<>> hold_force(double force_N);
  Task<Result<>> hold_travel();
  // Force control to which the frame returns after a pause or a loss.
  std::optional<double> held_force_N() const { return held_force_N_; }
  void will_hold(std::optional<double> force_N) { held_force_N_ = force_N; }
  Task<Result<>> restore_hold();

  // Stops the run. From now on nothing is sent that moves the frame, not even by `finally`, until a
  // person has looked. `why` is for people and goes into the run's reason.
  void keep_hands_off(std::string why, Errc code = Errc::frame_fault);
  const std::optional<Error>& hands_off() const { return hands_off_; }
  Result<> may_move() const;  // asked before every motion of the frame
  // True when `why` is the text of hands_off(), or the text with which may_move() refuses for it:
  // such a reason is told once.
  bool is_hands_off(std::string_view why) const;

  // Something may have been asked of the instruments: `finally` has to run.
  bool prepared() const { return prepared_; }
  void set_prepared(bool yes) { prepared_ = yes; }
  bool standing() const { return standing_; }  // the last STOP was confirmed
  // How often the frame confirmed standstill. More than before a request to stop: it stands because
  // of it. A frame that is only observed counts as one that confirmed.
  std::uint64_t stands() const { return stands_; }
  std::uint64_t failed_stops() const { return failed_stops_; }

 private:
  void count_stop(bool stands);

  const RunSetup& setup_;
  const EventLog& log_;
  InterruptQueue& interrupts_;
  Guard& guard_;
  FrameTruth& truth_;
  const ContactPlace& contact_;
  std::optional<FrameLimits> armed_;  // what the device watches now
  std::optional<double> held_force_N_;
  std::optional<Error> hands_off_;  // why nothing moves any more
  bool prepared_ = false, standing_ = false;
  std::uint64_t stands_ = 0, failed_stops_ = 0;
};

}  // namespace lcrig
