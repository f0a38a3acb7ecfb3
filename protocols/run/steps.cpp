// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>
#include <utility>
#include <variant>

#include "protocols/run/contact_search.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

constexpr double kLongWay = 1.2, kLongWayMore_s = 5;  // back from where a search ended

bool is_load(TargetKind kind) {
  return kind == TargetKind::force || kind == TargetKind::pressure;
}

// `finally` asks for a gap, and contact was never found. What presses all the same is left by the
// same way, from here; a force that nobody knows counts as one that presses.
// A search that found nothing may have pressed with a cell that did not show it: it goes back to
// where it began. The place is chosen once, however often the frame is lost on the way.
Task<Result<>> back_away(const RampStep& step, RunParts& run, StepProgress& progress) {
  const auto force_N = run.view.present_force_N();
  const bool presses = !force_N || run.guard.is_distrusted() || run.truth.is_loaded(*force_N);
  const auto from_m = run.contact.searched_from_m(), here_m = run.view.travel_m();
  if (!progress.away_m && !presses && !from_m) {
    run.event(EventKind::skipped,
              "no contact was found, and nothing presses: there is nothing to move away from");
    co_return Result<>();
  }
  if (!here_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", run.log.step_id());
  }
  if (!progress.away_m) {
    const FrameCapabilities caps = run.contact.frame_capabilities();
    const double least_m = device_limits(run.guard.limits(), caps).travel_min.si();
    double target_m = presses ? *here_m - run.get(step.to.value) : *here_m;
    if (from_m) target_m = std::min(target_m, *from_m);
    progress.away_m = std::max(least_m, target_m);
  }
  if (*progress.away_m >= *here_m) co_return Result<>();
  const double speed_m_s = run.get(*step.speed);
  const double way_s = (*here_m - *progress.away_m) / speed_m_s;
  const double timeout_s = std::max(run.get(step.timeout), kLongWay * way_s + kLongWayMore_s);
  auto moved = co_await run.motions.to_travel(*progress.away_m, speed_m_s, timeout_s);
  co_return moved;
}

Task<Result<>> move_to_place(const Target& to, const Number& speed, const Number& timeout,
                             RunParts& run) {
  auto travel_m = run.contact.travel_of(to, run.log.step_id());
  if (!travel_m) co_return fail(travel_m.error());
  auto moved = co_await run.motions.to_travel(*travel_m, run.get(speed), run.get(timeout));
  co_return moved;
}

Task<Result<>> wait_out(double duration_s, RunParts& run, StepProgress& progress) {
  progress.begin = run.setup.clock.now();
  const Duration rest = from_seconds(duration_s) - progress.spent;
  if (rest > Duration::zero()) co_await run.setup.clock.wait_for(rest);
  co_return Result<>();
}

}  // namespace

Task<Result<>> run_step_action(const Step& step, RunParts& run, StepProgress& progress) {
  auto task = std::visit([&](const auto& s) { return execute(s, run, progress); }, step.action);
  auto result = co_await std::move(task);
  co_return result;
}

Task<Result<>> execute(const ZeroStep& step, RunParts& run, StepProgress& /*progress*/) {
  auto rest = co_await run.view.watch_rest(FrameView::kRestTime);
  if (!rest) co_return fail(rest.error());
  if (step.max_offset && std::abs(rest->force_N()) > run.get(*step.max_offset)) {
    co_return fail(Errc::limit_tripped,
                   "step {}: {:.4f} N at rest before zeroing, {:.4f} N allowed: the probe may "
                   "already touch; move it away or zero the cell at the machine",
                   run.log.step_id(), rest->force_N(), run.get(*step.max_offset));
  }
  const ScopedFlag zeroing = run.distrust.expect_zero();  // the gateway may tell of it, too
  if (step.travel) run.truth.look_away();
  auto zeroed = co_await run.setup.frame.zero(step.force, step.travel);
  if (!zeroed) co_return zeroed;
  run.truth.zero_force();
  run.view.zeroed(true);
  if (step.travel) {
    run.contact.zero_travel(rest->travel_m().value_or(0));
    run.drive.forget_limits();
  }
  run.event(run.point());  // the origin is another one
  run.event(ZeroEvent{rest->force_N()});
  // Samples from before the zero are still on the way: at most one, or 100 ms of them.
  const Duration stale = std::max<Duration>(250ms, from_seconds(2 / run.setup.frame_rate_Hz));
  co_await run.setup.clock.wait_for(stale);
  if (step.travel) run.truth.stand();
  auto after = co_await run.view.watch_rest(FrameView::kRestTime);
  if (!after) co_return fail(after.error());
  run.truth.learn_rest(*after);
  run.guard.set_rest_force(after->force_N(), after->scatter_N());
  co_return Result<>();
}

