// SPDX-License-Identifier: Apache-2.0
#include "protocols/expand.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

std::int64_t passes(const Step& step, const Environment& environment) {
  const StepFacts facts = facts_of(step);
  if (facts.passes != nullptr) return std::llround(environment.get(*facts.passes));
  return static_cast<std::int64_t>(facts.sweep->values.size());
}

StepCursor::StepCursor(const Steps& steps, Environment& environment)
    : steps_(steps), environment_(environment) {}

StepCursor::StepCursor(const StepCursor& at, Environment& environment)
    : steps_(at.steps_), environment_(environment), at_(at.at_), loops_(at.loops_) {}

void StepCursor::set_variable(const Loop& loop) {
  const SweepStep* sweep = facts_of(*loop.step).sweep;
  if (sweep != nullptr) environment_.set(sweep->name, sweep->value(loop.index, environment_));
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
  const SweepStep* sweep = facts_of(*loop.step).sweep;
  if (sweep != nullptr) environment_.unset(sweep->name);
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
    if (facts_of(step).inside == nullptr) return &step;
    enter(step);
  }
}

namespace {

const StepCursor::Loop* outermost_repeat(const std::vector<StepCursor::Loop>& loops) {
  const auto it = std::ranges::find_if(
      loops, [](const StepCursor::Loop& loop) { return facts_of(*loop.step).sweep == nullptr; });
  return it == loops.end() ? nullptr : &*it;
}

bool any_step(const Steps& steps, bool (*holds)(const StepFacts&)) {
  return std::ranges::any_of(steps, [&](const Step& step) {
    const StepFacts facts = facts_of(step);
    return facts.inside != nullptr ? any_step(*facts.inside, holds) : holds(facts);
  });
}

bool any_step(const Protocol& protocol, bool (*holds)(const StepFacts&)) {
  return any_step(protocol.steps, holds) || any_step(protocol.finally_steps, holds);
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

bool places_weights(const Steps& steps) {
  return any_step(steps, [](const StepFacts& facts) { return facts.places_weight; });
}

bool has_safe_point(const Steps& steps) {
  return std::ranges::any_of(steps, [](const Step& step) {
    const StepFacts facts = facts_of(step);
    return step.safe_point || (facts.inside != nullptr && has_safe_point(*facts.inside));
  });
}

bool asks_person(const Steps& steps) {
  return any_step(steps, [](const StepFacts& facts) { return facts.asks != nullptr; });
}

bool moves_frame(const Protocol& protocol) {
  return any_step(protocol, [](const StepFacts& facts) { return facts.moves; });
}

bool commands_frame(const Protocol& protocol) {
  return any_step(protocol, [](const StepFacts& facts) { return facts.commands_frame(); });
}

bool aims_at_pressure(const Steps& steps) {
  return any_step(steps, [](const StepFacts& facts) {
    return facts.aim != nullptr && facts.aim->kind == TargetKind::pressure;
  });
}

}  // namespace lcrig
