// SPDX-License-Identifier: Apache-2.0
// Brings a run through the loss of an instrument. The frame holds its travel, or goes on holding
// the force if only the meter is lost. The guard stays active, and a stop acts at any time. Owned
// by `Run`.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "protocols/rig/last_seen.hpp"
#include "protocols/run/progress_keeper.hpp"
#include "protocols/run/sample_clock.hpp"
#include "protocols/run/stated_steps.hpp"

namespace lcrig {

struct InterruptRequest;
struct RunParts;

class Losses {
 public:
  explicit Losses(RunParts& run);

  void lose_meter(Error error);
  void lose_frame(Error error);
  void meter_answered(MonoTime t) { last_reading_ = t; }
  // Stops a motion whose samples arrive too late, because nobody can watch it. Samples that waited
  // in this computer are not the frame's fault.
  void judge_age(std::span<const FrameSample> samples);
  // Notices instruments that are connected but silent, and treats them as lost.
  void look();

  bool is_away() const { return meter_ || frame_; }
  bool meter_away() const { return meter_.has_value(); }
  // The reason of the loss; nullptr: the frame is there.
  const Error* frame_away() const { return frame_ ? &frame_->why : nullptr; }
  // True when the step failed because its instrument vanished. Then the step itself is not at
  // fault.
  bool is_of_loss(const Step& step, const Error& error) const;

  // nullopt: the instrument is back, and the step goes on (`wait`) or begins again (`repeat_step`).
  Task<std::optional<InterruptRequest>> survive(StepProgress& progress);
  // Whether somebody asked for a pause while an instrument was lost.
  bool take_pause() { return std::exchange(pause_wanted_, false); }
  // Waits for a lost frame at the end of the run, because `finally` needs it.
  Task<> bring_frame_back();

 private:
  // An instrument that is lost.
  struct Away {
    Away(Error e, MonoTime t, MonoTime d) : why(std::move(e)), since(t), reported(t), data(d) {}
    Error why;
    MonoTime since, reported;
    MonoTime data;  // time of its last reading or sample
    std::int64_t attempts = 0;
    std::string last;  // error of the last attempt
  };

  void lose(std::optional<Away>& away, const std::optional<MonoTime>& data, Error error);
  void tell(const std::optional<Away>& away, const Error* lost) const;
  const Away& first_away() const { return frame_ ? *frame_ : *meter_; }
  bool keeps_vanishing();
  std::optional<InterruptRequest> give_up();
  Task<std::optional<InterruptRequest>> wait_for_return(Duration patience);
  Task<> come_back(std::optional<Error>& useless);
  Task<> bring_back(std::optional<Error>& useless);
  Task<> stand_by();
  Task<ProgressKeeper::Shown> show_waiting();
  InterruptRequest gave_up(Duration patience) const;
  Task<Result<>> try_meter();
  Task<Result<>> try_frame();
  Task<Result<>> rejoin_frame();
  void note_attempt(std::optional<Away>& away, const Error& error);
  void welcome(std::optional<Away>& away);
  Instrument which(const std::optional<Away>& away) const {
    return &away == &meter_ ? Instrument::lcr : Instrument::frame;
  }

  RunParts& run_;
  std::optional<Away> meter_, frame_;
  std::optional<LastSeen> memory_at_loss_;  // the frame's state before the loss
  std::optional<MonoTime> last_reading_;
  std::vector<MonoTime> losses_;  // in the last minute
  std::size_t losses_in_finally_ = 0;
  bool pause_wanted_ = false;
  bool surviving_ = false;  // `survive` runs
  SampleClock sample_clock_;
  StatedSteps stated_steps_;
  MonoTime age_told_{};
};

// Compare a frame that comes back, after a loss or in a later run, with the one that was left.
// Errors: refused, saying what differs; then nothing may be moved.
Result<> compare_origin(RunParts& run, const LastSeen& before);  // before the frame is armed
Result<> compare_place(RunParts& run, const LastSeen& before);  // once it sends samples

}  // namespace lcrig
