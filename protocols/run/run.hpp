// SPDX-License-Identifier: Apache-2.0
// Executes a protocol on two instruments: steps, limits, the three grades of stop, `finally`.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/exit_status.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/expand.hpp"
#include "protocols/protocol.hpp"
#include "protocols/run/point.hpp"
#include "protocols/run/sample_clock.hpp"
#include "protocols/run/sampler.hpp"
#include "protocols/run/sink.hpp"
#include "protocols/watch/guard.hpp"
#include "protocols/watch/plausibility.hpp"
#include "protocols/watch/pressing.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

// pause: hold travel, go on later. abort: stop now, then `finally`. freeze: stop now and stay.
// limit and fault are aborts that nobody asked for; the run has failed.
// loss: an instrument vanished; the protocol's `on_loss` decides.
enum class Interrupt { pause, abort, freeze, limit, fault, loss };
EventKind event_of(Interrupt i);  // whose word is the word of the interrupt

struct InterruptRequest {
  InterruptRequest() = default;
  InterruptRequest(Interrupt k, std::string w);
  InterruptRequest(Interrupt k, Error e) : kind(k), code(e.code), why(std::move(e.what)) {}
  Interrupt kind = Interrupt::abort;
  Errc code = Errc::aborted;
  std::string why;
};

struct RunResult {
  RunResult() = default;
  ExitStatus exit_status = ExitStatus::fail;
  std::string reason;  // empty on success
  std::optional<Errc> code;  // why, when it was no success
  double peak_force_N = 0;
};

// What the run works on. Everything outlives it.
struct RunSetup {
  RunSetup(Clock& c, LcrMeter& l, LoadFrame& f, RunSink& s, const Protocol& p)
      : clock(c), lcr(l), frame(f), sink(s), protocol(p) {}
  Clock& clock;
  LcrMeter& lcr;  // identified and configured
  LoadFrame& frame;  // identified
  RunSink& sink;
  const Protocol& protocol;
  Environment environment;  // parameters bound
  BoundLimits limits;  // of the protocol
  // False: the protocol asks nothing of the frame, which belongs to somebody else. It is only
  // observed, and never stopped.
  bool commands = true;
  double frame_rate_Hz = 50;  // of the samples
  std::optional<Pressing> pressing;  // what bounds the force; of a frame that moves
  std::optional<double> start_gap_m;  // as a person stated it
  std::string plan_json;  // figures and assumptions of the plan, stored with the run
  // Plans again, with the place of contact known, before anything is pressed. May be empty.
  std::function<Task<Result<>>(double start_travel_m, double contact_travel_m)> check_at_contact;
  LcrSettings lcr_settings;  // as read back
  std::optional<double> probe_area_m2;  // force = pressure times this
  double gravity_m_s2 = 9.80665;  // local
  double planned_s = 0;  // of the plan, for the progress bar
  std::int64_t run = 0;
  std::string specimen;
  // `record until confirmed` waits for this.
  Operator* person = nullptr;
  // Begin there, after a person confirmed the specimen, instead of at the first step.
  std::optional<Continuation> continues;
  std::function<void(const RunProgress&)> on_step;  // told when a step begins; may be empty
  std::function<void()> on_stop;  // told when `stands` or `failed_stops` counted; may be empty
};

class Run final : private LoadFrame::Listener {
 public:
  Run(asio::any_io_executor executor, RunSetup setup);
  ~Run() override;

  // Runs everything including `finally`. Never cancelled from outside: interrupts are events.
  Task<RunResult> execute();

  // From the io thread, at any time. An interrupt acts within a step and is never queued behind
  // one.
  // What becomes of it: it acts; `finally` runs and goes on; the run is over.
  enum class Taken { acts, finally_goes_on, over };
  Taken interrupt(InterruptRequest request);
  bool resume();  // false: not paused
  // How often the frame confirmed standstill: more than before an interrupt means that it did so
  // after it. A frame that is only observed counts as told.
  std::uint64_t stands() const { return stands_; }
  std::uint64_t failed_stops() const { return failed_stops_; }
  bool commands() const { return setup_.commands; }
  const RunProgress& progress() const { return progress_; }
  std::optional<double> contact_travel_m() const { return contact_travel_m_; }
  // For the watchdog: grow while the runner, and the sampler, are alive.
  std::uint64_t beats() const { return beats_; }
  const Sampler& sampler() const { return sampler_; }

 private:
  // How often the loop looks by itself at what nobody would tell it.
  static constexpr Duration kTick = std::chrono::milliseconds(100);
  static constexpr Duration kRestTime = std::chrono::milliseconds(500);  // of a look at rest
  using WakeChannel = asio::experimental::channel<void(boost::system::error_code)>;

