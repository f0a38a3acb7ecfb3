// SPDX-License-Identifier: Apache-2.0
// Commands to the frame other than motions: its limits, STOP, a hold. Knows whether anything may
// move at all. Motions, steps, the recovery and the end of the run command the frame through it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/run/standstill.hpp"

namespace lcrig {

class EventLog;
class FrameWatch;
class InterruptQueue;
class RestMeter;
class RigState;
class Stands;  // progress_keeper.hpp
struct RunSetup;

class FrameDrive {
 public:
  static constexpr Duration kAgain = std::chrono::seconds(1);  // between two attempts to stop

  // All must outlive it.
  FrameDrive(const RunSetup& setup, const EventLog& log, InterruptQueue& interrupts,
             FrameWatch& watch, const RestMeter& meter, StandstillWatch& still);

  // Sets limits and sample rate of a frame that this run commands; of any other frame only the
  // rate.
  Task<Result<>> take_command();
  Task<Result<>> arm(FrameLimits limits);  // the device watches these limits; sent only when they
                                           // change
  void forget_limits() { armed_.reset(); }  // the device may have other limits now
  // Stops now, and records whether standstill was confirmed: by the frame, and by its samples after
  // that.
  Task<> stop();
  // The last STOP of a run. Nobody looks at the samples after it, so it takes a longer look.
  Task<> stop_for_good();
  // Stops again and again, once a second, until standstill is confirmed.
  Task<Stands> stand_still();
  // A person wants it to stand: STOP is sent even if nothing was ordered since the last one.
  void expect_stop() { note_order(last_speed_m_s_); }
  // An order is being sent that may move the frame.
  void note_order(double speed_m_s);
  void see(const FrameSample& sample);  // every sample
  Duration flowing() const;  // samples that are older are not coming any more
  void doubt_standstill();
  void lose_link() { still_.lose(); }
  // The same after the link came back, when no motion was under way. Errors: as LoadFrame::stop.
  Task<Result<>> stop_silently();

  Task<Result<>> hold_force(double force_N);
  Task<Result<>> hold_travel();
  // The held force that the frame returns to after a pause or a loss.
  std::optional<double> held_force_N() const { return held_force_N_; }
  // The frame holds it now, and moves to do so.
  bool is_holding_force() const { return held_force_N_ && !still_.is_asked(); }
  void will_hold(std::optional<double> force_N) { held_force_N_ = force_N; }
  Task<Result<>> restore_hold();

  // Stops the run. From now on nothing that moves the frame is sent, not even by `finally`, until a
  // person has looked. `why` is for people and becomes part of the run's reason. False: there was
  // another reason already, or the run is over.
  bool keep_hands_off(std::string why, Errc code = Errc::frame_fault);
  const std::optional<Error>& hands_off() const;
  Result<> may_move() const;  // checked before every motion

  // The instruments may have received a command, so `finally` has to run.
  bool prepared() const;
  void set_prepared(bool yes);
  bool standing() const { return standing_; }  // the last STOP was confirmed
  // How often the frame confirmed standstill. If it has grown since a request to stop, that request
  // was carried out. A frame that is only observed counts as confirming.
  std::uint64_t stands() const { return stands_; }
  std::uint64_t failed_stops() const { return failed_stops_; }

 private:
  void count_stop(bool stands);
  void tell_failed(std::string why);
  Duration brakes() const;
  std::optional<Duration> sample_period() const;
  Task<> await_still_samples();

  const RunSetup& setup_;
  const EventLog& log_;
  InterruptQueue& interrupts_;
  FrameWatch& watch_;
  const RigState& rig_;
  const RestMeter& meter_;
  StandstillWatch& still_;
  double last_speed_m_s_ = 0;
  MonoTime next_try_{};  // of stand_still
  bool told_failed_ = false;  // since the last STOP that was confirmed
  std::optional<MonoTime> last_sample_;
  // Limits that the frame watches now, and the zero of the travel that they count from.
  struct Armed {
    FrameLimits limits;
    int travel_zeros = 0;
  };
  std::optional<Armed> armed_;
  std::optional<double> held_force_N_;
  bool standing_ = false;
  std::uint64_t stands_ = 0, failed_stops_ = 0;
};

}  // namespace lcrig
