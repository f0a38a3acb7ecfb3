// SPDX-License-Identifier: Apache-2.0
// What each step of a protocol does.
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cmath>
#include <utility>
#include <variant>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;
using namespace std::chrono_literals;

bool is_load(TargetKind kind) {
  return kind == TargetKind::force || kind == TargetKind::pressure;
}

}  // namespace

Task<Result<>> Run::execute_step(const Step& step, StepProgress& progress) {
  auto task = std::visit([&](const auto& s) { return execute(s, progress); }, step.action);
  auto result = co_await std::move(task);
  co_return result;
}

Result<double> Run::travel_of(const Target& target) const {
  const double value = setup_.environment.get(target.value);
  if (target.kind == TargetKind::travel) return value;
  if (!contact_travel_m_) {
    return fail(Errc::invalid_request, "step {}: a gap exists only after find_contact", step_->id);
  }
  return *contact_travel_m_ - value;
}

double Run::force_of(const Target& target) const {
  const double value = setup_.environment.get(target.value);
  // The plan refused a pressure without a probe area.
  return target.kind == TargetKind::pressure ? value * setup_.probe_area_m2.value() : value;
}

void Run::aim_at(const std::optional<Target>& target) {
  target_force_N_.reset();
  target_pressure_Pa_.reset();
  if (!target || !is_load(target->kind)) return;
  target_force_N_ = force_of(*target);
  if (setup_.probe_area_m2) target_pressure_Pa_ = *target_force_N_ / *setup_.probe_area_m2;
}

void Run::zero_travel(double travel_m) {
  contact_travel_m_.reset();
  if (plausible_) plausible_->press().forget();
  travel_zero_m_ += travel_m;
  guard_.zero_travel(travel_m);
  if (pressing_) pressing_->zero_travel(travel_m);
  armed_.reset();
}

FrameCapabilities Run::frame_capabilities() const {
  return with_zero_at(setup_.frame.capabilities(), travel_zero_m_);
}

Task<Result<>> Run::execute(const ZeroStep& step, StepProgress& /*progress*/) {
  auto rest = co_await watch_rest(kRestTime);
  if (!rest) co_return fail(rest.error());
  if (step.max_offset && std::abs(rest->force_N()) > setup_.environment.get(*step.max_offset)) {
    co_return fail(Errc::limit_tripped,
                   "step {}: {:.4f} N at rest before zeroing, {:.4f} N allowed: the probe may "
                   "already touch; move it away or zero the cell at the machine",
                   step_->id, rest->force_N(), setup_.environment.get(*step.max_offset));
  }
  zeroing_ = true;  // the gateway may tell of it, too
  const auto over = [](bool* flag) { *flag = false; };
  const std::unique_ptr<bool, decltype(over)> zeroing(&zeroing_, over);
  if (plausible_ && step.travel) plausible_->look_away();
  auto zeroed = co_await setup_.frame.zero(step.force, step.travel);
  if (!zeroed) co_return zeroed;
  if (plausible_) plausible_->zero_force(setup_.clock.now());
  memory_.zeroed = true;
  if (step.travel) zero_travel(rest->travel_m().value_or(0));
  event(point());  // the origin is another one
  event(ZeroEvent{rest->force_N()});
  // Samples from before the zero are still on the way: at most one, or 100 ms of them.
  const Duration stale = std::max<Duration>(250ms, from_seconds(2 / setup_.frame_rate_Hz));
  co_await setup_.clock.wait_for(stale);
  if (plausible_ && step.travel) plausible_->stand(setup_.clock.now());
  auto after = co_await watch_rest(kRestTime);
  if (!after) co_return fail(after.error());
  learn_rest(*after);
  guard_.set_rest_force(after->force_N(), after->scatter_N());
  co_return Result<>();
}

