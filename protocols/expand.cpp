// SPDX-License-Identifier: Apache-2.0
#include "protocols/expand.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace lcrig {

const Steps* steps_inside(const Step& step) {
  if (const auto* repeat = std::get_if<RepeatStep>(&step.action)) return &repeat->steps;
  if (const auto* sweep = std::get_if<SweepStep>(&step.action)) return &sweep->steps;
  return nullptr;
}

std::int64_t passes(const Step& step, const Environment& environment) {
  if (const auto* repeat = std::get_if<RepeatStep>(&step.action)) {
    return std::llround(environment.get(repeat->count));
  }
  const auto& sweep = std::get<SweepStep>(step.action);
  if (sweep.count) return std::llround(environment.get(*sweep.count));
  return static_cast<std::int64_t>(sweep.values.size());
}

double sweep_value(const SweepStep& sweep, std::int64_t index, const Environment& environment) {
  if (!sweep.count) {
    return environment.get(sweep.values.at(static_cast<std::size_t>(index - 1)));
  }
  const double from = environment.get(*sweep.from), to = environment.get(*sweep.to);
  const double last = environment.get(*sweep.count) - 1;
  const auto i = static_cast<double>(index - 1);
  return i >= last ? to : from + (to - from) * (i / last);  // the end exactly
}

StepCursor::StepCursor(const Steps& steps, Environment& environment)
    : steps_(steps), environment_(environment) {}

const Steps& StepCursor::inner() const {
  return *steps_inside(*loops_.back().step);
}

void StepCursor::set_variable(const Loop& loop) {
  const auto* sweep = std::get_if<SweepStep>(&loop.step->action);
  if (sweep) environment_.set(sweep->name, sweep_value(*sweep, loop.index, environment_));
}

void StepCursor::enter(const Step& step) {
  Loop loop;
  loop.step = &step;
  loop.count = passes(step, environment_);
  set_variable(loop);
  loops_.push_back(loop);
}

// The end of a pass: starts the next one, or leaves the loop (false).
bool StepCursor::again() {
  Loop& loop = loops_.back();
  if (loop.index < loop.count) {
    ++loop.index;
    loop.at = 0;
    set_variable(loop);
    return true;
  }
  if (const auto* sweep = std::get_if<SweepStep>(&loop.step->action)) {
    environment_.unset(sweep->name);
  }
  loops_.pop_back();
  return false;
}

const Step* StepCursor::next() {
  while (true) {
    const Steps& list = loops_.empty() ? steps_ : inner();
    std::size_t& at = loops_.empty() ? at_ : loops_.back().at;
    if (at == list.size()) {
      if (loops_.empty()) return nullptr;
      again();
      continue;
    }
    const Step& step = list[at++];
    if (!steps_inside(step)) return &step;
    enter(step);
  }
}

namespace {
const StepCursor::Loop* outermost_repeat(const std::vector<StepCursor::Loop>& loops) {
  const auto it = std::ranges::find_if(loops, [](const StepCursor::Loop& loop) {
    return std::holds_alternative<RepeatStep>(loop.step->action);
  });
  return it == loops.end() ? nullptr : &*it;
}
}  // namespace

std::int64_t StepCursor::repeat() const {
  const Loop* loop = outermost_repeat(loops_);
  return loop ? loop->index : 0;
}

std::int64_t StepCursor::repeats() const {
  const Loop* loop = outermost_repeat(loops_);
  return loop ? loop->count : 0;
}

namespace {

bool any_step(const Steps& steps, const std::function<bool(const Step&)>& holds) {
  return std::ranges::any_of(steps, [&](const Step& step) {
    const Steps* inner = steps_inside(step);
    return inner != nullptr ? any_step(*inner, holds) : holds(step);
  });
}

bool is_pressure(const std::optional<Target>& target) {
  return target && target->kind == TargetKind::pressure;
}

}  // namespace

bool places_weights(const Steps& steps) {
  return any_step(
      steps, [](const Step& step) { return std::holds_alternative<PlaceWeightStep>(step.action); });
}

bool commands_frame(const Protocol& protocol) {
  const auto commands = [](const Step& step) {
    const auto* hold = std::get_if<HoldStep>(&step.action);
    return std::holds_alternative<ZeroStep>(step.action) ||
           std::holds_alternative<FindContactStep>(step.action) ||
           std::holds_alternative<RampStep>(step.action) ||
           std::holds_alternative<MoveUntilStep>(step.action) ||
           (hold != nullptr && hold->mode == HoldMode::force);
  };
  return any_step(protocol.steps, commands) || any_step(protocol.finally_steps, commands);
}

bool aims_at_pressure(const Steps& steps) {
  return any_step(steps, [](const Step& step) {
    if (const auto* s = std::get_if<RampStep>(&step.action)) return is_pressure(s->to);
    if (const auto* s = std::get_if<MoveUntilStep>(&step.action)) return is_pressure(s->until);
    if (const auto* s = std::get_if<HoldStep>(&step.action)) return is_pressure(s->at);
    const auto* s = std::get_if<PlaceWeightStep>(&step.action);
    return s != nullptr && is_pressure(s->load);
  });
}

}  // namespace lcrig
