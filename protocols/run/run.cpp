// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/run.hpp"

#include <utility>

#include "base/either.hpp"
#include "protocols/run/frame_watch.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// Between two looks. No slewing changes a clock that fast.
constexpr Duration kWallClockStep = 500ms;

// The gateway stops after 1 s without a word, and words are sent every 0.25 s (docs/frame-link.md).
constexpr Duration kSilencing = 750ms;

Task<Result<>> execute_step(const Step& step, RunParts& run, StepProgress& progress) {
  run.labels.aim(facts_of(step));
  auto task = step.action->execute(run, progress);
  co_return co_await std::move(task);
}

}  // namespace

Run::Run(asio::any_io_executor executor, RunSetup setup)
    : setup_(std::move(setup)),
      values_(setup_.environment),
      parts_(
          executor, setup_, values_, [this] { look_around(); }, sampler_hooks()),
      losses_(parts_),
      take_over_(parts_),
      finish_(parts_, losses_, take_over_, [this] { return run_finally(); }),
      pace_(setup_.clock, setup_.planned) {}

std::optional<double> Run::contact_travel_m() const {
  return parts_.rig.contact.travel_m;
}

RunProgress Run::progress() const {
  RunProgress now = parts_.progress.now();
  const auto word = [this](PlannedStops::Kind kind) {
    const auto& waiting = parts_.stops.waiting(kind);
    return waiting ? std::string(to_string(waiting->place)) : std::string();
  };
  now.stops_after = word(PlannedStops::Kind::stop);
  now.pauses_at = word(PlannedStops::Kind::pause);
  pace_.write_to(now);
  return now;
}

Run::~Run() {
  setup_.frame.set_listener(nullptr);
}

Sampler::Hooks Run::sampler_hooks() {
  Sampler::Hooks hooks;
  hooks.tag = [this] {
    ReadingTag tag;
    tag.step_id = parts_.log.step_id();
    tag.repeat = parts_.labels.repeat();
    return tag;
  };
  hooks.taken = [this](const LcrReading& r, const ReadingTag& tag) { on_reading(r, tag); };
  hooks.event = [this](EventKind kind, std::string detail) {
    parts_.log.event(kind, std::move(detail));
  };
  hooks.read_back = [this](const ReadBackEvent& e) { parts_.log.event(e); };
  hooks.unproven = [this](const UnprovenEvent& e) { parts_.log.event(e); };
  hooks.lost = [this](Error e) { losses_.lose_meter(std::move(e)); };
  return hooks;
}

// A repeated value is not stored. An event reports the first of several repeats.
void Run::on_reading(const LcrReading& reading, const ReadingTag& tag) {
  if (reading.fresh) {
    setup_.sink.reading(reading, tag);
  } else if (!repeating_) {
    parts_.log.event(EventKind::repeated, "the meter repeats its last value");
  }
  repeating_ = !reading.fresh;
  losses_.meter_answered(reading.last_byte);
}

void Run::on_samples(std::span<const FrameSample> samples) {
  if (over_) {
    for (const FrameSample& s : samples) parts_.drive.see(s);
    return;
  }
  setup_.sink.samples(samples);
  parts_.meter.add(samples);
  losses_.judge_age(samples);
  parts_.watch.note_stop_pending(parts_.interrupts.stop_pending());
  for (const FrameSample& s : samples) {
    parts_.drive.see(s);
    parts_.response.act(parts_.watch.add(s));
  }
}

void Run::on_frame_event(EventName kind, std::string detail) {
  if (over_) return;
  parts_.log.event(kind, detail);
  parts_.response.handle(kind, detail);
  // The gateway heard nothing from us, so it has stopped, left force control and forgotten the
  // limits.
  if (kind != EventKind::device_watchdog) return;
  std::string why = "the gateway stopped: " + detail;
  const auto own_lag = parts_.interrupts.own_lag(setup_.clock.now());
  if (own_lag && *own_lag >= kSilencing) {
    why += fmt::format("; lcrigd itself was {:.2f} s late: the fault is this computer's",
                       to_seconds(*own_lag));
  }
  losses_.lose_frame(Error(Errc::disconnected, std::move(why)));
}