Task<Result<>> execute(const FindContactStep& step, RunParts& run, StepProgress& progress) {
  run.labels.aim_at(std::nullopt);
  ContactSearch search(run, step);
  auto found = co_await search.find(progress);
  co_return found;
}

Task<Result<>> execute(const RampStep& step, RunParts& run, StepProgress& progress) {
  run.labels.aim_at(step.to);
  if (!is_load(step.to.kind)) {
    const bool clears = run.interrupts.finishing() && step.to.kind == TargetKind::gap;
    if (clears && !run.contact.travel_m()) {
      auto away = co_await back_away(step, run, progress);
      co_return away;
    }
    auto moved = co_await move_to_place(step.to, *step.speed, step.timeout, run);
    co_return moved;
  }
  const double force_N = run.labels.force_of(step.to), timeout_s = run.get(step.timeout);
  if (step.speed) {
    auto moved = co_await run.motions.to_force(force_N, run.get(*step.speed), timeout_s);
    co_return moved;
  }
  auto ramped = co_await run.motions.ramp_to_force(force_N, run.get(*step.force_rate), timeout_s);
  co_return ramped;
}

Task<Result<>> execute(const MoveUntilStep& step, RunParts& run, StepProgress& /*progress*/) {
  run.labels.aim_at(step.until);
  if (!is_load(step.until.kind)) {
    auto moved = co_await move_to_place(step.until, step.speed, step.timeout, run);
    co_return moved;
  }
  const double force_N = run.labels.force_of(step.until), timeout_s = run.get(step.timeout);
  double speed = run.get(step.speed);
  if (step.final_speed) {
    const double near_N = force_N * run.get(*step.final_from);
    auto near = co_await run.motions.to_force(near_N, speed, timeout_s);
    if (!near) co_return near;
    speed = run.get(*step.final_speed);
  }
  auto moved = co_await run.motions.to_force(force_N, speed, timeout_s);
  if (!moved || !step.overshoot) co_return moved;
  const auto now_N = run.view.present_force_N();
  if (!now_N) co_return fail(now_N.error());
  const double beyond = std::max(*now_N, run.view.done_force_N().value_or(*now_N)) - force_N;
  if (beyond > run.get(*step.overshoot)) {
    co_return fail(Errc::limit_tripped, "step {}: overshoot of {:.4f} N, {:.4f} N allowed",
                   run.log.step_id(), beyond, run.get(*step.overshoot));
  }
  co_return Result<>();
}

namespace {

// A specimen that was run into is not held at a force above the one that it shows now.
Task<Result<>> hold_at_force(const HoldStep& step, RunParts& run) {
  auto force_N = run.view.present_force_N();
  if (step.at) force_N = run.labels.force_of(*step.at);
  if (!force_N) co_return fail(force_N.error());
  const double most_N = run.view.force_N().value_or(0) + 5 * run.truth.noise_N();
  const bool broken = run.pressing != nullptr && run.pressing->broken();
  if (broken && *force_N > most_N) {
    co_return fail(Errc::limit_tripped, "step {}: {}", run.log.step_id(), *run.pressing->broken());
  }
  auto held = co_await run.drive.hold_force(*force_N);
  run.drive.will_hold(*force_N);
  co_return held;
}

}  // namespace

Task<Result<>> execute(const HoldStep& step, RunParts& run, StepProgress& progress) {
  if (step.at) run.labels.aim_at(step.at);
  // Who only watches holds nothing: it is a time to wait.
  if (!progress.moved && run.setup.commands) {
    Result<> held;
    run.drive.will_hold(std::nullopt);
    if (step.mode == HoldMode::travel) {
      held = co_await run.drive.hold_travel();
    } else {
      held = co_await hold_at_force(step, run);
    }
    if (!held) co_return held;
    progress.moved = true;
  }
  auto done = co_await wait_out(run.get(step.duration), run, progress);
  co_return done;
}