Task<Result<>> Run::execute(const RampStep& step, StepProgress& progress) {
  const Environment& env = setup_.environment;
  aim_at(step.to);
  const double timeout_s = env.get(step.timeout);
  if (!is_load(step.to.kind)) {
    if (finishing_ && step.to.kind == TargetKind::gap && !contact_travel_m_) {
      auto away = co_await back_away(step.to, env.get(*step.speed), timeout_s, progress);
      co_return away;
    }
    auto travel = travel_of(step.to);
    if (!travel) co_return fail(travel.error());
    auto moved = co_await move_to_travel(*travel, env.get(*step.speed), timeout_s);
    co_return moved;
  }
  const double force_N = force_of(step.to);
  if (step.speed) {
    auto moved = co_await move_to_force(force_N, env.get(*step.speed), timeout_s);
    co_return moved;
  }
  auto ramped = co_await ramp_to_force(force_N, env.get(*step.force_rate), timeout_s);
  co_return ramped;
}

Task<Result<>> Run::execute(const MoveUntilStep& step, StepProgress& /*progress*/) {
  const Environment& env = setup_.environment;
  aim_at(step.until);
  const double timeout_s = env.get(step.timeout);
  if (!is_load(step.until.kind)) {
    auto travel = travel_of(step.until);
    if (!travel) co_return fail(travel.error());
    auto moved = co_await move_to_travel(*travel, env.get(step.speed), timeout_s);
    co_return moved;
  }
  const double force_N = force_of(step.until);
  double speed = env.get(step.speed);
  if (step.final_speed) {
    auto near = co_await move_to_force(force_N * env.get(*step.final_from), speed, timeout_s);
    if (!near) co_return near;
    speed = env.get(*step.final_speed);
  }
  auto moved = co_await move_to_force(force_N, speed, timeout_s);
  if (!moved || !step.overshoot) co_return moved;
  const auto now_N = present_force();
  if (!now_N) co_return fail(now_N.error());
  const double beyond = std::max(*now_N, done_force_N_.value_or(*now_N)) - force_N;
  if (beyond > env.get(*step.overshoot)) {
    co_return fail(Errc::limit_tripped, "step {}: overshoot of {:.4f} N, {:.4f} N allowed",
                   step_->id, beyond, env.get(*step.overshoot));
  }
  co_return Result<>();
}

Task<Result<>> Run::wait_out(double duration_s, StepProgress& progress) {
  progress.begin = setup_.clock.now();
  const Duration rest = from_seconds(duration_s) - progress.spent;
  if (rest > Duration::zero()) co_await setup_.clock.wait_for(rest);
  co_return Result<>();
}

Task<Result<>> Run::execute(const HoldStep& step, StepProgress& progress) {
  if (step.at) aim_at(step.at);
  const bool travel = step.mode == HoldMode::travel;
  // Who only watches holds nothing: it is a time to wait.
  if (!progress.moved && setup_.commands) {
    Result<> held;
    held_force_N_.reset();
    if (travel) {
      held = co_await setup_.frame.hold_travel();
      if (plausible_) plausible_->stand(setup_.clock.now());
    } else {
      auto force_N = present_force();
      if (step.at) force_N = force_of(*step.at);
      if (!force_N) co_return fail(force_N.error());
      const double most_N = force_N_.value_or(0) + 5 * (rest_ ? rest_->scatter_N() : 0);
      if (pressing_ && pressing_->broken() && *force_N > most_N) {
        co_return fail(Errc::limit_tripped, "step {}: {}", step_->id, *pressing_->broken());
      }
      if (plausible_) plausible_->begin(holding(), setup_.clock.now());
      held = may_move();
      if (held) held = co_await setup_.frame.hold_force(Force::from_si(*force_N));
      held_force_N_ = *force_N;
    }
    if (!held) co_return held;
    progress.moved = true;
  }
  auto done = co_await wait_out(setup_.environment.get(step.duration), progress);
  co_return done;
}

LoadLevel Run::next_level(std::int64_t count) {
  level_in_repeat_ = repeat_ == level_repeat_ ? level_in_repeat_ + 1 : 1;
  level_repeat_ = repeat_;
  LoadLevel level;
  level.level = ++levels_;
  level.step_id = step_->id;
  level.repeat = repeat_;
  level.index = level_in_repeat_;
  level.target_force_N = target_force_N_;
  level.target_pressure_Pa = target_pressure_Pa_;
  level.planned_readings = count;
  level.begin = setup_.clock.now();
  return level;
}