  // What survives a pause in the middle of a step.
  struct StepProgress {
    std::optional<MonoTime> begin;
    Duration spent{};
    std::int64_t readings = 0;
    std::optional<LoadLevel> level;
    bool moved = false;
    std::optional<double> start_travel_m;  // where a search for contact began
    std::optional<double> away_m;  // where the way back without a contact leads
  };

  // An instrument that vanished.
  struct Away {
    Away(Error e, MonoTime t, MonoTime d) : why(std::move(e)), since(t), reported(t), data(d) {}
    Error why;
    MonoTime since, reported;
    MonoTime data;  // of its last reading or sample
    std::int64_t attempts = 0;
    std::string last;  // what the last attempt said
  };

  void on_samples(std::span<const FrameSample> samples) override;
  void on_frame_event(EventName kind, std::string detail) override;
  void on_frame_lost(Error error) override;

  Task<Result<>> prepare();
  Task<Result<>> arm_frame();
  Task<std::optional<InterruptRequest>> run_protocol();
  Task<std::optional<InterruptRequest>> run_steps(StepCursor& cursor);
  Task<std::optional<InterruptRequest>> run_step(const Step& step);
  Task<std::optional<InterruptRequest>> handle(InterruptRequest request, StepProgress& progress);
  // Waits for one without taking it: whoever raced against this and came first must not lose it.
  Task<> interrupted();
  Task<> stop_asked();
  void push_interrupt(InterruptRequest request);
  InterruptRequest take_interrupt();
  Task<std::optional<InterruptRequest>> stay_paused(StepProgress& progress);
  Task<Result<>> execute_step(const Step& step, StepProgress& progress);
  Task<> finish(std::optional<InterruptRequest> stop, RunResult& result);
  Task<> stop_frame();
  Task<> see_standstill();
  Task<> run_finally(RunResult& result);
  Task<> tell_load(RunResult& result);
  bool may_clear(bool frozen, RunResult& result);

  // run_loss.cpp: an instrument vanished
  void lose_meter(Error error);
  void lose_frame(Error error);
  void lose(std::optional<Away>& away, const std::optional<MonoTime>& data, Error error);
  bool is_of_loss(const Step& step, const Error& error) const;
  bool keeps_vanishing();
  void note_attempt(Away& away, const Error& error);
  bool is_away() const { return meter_away_ || frame_away_; }
  Task<std::optional<InterruptRequest>> survive_loss(StepProgress& progress);
  Task<std::optional<InterruptRequest>> wait_for_return(Duration patience);
  Task<Result<>> bring_back();
  Task<Result<>> try_meter();
  Task<Result<>> try_frame();
  Task<Result<>> rejoin_frame();
  Task<Result<>> await_samples();
  void welcome(std::optional<Away>& away, const char* instrument);
  void begin_again(StepProgress& progress);
  Task<Result<>> restore_hold();
  Result<> compare_with(const FrameMemory& before) const;
  Result<> compare_origin(const FrameMemory& before) const;
  Task<> recover_frame_for_finally();

  // run_resume.cpp: a run that was interrupted goes on
  Task<Result<>> take_over(StepCursor& cursor);
  Task<std::optional<InterruptRequest>> confirm_specimen();
  void pass_over(const Step& step, LcrSettings& settings);
  RunPoint point() const;

  // run_distrust.cpp: the frame is not believed any more
  // Stops the run; from now on nothing is sent that moves the frame, not even by `finally`, until a
  // person has looked. `why` is for people and goes into the run's reason.
  void keep_hands_off(std::string why, Errc code = Errc::frame_fault);
  Result<> may_move() const;
  void tell_hands_off(RunResult& result, bool cleared) const;
  void heed_fault(const EventName& kind, const std::string& detail);
  void distrust_zero(const std::string& detail);
  void lose_origin(const std::string& why);

  Sampler::Hooks sampler_hooks();
  void on_reading(const LcrReading& reading, const ReadingTag& tag);

  Task<Result<>> execute(const ZeroStep& step, StepProgress& progress);
  Task<Result<>> execute(const FindContactStep& step, StepProgress& progress);
  Task<Result<>> execute(const RampStep& step, StepProgress& progress);
  Task<Result<>> execute(const MoveUntilStep& step, StepProgress& progress);
  Task<Result<>> execute(const HoldStep& step, StepProgress& progress);
  Task<Result<>> execute(const MeasureStep& step, StepProgress& progress);
  Task<Result<>> execute(const PlaceWeightStep& step, StepProgress& progress);
  Task<Result<>> execute(const RecordStep& step, StepProgress& progress);
  Task<Result<>> execute(const SetLcrStep& step, StepProgress& progress);
  Task<Result<>> execute(const MarkStep& step, StepProgress& progress);
  Task<Result<>> execute(const RepeatStep& step, StepProgress& progress);
  Task<Result<>> execute(const SweepStep& step, StepProgress& progress);