Task<Result<>> execute(const MeasureStep& step, RunParts& run, StepProgress& progress) {
  const auto count = static_cast<std::int64_t>(std::llround(run.get(step.count)));
  if (!progress.level) {
    progress.level = run.labels.next(run.log.step_id(), count, run.setup.clock.now());
    run.setup.sink.level(*progress.level);
  }
  Sampler::Plan plan;
  plan.level = *progress.level;
  plan.within = from_seconds(run.get(step.within));
  auto taken = co_await run.sampler.take(plan, progress.readings);
  co_return taken;
}

Task<Result<>> execute(const PlaceWeightStep& step, RunParts& run, StepProgress& /*progress*/) {
  const double mass_kg = run.labels.aim_at_mass(step);
  const bool finishing = run.interrupts.finishing();
  run.progress.state = finishing ? RunState::finishing : RunState::waiting_for_operator;
  auto placed = co_await run.setup.frame.place_mass(Mass::from_si(mass_kg));
  if (!finishing) run.progress.state = RunState::running;
  if (!placed) co_return fail(placed.error());
  run.event(ended_event<EventKind::confirm>(*placed));
  co_return Result<>();
}

Task<Result<>> execute(const RecordStep& step, RunParts& run, StepProgress& progress) {
  if (!step.until_confirmed) {
    auto done = co_await wait_out(run.get(*step.duration), run, progress);
    co_return done;
  }
  const MonoTime deadline = run.setup.clock.now() + from_seconds(run.get(step.timeout));
  const std::string prompt = "Recording. Confirm to end the recording.";
  auto r = co_await (run.setup.person->confirm(prompt) || run.setup.clock.wait_until(deadline));
  if (r.index() == 0) co_return std::get<0>(r);
  run.event(EventKind::late, "nobody confirmed the end of the recording; it ended by its time-out");
  co_return Result<>();
}

void apply_settings(const SetLcrStep& step, const Environment& env, LcrSettings& s) {
  if (step.frequency) s.frequency = Frequency::from_si(env.get(*step.frequency));
  if (step.level) s.level = Voltage::from_si(env.get(*step.level));
  if (step.average) s.average = static_cast<int>(std::lround(env.get(*step.average)));
  if (step.bias) s.bias = Voltage::from_si(env.get(*step.bias));
  if (step.bias_off) s.bias.reset();
  if (step.aperture) s.aperture = *step.aperture;
  if (step.function) s.function = *step.function;
  if (step.trigger) s.trigger = *step.trigger;
}

Task<Result<>> execute(const SetLcrStep& step, RunParts& run, StepProgress& /*progress*/) {
  LcrSettings s = run.sampler.settings();
  apply_settings(step, run.setup.environment, s);
  auto set = co_await run.sampler.configure(std::move(s));
  if (!set) co_return set;
  const Duration conversion = run.setup.lcr.capabilities().conversion_time(run.sampler.settings());
  run.event(settings_event(run.sampler.settings(), conversion));
  co_return Result<>();
}

// Known from here on by a person's word, not by a search.
Task<Result<>> execute(const SetGapStep& step, RunParts& run, StepProgress& /*progress*/) {
  if (!run.view.travel_m()) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", run.log.step_id());
  }
  const double contact_m = *run.view.travel_m() + run.get(step.gap);
  run.contact.place(contact_m, 0);
  run.event(GapStatedEvent{contact_m});
  co_return Result<>();
}

Task<Result<>> execute(const MarkStep& step, RunParts& run, StepProgress& /*progress*/) {
  run.event(EventKind::mark, step.text);
  co_return Result<>();
}

// RepeatStep and SweepStep never reach a run: StepCursor yields leaves.
Task<Result<>> execute(const RepeatStep& /*step*/, RunParts& /*run*/, StepProgress& /*progress*/) {
  co_return fail(Errc::bug, "a loop reached the run");
}
Task<Result<>> execute(const SweepStep& /*step*/, RunParts& /*run*/, StepProgress& /*progress*/) {
  co_return fail(Errc::bug, "a loop reached the run");
}

}  // namespace lcrig
