// SPDX-License-Identifier: Apache-2.0
// Executes a protocol on two instruments: the loop over its steps, and its interrupts. The actions
// of steps, the recovery from a loss and the end of a run are parts of their own. The daemon's
// session owns a run.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "protocols/expand.hpp"
#include "protocols/run/finish.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/losses.hpp"
#include "protocols/run/run_parts.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/run/take_over.hpp"

namespace lcrig {

class Run final : private LoadFrame::Listener {
 public:
  Run(asio::any_io_executor executor, RunSetup setup);
  ~Run() override;

  // Runs everything including `finally`. Never cancel it; interrupt it instead.
  Task<RunResult> execute();

  // After `execute`, if the frame was not known to stand: sends STOP once a second, and brings a
  // lost link back, until standstill is confirmed or `gives_up`. Nothing of it is recorded. False:
  // it gave up.
  Task<bool> stop_until_it_stands(std::function<bool()> gives_up);

  // From the io thread, at any time. An interrupt acts within a step, without waiting for its end.
  using Taken = InterruptQueue::Taken;
  Taken interrupt(InterruptRequest request) { return parts_.interrupts.ask(std::move(request)); }
  // Its steps are over, or a stop is about to end them.
  // A person froze it: it ends, and nothing moves.
  bool is_frozen() const { return parts_.interrupts.frozen(); }
  bool is_ending() const {
    return parts_.interrupts.finishing() || parts_.interrupts.stop_pending();
  }
  // false: it is not paused
  bool resume() {
    return parts_.progress.state() == RunState::paused && parts_.interrupts.resume();
  }
  // From the io thread: requests a stop or a pause at the end of a part. Errors: invalid_request.
  Result<PlannedStops::Asked> ask_at(PlannedStops::Kind kind, StopPlace place, std::string why);
  // From the io thread: a person's answer to the open question. Errors: invalid_request.
  Result<Answered> answer(const AnswerValue& given, std::string by,
                          std::optional<std::int64_t> number) {
    return parts_.questions.answer(given, std::move(by), number);
  }
  const std::optional<OpenQuestion>& question() const { return parts_.questions.open(); }
  std::uint64_t stands() const { return parts_.drive.stands(); }
  std::uint64_t failed_stops() const { return parts_.drive.failed_stops(); }
  bool commands() const { return setup_.commands; }
  RunProgress progress() const;  // as of now
  std::optional<double> contact_travel_m() const;
  // For the watchdog: counters that grow while the runner and the sampler are alive.
  std::uint64_t beats() const { return parts_.interrupts.ticks(); }
  const Sampler& sampler() const { return parts_.sampler; }

 private:
  void on_samples(std::span<const FrameSample> samples) override;
  void on_frame_event(EventName kind, std::string detail) override;
  void on_frame_lost(Error error) override { losses_.lose_frame(std::move(error)); }
  void on_reading(const LcrReading& reading, const ReadingTag& tag);
  Sampler::Hooks sampler_hooks();
  void look_around();
  void watch_wall_clock();

  Task<> stop_again();

  Task<Result<>> prepare();
  Task<Result<>> look_at_rest();
  Task<std::optional<InterruptRequest>> run_protocol();
  Task<std::optional<InterruptRequest>> run_finally();
  Task<std::optional<InterruptRequest>> run_steps(StepCursor& cursor);
  Task<std::optional<InterruptRequest>> run_step(const Step& step);
  std::optional<InterruptRequest> take_planned_stop();
  void begin_step(const Step& step);
  void pass_over_done_steps();
  Task<std::optional<InterruptRequest>> handle(InterruptRequest request, StepProgress& progress);
  Task<std::optional<InterruptRequest>> stay_paused(StepProgress& progress);
  Task<> wait_for_resume();

  RunSetup setup_;
  // The values of the numbers in the current step. Written only by the cursors of run_protocol and
  // run_finally; the parts read it.
  Environment values_;
  RunParts parts_;
  Losses losses_;
  TakeOver take_over_;
  Finish finish_;
  Pace pace_;
  std::optional<Duration> wall_offset_;  // wall clock minus the run's clock, at the last look
  bool over_ = false;  // it has ended, and only waits until the frame stands
  bool repeating_ = false;  // the meter's last answer repeated the one before
};

}  // namespace lcrig