  Task<Result<>> execute(const SetGapStep& step, StepProgress& progress);

  // What a motion is told: how it begins, and where it has to end.
  struct Order {
    Order() = default;
    Plausibility::Motion motion;
    std::optional<double> travel_m, force_N;  // one of them
    int side = 0;  // of a force: at least (1), at most (-1), within (0)
    double waver_N = 0;  // of a force loop
    bool either_side = false;  // a force that falls to its lower limit ends it as well
  };
  // run_watch.cpp: what the frame shows against what it was told
  enum class Under { nothing, perhaps_contact };  // the probe
  void learn_rest(const Rest& rest, Under under = Under::nothing);
  void learn_scatter(const Rest& rest);
  Plausibility::Motion motion_now(double direction, double speed_m_s) const;
  Plausibility::Motion holding() const;  // a force, with its loop
  void judge_truth(const FrameSample& sample);
  void judge_fall(const FrameSample& sample);
  void disbelieve(const Contradiction& contradiction);
  std::string disagreement(const Order& order, const MotionOutcome& outcome) const;
  Task<Result<>> believe(const Order& order, const MotionOutcome& outcome);

  // run_motion.cpp: one motion, with all that is asked before and compared after it
  using Permit = Pressing::Permit;
  // A motion within its time; anything but `target` is an error. Writes the motion's event.
  Task<Result<MotionOutcome>> timed(const Order& order, Task<Result<MotionOutcome>> motion,
                                    double timeout_s);
  void see_end(const Order& order, const MotionOutcome& outcome);
  Task<Result<>> ready_for(const Permit& permit);
  Order order_of(double force_N, int side, double speed_m_s) const;
  void take_standstill(const MotionOutcome& outcome);
  Task<Result<MotionOutcome>> watched(Order order, Permit permit,
                                      Task<Result<MotionOutcome>> motion, double timeout_s);
  Task<Result<>> move_to_travel(double travel_m, double speed_m_s, double timeout_s);
  Task<Result<>> move_to_force(double force_N, double speed_m_s, double timeout_s);
  Task<Result<>> ramp_to_force(double force_N, double rate_N_s, double timeout_s);
  // What a search for a force is besides; absent: a motion of a step.
  struct Search {
    Search(double end, double least) : end_m(end), least_N(least) {}
    double end_m, least_N;  // stands there at the latest; stops at a force that falls so far
  };
  Task<Result<MotionOutcome>> press_until(double force_N, double speed_m_s, double timeout_s,
                                          std::optional<Search> search);
  Task<Result<>> arm(FrameLimits limits);
  Pressing::State pressing_state() const;
  Result<double> present_force() const;  // N; the last known one, if it is not old
  // What the frame shows while it stands; at least so long. Errors: no_reply.
  Task<Result<Rest>> watch_rest(Duration at_least);
  Task<Result<Rest>> living_rest();  // refused when the force never changes
  Task<Result<>> look_at_rest();
  // run_search.cpp: the way to contact
  Task<Result<Rest>> drifting_rest();
  Task<Result<Rest>> rest_before(const FindContactStep& step);
  double search_speed(const FindContactStep& step, const Rest& rest) const;
  double search_end_m(const FindContactStep& step) const;
  Task<Result<std::optional<MotionOutcome>>> approach(const FindContactStep& step, const Rest& rest,
                                                      double end_m, Duration patience);
  Task<Result<MotionOutcome>> search(const FindContactStep& step, Rest& rest, double end_m,
                                     MonoTime deadline);
  static double felt_beyond_drift_N(const Rest& rest, const Rest& now, Duration ago);
  Result<MotionOutcome> check_touched(MotionOutcome touched) const;
  // run_contact.cpp: whether it is one, and what it is like
  static bool is_contact(const std::vector<Rest>& looks, const Rest& before, double rise_N);
  Task<Result<>> take_contact(const FindContactStep& step, const MotionOutcome& touched,
                              const Rest& rest, const std::vector<Rest>& looks);
  Task<Result<std::vector<Rest>>> step_back(const MotionOutcome& contact, const Rest& before);
  void conclude_stiffness(const std::vector<Rest>& looks, const Rest& before, const Rest& after);
  void place_contact(double travel_m, double force_N);
  void zero_travel(double travel_m);
  bool moves() const;
  FrameCapabilities frame_capabilities() const;  // with travel as the samples show it now
  Task<Result<>> back_off(double clear_m, const FindContactStep& step, const Rest& before,
                          const std::vector<Rest>& looks);
  bool is_loaded(double force_N) const;
  double zero_doubt_N() const;  // so much the zero of the cell may drift
  Task<Result<>> back_away(const Target& to, double speed_m_s, double timeout_s,
                           StepProgress& progress);
  void judge_age(std::span<const FrameSample> samples);
  Task<Result<>> wait_out(double duration_s, StepProgress& progress);
  Result<double> travel_of(const Target& target) const;  // m; travel and gap targets
  double force_of(const Target& target) const;  // N; force and pressure targets
  void aim_at(const std::optional<Target>& target);  // labels the levels that follow
  double aim_at_mass(const PlaceWeightStep& step);  // kg
  void watch_wall_clock();
  static void apply_settings(const SetLcrStep& step, const Environment& env, LcrSettings& s);
  LoadLevel next_level(std::int64_t count);
  void event(EventName kind, std::string detail);
  template <EventPayload P>
  void event(const P& payload) {
    event(P::kKind, to_json(payload));
  }