Task<RunResult> Run::execute() {
  pace_.begin_run();
  setup_.frame.set_listener(this);
  std::optional<InterruptRequest> stop;
  // A stop must not wait for the end of the preparation.
  auto r = co_await either(prepare(), parts_.interrupts.wait_for_stop());
  if (r.index() == 1) {
    parts_.drive.set_prepared(false);
    stop = parts_.interrupts.take_stop();
    const bool wanted = stop->kind == Interrupt::abort || stop->kind == Interrupt::freeze;
    if (!wanted) stop->kind = Interrupt::fault;
  } else if (const auto& ready = std::get<0>(r); !ready) {
    stop = InterruptRequest(Interrupt::fault, ready.error());
  } else {
    parts_.progress.enter<RunState::running>();
    parts_.sampler.start(setup_.protocol.sample.lcr_continuous);
    stop = co_await run_protocol();
  }
  co_return co_await finish_.end(std::move(stop));
}

Task<bool> Run::stop_until_it_stands(std::function<bool()> gives_up) {
  over_ = true;
  parts_.log.close();
  setup_.frame.set_listener(this);
  // The samples of the time after the end come first: without them its word would be enough.
  co_await setup_.clock.wait_for(parts_.drive.flowing());
  while (!parts_.still.holds() && !gives_up()) {
    const MonoTime next = setup_.clock.now() + FrameDrive::kAgain;
    co_await stop_again();
    if (!parts_.still.holds()) co_await setup_.clock.wait_until(next);
  }
  setup_.frame.set_listener(nullptr);
  co_return parts_.still.holds();
}

// One attempt, which needs the link first.
Task<> Run::stop_again() {
  if (!parts_.still.is_lost()) co_return co_await parts_.drive.stop();
  auto back = co_await setup_.frame.reconnect();
  if (!back) co_return;
  auto stopped = co_await parts_.drive.stop_silently();
  if (!stopped) co_return;
  auto rate = co_await setup_.frame.set_sample_rate(setup_.frame_rate_Hz);
  if (!rate) parts_.drive.lose_link();
}

Task<Result<>> Run::prepare() {
  if (!setup_.plan_json.empty()) parts_.log.event(EventKind::plan, setup_.plan_json);
  parts_.log.event(parts_.watch.setup_event());
  const bool moves = setup_.moves();
  if (moves) {
    auto stopped = co_await parts_.drive.stop_silently();
    if (!stopped) co_return stopped;
  }
  auto armed = co_await parts_.drive.take_command();
  if (!armed || !moves) co_return armed;
  // The first step needs to know where the frame stands.
  auto heard = co_await parts_.meter.await_samples(parts_.needs_force());
  if (!heard) co_return heard;
  auto rest = co_await look_at_rest();
  if (rest) parts_.drive.set_prepared(true);
  co_return rest;
}

// Before anything moves, checks that the frame stands, and where.
Task<Result<>> Run::look_at_rest() {
  auto rest = co_await parts_.meter.measure(RestMeter::kRestTime);
  if (!rest) co_return fail(rest.error());
  parts_.log.event(rest->event<EventKind::rest>());
  if (!rest->stands()) {
    co_return fail(Errc::busy, "the frame moves, and nobody here told it to: stop whoever does");
  }
  const BoundLimits& limits = parts_.rig.limits;
  const double force_N = rest->force_N();
  if (setup_.continues) {  // the specimen of a continued run may be loaded
    parts_.watch.learn_noise(*rest);
  } else if (force_N < limits.force_min_N || force_N > limits.force_max_N) {
    co_return fail(
        Errc::limit_tripped,
        "the load cell shows {:.4f} N before anything was moved, the limits are {:.4g} to "
        "{:.4g} N: unload it, or zero it at the machine",
        force_N, limits.force_min_N, limits.force_max_N);
  } else {
    parts_.watch.learn_zero(*rest);
  }
  parts_.watch.stand();
  const auto start_m = rest->travel_m();
  parts_.watch.start_at(start_m);
  if (setup_.start_gap_m && start_m) parts_.watch.place_contact(*start_m + *setup_.start_gap_m, 0);
  co_return Result<>();
}

