// SPDX-License-Identifier: Apache-2.0
// The frame of a run: preparation, the loop over steps, interrupts. What each step does is in
// run_steps.cpp, how a run ends in run_finish.cpp.
#include "protocols/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <utility>
#include <variant>

#include "base/as_result.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

// Between two looks; no slewing of a clock is that fast.
constexpr Duration kWallClockStep = 500ms;

// Silence of the sample stream that stops a moving frame: three periods, but never less than two
// batches of the link (100 ms each) and their jitter.
Duration stale_after(double rate_Hz) {
  return std::max<Duration>(from_seconds(3.0 / rate_Hz), 500ms);
}

bool is_stop(const InterruptRequest& request) {
  return request.kind != Interrupt::pause;
}

// A step that failed is an interrupt that nobody asked for.
InterruptRequest request_for(const Error& error) {
  switch (error.code) {
    case Errc::limit_tripped: return InterruptRequest(Interrupt::limit, error);
    case Errc::aborted: return InterruptRequest(Interrupt::abort, error);
    default: return InterruptRequest(Interrupt::fault, error);
  }
}

}  // namespace

EventKind event_of(Interrupt i) {
  switch (i) {
    case Interrupt::pause: return EventKind::pause;
    case Interrupt::abort: return EventKind::abort;
    case Interrupt::freeze: return EventKind::freeze;
    case Interrupt::limit: return EventKind::limit;
    case Interrupt::fault: return EventKind::fault;
    case Interrupt::loss: return EventKind::loss;
  }
  return EventKind::fault;
}

InterruptRequest::InterruptRequest(Interrupt k, std::string w)
    : kind(k),
      code(k == Interrupt::limit ? Errc::limit_tripped : Errc::aborted),
      why(std::move(w)) {}

Run::Run(asio::any_io_executor executor, RunSetup setup)
    : executor_(executor),
      setup_(std::move(setup)),
      guard_(setup_.limits, stale_after(setup_.frame_rate_Hz)),
      sampler_(executor, setup_.clock, setup_.lcr, setup_.lcr_settings, sampler_hooks()),
      interrupts_(executor, 1),
      resumes_(executor, 1) {
  pressing_ = setup_.pressing;
  if (pressing_ && setup_.commands) plausible_.emplace(WatchFigures());
  progress_.run = setup_.run;
  progress_.protocol = setup_.protocol.name;
  progress_.specimen = setup_.specimen;
  progress_.planned_s = setup_.planned_s;
}

Run::~Run() {
  setup_.frame.set_listener(nullptr);
}

Sampler::Hooks Run::sampler_hooks() {
  Sampler::Hooks hooks;
  hooks.tag = [this] {
    ReadingTag tag;
    if (step_ != nullptr) tag.step_id = step_->id;
    tag.repeat = repeat_;
    return tag;
  };
  hooks.taken = [this](const LcrReading& r, const ReadingTag& tag) { on_reading(r, tag); };
  hooks.event = [this](EventKind kind, std::string detail) { event(kind, std::move(detail)); };
  hooks.lost = [this](Error e) { lose_meter(std::move(e)); };
  return hooks;
}

void Run::event(EventName kind, std::string detail) {
  const RunEvent row(setup_.clock.now(), std::move(kind), step_ != nullptr ? step_->id : "",
                     std::move(detail));
  setup_.sink.event(row);
}

// A repeated value is no reading: it is not stored, but that it repeats is told once.
void Run::on_reading(const LcrReading& reading, const ReadingTag& tag) {
  if (reading.fresh) {
    setup_.sink.reading(reading, tag);
  } else if (!repeating_) {
    event(EventKind::repeated, "the meter repeats its last value");
  }
  repeating_ = !reading.fresh;
  last_reading_ = reading.last_byte;
}

void Run::on_samples(std::span<const FrameSample> samples) {
  setup_.sink.samples(samples);
  memory_.feed(samples);
  samples_seen_ += std::ssize(samples);
  last_sample_ = setup_.clock.now();
  if (watched_rest_) watched_rest_->add(samples);
  if (pressing_) pressing_->add(samples);
  judge_age(samples);
  for (const FrameSample& s : samples) {
    if (s.force_N) force_N_ = shown_force_N_ = s.force_N, force_known_ = *last_sample_;
    if (s.travel_m) shown_travel_m_ = s.travel_m;
    if (prepared_) judge_truth(s);
    // What the frame shows before anything was moved is judged by look_at_rest, with advice.
    if (auto why = guard_.check(s); why && !stop_pending_ && (prepared_ || !moves())) {
      event(EventKind::limit, *why);
      interrupt(InterruptRequest(Interrupt::limit, std::move(*why)));
    }
  }
}

void Run::on_frame_event(EventName kind, std::string detail) {
  // The gateway heard nothing from us: it stopped, left force control and forgot the limits.
  const bool watchdog = kind == EventKind::device_watchdog;
  const bool zeroed = kind == EventKind::device_origin && !zeroing_ && setup_.commands;
  const bool fault = is_frame_fault(kind.kind()) && setup_.commands;
  event(kind, detail);
  if (zeroed) distrust_zero(detail);
  if (fault) heed_fault(kind, detail);
  if (watchdog) lose_frame(Error(Errc::disconnected, "the gateway stopped: " + detail));
}