  asio::any_io_executor executor_;
  RunSetup setup_;
  RunProgress progress_;
  Guard guard_;
  Sampler sampler_;
  std::deque<InterruptRequest> pending_;  // not acted upon yet
  WakeChannel interrupts_;
  WakeChannel resumes_;
  MonoTime start_{};
  const Step* step_ = nullptr;
  bool finishing_ = false;
  bool stop_pending_ = false;
  bool over_ = false;
  bool ending_ = false;  // stopped for the last time
  std::optional<std::string> moves_again_;  // what was seen then
  bool standing_ = false;
  bool prepared_ = false;  // something may have been asked of the instruments
  std::uint64_t stands_ = 0, failed_stops_ = 0;
  std::optional<double> contact_travel_m_;
  std::optional<double> searched_from_m_;  // until contact is found
  double order_speed_m_s_ = 0;  // of the last motion
  std::size_t losses_in_finally_ = 0;
  std::optional<double> held_force_N_;  // force control to return to after a pause
  std::optional<double> target_force_N_;  // of the last load step: the level's label
  std::optional<double> target_pressure_Pa_;
  std::int64_t levels_ = 0;
  std::int64_t level_in_repeat_ = 0, level_repeat_ = -1;
  std::int64_t repeat_ = 0, repeats_ = 0;
  std::int64_t steps_done_ = 0;
  std::optional<double> first_start_travel_m_;  // of the step that a continued run begins with
  std::optional<Away> meter_away_, frame_away_;
  FrameMemory memory_;
  std::optional<FrameMemory> memory_at_loss_;
  std::optional<MonoTime> last_reading_, last_sample_;
  std::vector<MonoTime> losses_;  // of the last minute
  bool pause_wanted_ = false;  // asked for while an instrument was away
  std::int64_t samples_seen_ = 0;
  std::uint64_t beats_ = 0;
  std::optional<Duration> wall_offset_;  // wall clock minus the run's clock, at the last look
  bool repeating_ = false;  // the meter's last answer was the one before
  std::optional<double> force_N_;  // latest that was known ...
  MonoTime force_known_;  // ... and when
  std::optional<Pressing> pressing_;
  std::optional<Plausibility> plausible_;  // of a frame that we move
  ForceScatter scatter_;  // of the unloaded cell, all that was seen of it
  double wavers_N_ = 0;  // scatter of the force when it was looked at last
  double drift_N_s_ = 0;  // of the cell, a magnitude, as far as it is known
  std::optional<double> shown_force_N_, shown_travel_m_;  // by samples, not by DONE
  std::optional<double> done_force_N_;  // by the last DONE
  std::optional<FrameLimits> armed_;  // what the device watches now
  std::optional<Rest> watched_rest_;  // fed while somebody watches
  std::optional<Rest> rest_;  // of the unloaded frame, as it drifts
  std::optional<Rest> bare_;  // the same, when surely nothing pressed
  double travel_zero_m_ = 0;  // at the start of the run, of the zero as it is now
  std::optional<double> start_travel_m_;
  double contact_force_N_ = 0;  // beyond rest, where gap zero is
  SampleClock sample_clock_;
  MonoTime tick_{}, age_told_{};  // the loop came round; an age was told
  bool in_motion_ = false, zeroing_ = false;
  std::optional<Error> hands_off_;  // why nothing moves any more
  bool unconfirmed_ = false;  // a person has not yet said that the specimen was not touched
};

}  // namespace lcrig