// Notices conditions that cause no event. Called during steps, and while the run waits for a person
// or an instrument.
void Run::look_around() {
  watch_wall_clock();
  losses_.look();
}

// Times of a run come from the monotonic clock. A change of the wall clock is recorded as an event.
void Run::watch_wall_clock() {
  const Duration offset(setup_.clock.unix_ns() - setup_.clock.now().time_since_epoch().count());
  const Duration step = offset - wall_offset_.value_or(offset);
  wall_offset_ = offset;
  if (std::chrono::abs(step) < kWallClockStep) return;
  parts_.log.event(ClockStepEvent{to_seconds(step)});
}

Task<std::optional<InterruptRequest>> Run::run_protocol() {
  StepCursor cursor(setup_.protocol.steps, values_);
  if (setup_.continues) {
    auto stop = co_await take_over_.confirm_specimen();
    if (stop) co_return stop;
    auto taken = co_await take_over_.pass_done_steps(cursor);
    if (!taken) co_return request_for(taken.error());
    pass_over_done_steps();
  }
  const PlannedStops::Walk walk(parts_.stops, cursor, setup_.continues.has_value());
  co_return co_await run_steps(cursor);
}

void Run::pass_over_done_steps() {
  Environment environment = setup_.environment;
  StepCursor done(setup_.protocol.steps, environment);
  for (std::int64_t i = 0; i < parts_.progress.steps_done(); ++i) {
    if (const Step* step = done.next()) pace_.pass_over(step->id);
  }
}

Task<std::optional<InterruptRequest>> Run::run_finally() {
  pace_.begin_finally();
  StepCursor cursor(setup_.protocol.finally_steps, values_);
  co_return co_await run_steps(cursor);
}

Task<std::optional<InterruptRequest>> Run::run_steps(StepCursor& cursor) {
  std::optional<InterruptRequest> stop;
  while (const Step* step = cursor.next()) {
    stop = take_planned_stop();
    if (stop) break;
    parts_.labels.enter_repeat(cursor.repeat());
    parts_.progress.enter_repeat(cursor.repeat(), cursor.repeats());
    stop = co_await run_step(*step);
    if (stop) break;
    parts_.stops.leave(*step);
    parts_.progress.count_step();
  }
  co_return stop;
}

// The planned stop or pause that is due before the next step. A pause takes effect in that step,
// before it does anything.
std::optional<InterruptRequest> Run::take_planned_stop() {
  if (parts_.interrupts.finishing()) return std::nullopt;
  using Kind = PlannedStops::Kind;
  const std::int64_t done = parts_.progress.steps_done();
  if (const auto stop = parts_.stops.take_due(Kind::stop, done)) {
    return InterruptRequest(Interrupt::stop_after,
                            fmt::format("after the {}, step {}: {}", place_words(stop->place),
                                        stop->step_id, stop->why));
  }
  if (const auto pause = parts_.stops.take_due(Kind::pause, done)) {
    interrupt(InterruptRequest(Interrupt::pause,
                               fmt::format("at the end of the {}, step {}: {}",
                                           place_words(pause->place), pause->step_id, pause->why)));
  }
  return std::nullopt;
}

