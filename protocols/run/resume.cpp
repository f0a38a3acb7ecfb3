// SPDX-License-Identifier: Apache-2.0
// A run that was interrupted goes on in this one, at the step where it stopped.
#include <fmt/format.h>

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cmath>
#include <utility>
#include <variant>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace asio::experimental::awaitable_operators;

// Of the motion that step number `n` (from 0) begins with, m/s; 0: it does not move, or along a
// force.
double begun_speed(const Protocol& protocol, Environment env, std::int64_t n) {
  StepCursor ahead(protocol.steps, env);
  const Step* step = ahead.next();
  for (; step != nullptr && n > 0; --n) step = ahead.next();
  if (step == nullptr) return 0;
  if (const auto* contact = std::get_if<FindContactStep>(&step->action)) {
    return env.get(contact->speed);
  }
  if (const auto* move = std::get_if<MoveUntilStep>(&step->action)) return env.get(move->speed);
  const auto* ramp = std::get_if<RampStep>(&step->action);
  return ramp != nullptr && ramp->speed ? env.get(*ramp->speed) : 0;
}

}  // namespace

RunPoint Run::point() const {
  RunPoint p;
  p.steps_done = steps_done_;
  p.levels = levels_;
  p.level_in_repeat = level_in_repeat_;
  p.level_repeat = level_repeat_;
  p.contact_travel_m = contact_travel_m_;
  p.travel_m = memory_.travel_m;
  p.zeroed = memory_.zeroed;
  p.origin = setup_.frame.origin();
  return p;
}

// Nobody knows what happened to the specimen meanwhile: a person looks.
Task<std::optional<InterruptRequest>> Run::confirm_specimen() {
  const Continuation& from = *setup_.continues;
  std::optional<InterruptRequest> stop;
  if (!from.confirmed) {
    unconfirmed_ = true;
    progress_.state = RunState::waiting_for_operator;
    const std::string prompt = fmt::format(
        "Run {} stopped in step {}. Look at the rig: if specimen {} was not touched since, confirm "
        "to go on.",
        from.run, from.step_id, setup_.specimen);
    event(EventKind::prompt, prompt);
    auto r = co_await (setup_.person->confirm(prompt) || interrupted());
    if (r.index() == 1) {
      stop = take_interrupt();
    } else if (const auto& said = std::get<0>(r); !said) {
      stop = InterruptRequest(Interrupt::abort, said.error());
    }
    if (stop && (stop->kind == Interrupt::loss || stop->kind == Interrupt::pause)) {
      stop->kind = Interrupt::fault;
    }
    unconfirmed_ = stop.has_value();
    progress_.state = RunState::running;
  }
  if (!stop)
    event(EventKind::confirm, fmt::format("the specimen of run {} was not touched", from.run));
  co_return stop;
}

// Walks past the steps that were done, so that targets, settings and control modes are as they
// were.
Task<Result<>> Run::take_over(StepCursor& cursor) {
  const Continuation& from = *setup_.continues;
  event(ContinuesEvent{from.run, from.step_id, from.point.steps_done});
  auto heard = co_await await_samples();
  if (!heard) co_return heard;
  const std::int64_t first =
      first_step_of(setup_.protocol, setup_.environment, from.point.steps_done);
  FrameMemory before = from.frame;
  before.zeroed = from.point.zeroed;
  before.origin = from.point.origin;
  before.begun_m_s = begun_speed(setup_.protocol, setup_.environment, first);
  auto same = compare_origin(before);
  if (same) same = compare_with(before);
  if (!same) {
    lose_origin(same.error().what);
    co_return same;
  }
  memory_.zeroed = from.point.zeroed;
  first_start_travel_m_ = from.point.travel_m;
  contact_travel_m_ = from.point.contact_travel_m;
  levels_ = from.point.levels;
  level_in_repeat_ = from.point.level_in_repeat;
  level_repeat_ = from.point.level_repeat;
  LcrSettings settings = sampler_.settings();
  for (; steps_done_ < first; ++steps_done_) {
    const Step* step = cursor.next();
    if (step == nullptr) {
      co_return fail(Errc::invalid_request, "run {}: has no step {}", from.run, first);
    }
    pass_over(*step, settings);
  }
  if (!(settings == sampler_.settings())) {
    auto set = co_await sampler_.configure(std::move(settings));
    if (!set) co_return set;
  }
  auto held = co_await restore_hold();
  co_return held;
}

void Run::pass_over(const Step& step, LcrSettings& settings) {
  if (const auto* place = std::get_if<PlaceWeightStep>(&step.action)) {
    aim_at_mass(*place);
  } else if (const auto* set = std::get_if<SetLcrStep>(&step.action)) {
    apply_settings(*set, setup_.environment, settings);
  } else if (const auto* hold = std::get_if<HoldStep>(&step.action)) {
    if (hold->at) aim_at(hold->at);
    held_force_N_.reset();
    if (hold->mode == HoldMode::force) {
      held_force_N_ = force_N_;
      if (hold->at) held_force_N_ = force_of(*hold->at);
    }
  } else if (const auto* ramp = std::get_if<RampStep>(&step.action)) {
    aim_at(ramp->to);
    held_force_N_.reset();
    if (!ramp->speed) held_force_N_ = force_of(ramp->to);
  } else if (const auto* move = std::get_if<MoveUntilStep>(&step.action)) {
    aim_at(move->until);
    held_force_N_.reset();
  } else if (std::holds_alternative<FindContactStep>(step.action)) {
    aim_at(std::nullopt);
    held_force_N_.reset();
  }
}

}  // namespace lcrig