Task<Result<>> Run::execute(const MeasureStep& step, StepProgress& progress) {
  const auto count = static_cast<std::int64_t>(std::llround(setup_.environment.get(step.count)));
  if (!progress.level) {
    progress.level = next_level(count);
    setup_.sink.level(*progress.level);
  }
  Sampler::Plan plan;
  plan.level = *progress.level;
  plan.within = from_seconds(setup_.environment.get(step.within));
  auto taken = co_await sampler_.take(plan, progress.readings);
  co_return taken;
}

double Run::aim_at_mass(const PlaceWeightStep& step) {
  aim_at(step.load);
  if (step.load.kind != TargetKind::mass) return *target_force_N_ / setup_.gravity_m_s2;
  const double mass_kg = setup_.environment.get(step.load.value);
  target_force_N_ = mass_kg * setup_.gravity_m_s2;
  if (setup_.probe_area_m2) target_pressure_Pa_ = *target_force_N_ / *setup_.probe_area_m2;
  return mass_kg;
}

Task<Result<>> Run::execute(const PlaceWeightStep& step, StepProgress& /*progress*/) {
  const double mass_kg = aim_at_mass(step);
  progress_.state = finishing_ ? RunState::finishing : RunState::waiting_for_operator;
  auto placed = co_await setup_.frame.place_mass(Mass::from_si(mass_kg));
  if (!finishing_) progress_.state = RunState::running;
  if (!placed) co_return fail(placed.error());
  event(ended_event<EventKind::confirm>(*placed));
  co_return Result<>();
}

Task<Result<>> Run::execute(const RecordStep& step, StepProgress& progress) {
  const Environment& env = setup_.environment;
  if (!step.until_confirmed) {
    auto done = co_await wait_out(env.get(*step.duration), progress);
    co_return done;
  }
  const MonoTime deadline = setup_.clock.now() + from_seconds(env.get(step.timeout));
  const std::string prompt = "Recording. Confirm to end the recording.";
  auto r = co_await (setup_.person->confirm(prompt) || setup_.clock.wait_until(deadline));
  if (r.index() == 0) co_return std::get<0>(r);
  event(EventKind::late, "nobody confirmed the end of the recording; it ended by its time-out");
  co_return Result<>();
}

void Run::apply_settings(const SetLcrStep& step, const Environment& env, LcrSettings& s) {
  if (step.frequency) s.frequency = Frequency::from_si(env.get(*step.frequency));
  if (step.level) s.level = Voltage::from_si(env.get(*step.level));
  if (step.average) s.average = static_cast<int>(std::lround(env.get(*step.average)));
  if (step.bias) s.bias = Voltage::from_si(env.get(*step.bias));
  if (step.bias_off) s.bias.reset();
  if (step.aperture) s.aperture = *step.aperture;
  if (step.function) s.function = *step.function;
  if (step.trigger) s.trigger = *step.trigger;
}

Task<Result<>> Run::execute(const SetLcrStep& step, StepProgress& /*progress*/) {
  LcrSettings s = sampler_.settings();
  apply_settings(step, setup_.environment, s);
  auto set = co_await sampler_.configure(std::move(s));
  if (!set) co_return set;
  const Duration conversion = setup_.lcr.capabilities().conversion_time(sampler_.settings());
  event(settings_event(sampler_.settings(), conversion));
  co_return Result<>();
}

// Known from here on by a person's word, not by a search.
Task<Result<>> Run::execute(const SetGapStep& step, StepProgress& /*progress*/) {
  if (!memory_.travel_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", step_->id);
  }
  const double contact_m = *memory_.travel_m + setup_.environment.get(step.gap);
  place_contact(contact_m, 0);
  event(GapStatedEvent{contact_m});
  co_return Result<>();
}

Task<Result<>> Run::execute(const MarkStep& step, StepProgress& /*progress*/) {
  event(EventKind::mark, step.text);
  co_return Result<>();
}

// RepeatStep and SweepStep never reach a run: StepCursor yields leaves.
Task<Result<>> Run::execute(const RepeatStep& /*step*/, StepProgress& /*progress*/) {
  co_return fail(Errc::bug, "a loop reached the run");
}
Task<Result<>> Run::execute(const SweepStep& /*step*/, StepProgress& /*progress*/) {
  co_return fail(Errc::bug, "a loop reached the run");
}

}  // namespace lcrig