bool Run::moves() const {
  return setup_.frame.capabilities().motion && setup_.commands;
}

void Run::on_frame_lost(Error error) {
  lose_frame(std::move(error));
}

Run::Taken Run::interrupt(InterruptRequest request) {
  if (over_) return Taken::over;
  const bool stops = request.kind != Interrupt::pause;
  // Once `finally` runs only what makes it dangerous may end it: a second abort never does.
  const bool asks = request.kind == Interrupt::pause || request.kind == Interrupt::abort;
  if (finishing_ && asks) return Taken::finally_goes_on;
  if (stops && request.kind != Interrupt::freeze && stop_pending_) return Taken::acts;
  stop_pending_ = stop_pending_ || stops;
  if (request.kind != Interrupt::limit) event(event_of(request.kind), request.why);
  push_interrupt(std::move(request));
  return Taken::acts;
}

bool Run::resume() {
  return progress_.state == RunState::paused && resumes_.try_send(boost::system::error_code());
}

Task<RunResult> Run::execute() {
  start_ = setup_.clock.now();
  setup_.frame.set_listener(this);
  RunResult result;
  std::optional<InterruptRequest> stop;
  // Who stops a run that is still being prepared need not wait for that.
  auto r = co_await (prepare() || stop_asked());
  if (r.index() == 1) {
    prepared_ = false;
    const auto first = std::ranges::find_if(pending_, is_stop);
    if (first != pending_.end()) std::rotate(pending_.begin(), first, std::next(first));
    stop = take_interrupt();
    const bool wanted = stop->kind == Interrupt::abort || stop->kind == Interrupt::freeze;
    if (!wanted) stop->kind = Interrupt::fault;
  } else if (const auto& ready = std::get<0>(r); !ready) {
    stop = InterruptRequest(Interrupt::fault, ready.error());
  } else {
    progress_.state = RunState::running;
    sampler_.start(setup_.protocol.sample.lcr_continuous);
    stop = co_await run_protocol();
  }
  co_await finish(std::move(stop), result);
  result.peak_force_N = guard_.peak_force_N();
  co_return result;
}

Task<Result<>> Run::prepare() {
  if (!setup_.plan_json.empty()) event(EventKind::plan, setup_.plan_json);
  const bool moves = this->moves();
  if (moves) {
    auto stopped = co_await setup_.frame.stop();
    if (!stopped) co_return stopped;
    ++stands_;
  }
  auto armed = co_await arm_frame();
  if (!armed || !moves) co_return armed;
  auto heard = co_await await_samples();  // the first step must know where the frame stands
  if (!heard) co_return heard;
  auto rest = co_await look_at_rest();
  if (rest) prepared_ = true;
  co_return rest;
}

Task<Result<>> Run::arm_frame() {
  const FrameCapabilities caps = frame_capabilities();
  armed_.reset();
  if (!setup_.commands) {
    auto seen = co_await setup_.frame.observe(setup_.frame_rate_Hz);
    if (!seen) co_return fail(seen.error());
    co_return Result<>();
  }
  if (caps.motion || caps.weights) {
    auto armed = co_await arm(device_limits(guard_.limits(), caps));
    if (!armed) co_return armed;
  }
  auto rate = co_await setup_.frame.set_sample_rate(setup_.frame_rate_Hz);
  if (!rate) co_return rate;
  guard_.restart_age(setup_.clock.now());
  guard_.set_watch_age(caps.motion);
  prepared_ = prepared_ || !caps.motion;
  co_return Result<>();
}

// What is told twice is done once; so nobody can fill the queue.
void Run::push_interrupt(InterruptRequest request) {
  const auto same = [&](const InterruptRequest& other) { return other.kind == request.kind; };
  if (std::ranges::none_of(pending_, same)) pending_.push_back(std::move(request));
  interrupts_.try_send(boost::system::error_code());
}

InterruptRequest Run::take_interrupt() {
  InterruptRequest request = std::move(pending_.front());
  pending_.pop_front();
  return request;
}

// A pause can wait until the first step begins.
Task<> Run::stop_asked() {
  while (std::ranges::none_of(pending_, is_stop)) co_await setup_.clock.wait_for(kTick / 5);
}