Result<PlannedStops::Asked> Run::ask_at(PlannedStops::Kind kind, StopPlace place, std::string why) {
  const auto planned_s = [this](const std::string& id) { return pace_.planned_of(id); };
  auto asked =
      parts_.stops.ask(kind, place, std::move(why), parts_.progress.steps_done(), planned_s);
  if (asked) asked->seconds += pace_.left_of_step_s();
  return asked;
}

void Run::begin_step(const Step& step) {
  parts_.stops.enter(step);
  parts_.log.begin_step(step);
  parts_.progress.enter_step(step);
  pace_.begin_step(step.id);
  // Written before `step_begin`, so that a crash right after it finds the state.
  if (!parts_.interrupts.finishing()) parts_.log.event(parts_.point());
  parts_.log.event(EventKind::step_begin, std::string(kind_of(step)));
  if (setup_.on_step) setup_.on_step(progress());
}

Task<std::optional<InterruptRequest>> Run::run_step(const Step& step) {
  begin_step(step);
  const auto remembered = step.action->new_progress();
  StepProgress& progress = *remembered;
  progress.go_on_from(take_over_.take_left_off());
  std::optional<InterruptRequest> stop;
  for (bool done = false; !done && !stop;) {
    std::optional<InterruptRequest> request;
    if (parts_.interrupts.empty()) {
      auto r = co_await either(execute_step(step, parts_, progress), parts_.interrupts.wait());
      if (r.index() == 0) {
        const auto& result = std::get<0>(r);
        done = result.has_value();
        if (!done) request = request_for(result.error());
        if (!done && losses_.is_of_loss(step, result.error())) request->kind = Interrupt::loss;
      }
    }
    // Includes a request that came in the instant when the step ended. A loss at that instant
    // belongs to the next step.
    const bool waits =
        !parts_.interrupts.empty() && !(done && parts_.interrupts.next().kind == Interrupt::loss);
    if (!request && waits) request = parts_.interrupts.take();
    if (request) stop = co_await handle(std::move(*request), progress);
  }
  StepEndEvent end;
  if (stop) end.stopped_by = event_of(stop->kind);
  parts_.log.event(end);
  parts_.log.end_step();
  co_return stop;
}

Task<std::optional<InterruptRequest>> Run::handle(InterruptRequest request,
                                                  StepProgress& progress) {
  std::optional<InterruptRequest> stop;
  if (request.kind == Interrupt::pause) {
    stop = co_await stay_paused(progress);
  } else if (request.kind != Interrupt::loss) {
    stop = std::move(request);
  } else if (losses_.is_away()) {  // else the instrument is back already
    stop = co_await losses_.survive(progress);
    if (!stop && losses_.take_pause()) stop = co_await stay_paused(progress);
  }
  co_return stop;
}

// Pending until somebody resumes the run, and that is possible only once the frame stands.
Task<> Run::wait_for_resume() {
  const auto paused = co_await parts_.wait_as(RunState::paused);
  co_await parts_.interrupts.resumed();
}

// Holds travel and continues recording until somebody resumes or stops the run.
Task<std::optional<InterruptRequest>> Run::stay_paused(StepProgress& progress) {
  progress.interrupt(setup_.clock.now());
  std::optional<ProgressKeeper::Shown> stopping(parts_.progress.show<RunState::stopping>());
  parts_.drive.expect_stop();
  std::optional<InterruptRequest> stop;
  for (bool resumed = false; !resumed && !stop;) {
    auto r = co_await either(wait_for_resume(), parts_.interrupts.wait());
    resumed = r.index() == 0;
    if (resumed) continue;
    InterruptRequest request = parts_.interrupts.take();
    if (request.kind == Interrupt::pause) continue;
    stop = co_await handle(std::move(request), progress);
  }
  if (stop) co_return stop;
  stopping.reset();
  parts_.log.event(EventKind::resume, "");
  auto held = co_await parts_.drive.restore_hold();
  if (!held) stop = request_for(held.error());
  co_return stop;
}

}  // namespace lcrig