// The next thing that must interrupt the step: a request, or samples that stopped coming.
Task<> Run::interrupted() {
  while (pending_.empty()) {
    ++beats_;
    tick_ = setup_.clock.now();
    auto r = co_await (interrupts_.async_receive(kAsResult) || setup_.clock.wait_for(kTick));
    if (r.index() == 0) continue;
    watch_wall_clock();
    const MonoTime now = setup_.clock.now();
    const bool away_before = is_away();
    // Instruments that are there but say nothing are as lost as those that are not there.
    if (auto why = guard_.check_age(now); why && !stop_pending_) {
      lose_frame(Error(Errc::no_reply, std::move(*why)));
    }
    if (auto why = sampler_.check_age(now)) lose_meter(Error(Errc::no_reply, std::move(*why)));
    const bool waited_for = finishing_ || progress_.state == RunState::waiting_for_instrument;
    const bool told = is_away() && away_before && waited_for;
    const bool matters = frame_away_ || (meter_away_ && !finishing_);
    if (matters && !told) {
      push_interrupt(
          InterruptRequest(Interrupt::loss, frame_away_ ? frame_away_->why : meter_away_->why));
    }
  }
}

// Times of a run come from the monotonic clock; that the wall clock was set is worth a row.
void Run::watch_wall_clock() {
  const Duration offset(setup_.clock.unix_ns() - setup_.clock.now().time_since_epoch().count());
  const Duration step = offset - wall_offset_.value_or(offset);
  wall_offset_ = offset;
  if (std::chrono::abs(step) < kWallClockStep) return;
  event(ClockStepEvent{to_seconds(step)});
}

Task<std::optional<InterruptRequest>> Run::run_protocol() {
  StepCursor cursor(setup_.protocol.steps, setup_.environment);
  if (setup_.continues) {
    auto stop = co_await confirm_specimen();
    if (stop) co_return stop;
    auto taken = co_await take_over(cursor);
    if (!taken) co_return request_for(taken.error());
  }
  auto stop = co_await run_steps(cursor);
  co_return stop;
}

Task<std::optional<InterruptRequest>> Run::run_steps(StepCursor& cursor) {
  std::optional<InterruptRequest> stop;
  while (const Step* step = cursor.next()) {
    repeat_ = cursor.repeat();
    progress_.repeat = repeat_;
    progress_.repeats = cursor.repeats();
    stop = co_await run_step(*step);
    if (stop) break;
    ++steps_done_;
  }
  co_return stop;
}

Task<std::optional<InterruptRequest>> Run::run_step(const Step& step) {
  step_ = &step;
  progress_.step_id = step.id;
  progress_.step_kind = kind_of(step);
  progress_.elapsed_s = to_seconds(setup_.clock.now() - start_);
  // First, so that a crash right after `step_begin` finds it.
  if (!finishing_) event(point());
  event(EventKind::step_begin, std::string(progress_.step_kind));
  if (setup_.on_step) setup_.on_step(progress_);
  StepProgress progress;
  progress.start_travel_m = std::exchange(first_start_travel_m_, std::nullopt);
  std::optional<InterruptRequest> stop;
  for (bool done = false; !done && !stop;) {
    std::optional<InterruptRequest> request;
    if (pending_.empty()) {
      auto r = co_await (execute_step(step, progress) || interrupted());
      if (r.index() == 0) {
        const auto& result = std::get<0>(r);
        done = result.has_value();
        if (!done) request = request_for(result.error());
        if (!done && is_of_loss(step, result.error())) request->kind = Interrupt::loss;
      }
    }
    // Also one that came in the instant in which the step ended; a loss is then of the next one.
    const bool waits = !pending_.empty() && !(done && pending_.front().kind == Interrupt::loss);
    if (!request && waits) request = take_interrupt();
    if (request) stop = co_await handle(std::move(*request), progress);
  }
  StepEndEvent end;
  if (stop) end.stopped_by = event_of(stop->kind);
  event(end);
  step_ = nullptr;
  co_return stop;
}

Task<std::optional<InterruptRequest>> Run::handle(InterruptRequest request,
                                                  StepProgress& progress) {
  std::optional<InterruptRequest> stop;
  if (request.kind == Interrupt::pause) {
    stop = co_await stay_paused(progress);
  } else if (request.kind != Interrupt::loss) {
    stop = std::move(request);
  } else if (is_away()) {  // else it came back before anybody looked
    stop = co_await survive_loss(progress);
    if (!stop && std::exchange(pause_wanted_, false)) stop = co_await stay_paused(progress);
  }
  co_return stop;
}

// Holds travel and keeps recording until somebody resumes or stops the run.
Task<std::optional<InterruptRequest>> Run::stay_paused(StepProgress& progress) {
  if (progress.begin) progress.spent += setup_.clock.now() - *progress.begin;
  progress.begin.reset();
  const RunState before = std::exchange(progress_.state, RunState::paused);
  co_await stop_frame();
  std::optional<InterruptRequest> stop;
  for (bool resumed = false; !resumed && !stop;) {
    auto r = co_await (resumes_.async_receive(kAsResult) || interrupted());
    resumed = r.index() == 0;
    if (resumed) continue;
    InterruptRequest request = take_interrupt();
    if (request.kind == Interrupt::pause) continue;
    stop = co_await handle(std::move(request), progress);
    progress_.state = RunState::paused;
  }
  if (stop) co_return stop;
  progress_.state = before;
  event(EventKind::resume, "");
  auto held = co_await restore_hold();
  if (!held) stop = request_for(held.error());
  co_return stop;
}

}  // namespace lcrig
