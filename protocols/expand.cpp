// SPDX-License-Identifier: Apache-2.0
#include "protocols/expand.hpp"

#include <algorithm>

namespace lcrig {

StepCursor::StepCursor(const Steps& steps, Environment& environment)
    : steps_(steps), environment_(environment) {}

StepCursor::StepCursor(const StepCursor& at, Environment& environment)
    : steps_(at.steps_), environment_(environment), at_(at.at_), loops_(at.loops_) {}

void StepCursor::enter(const Step& step, const Loop& loop) {
  loops_.emplace_back(step, loop, loop.passes(environment_));
  loop.set_variable(1, environment_);
}

// At the end of a pass: starts the next one, or leaves the loop and returns false.
bool StepCursor::again() {
  Pass& pass = loops_.back();
  if (pass.index < pass.count) {
    ++pass.index;
    pass.at = 0;
    pass.loop->set_variable(pass.index, environment_);
    return true;
  }
  if (const std::string* name = pass.loop->variable()) environment_.unset(*name);
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
    const StepFacts facts = facts_of(step);
    if (!facts.loop) return &step;
    enter(step, *facts.loop);
  }
}

namespace {

const StepCursor::Pass* outermost_repeat(const std::vector<StepCursor::Pass>& loops) {
  const auto it = std::ranges::find_if(
      loops, [](const StepCursor::Pass& pass) { return pass.loop->repeats() != nullptr; });
  return it == loops.end() ? nullptr : &*it;
}

bool any_step(const Steps& steps, bool (*holds)(const StepFacts&)) {
  return std::ranges::any_of(steps, [&](const Step& step) {
    const StepFacts facts = facts_of(step);
    return facts.loop ? any_step(facts.loop->steps, holds) : holds(facts);
  });
}

bool any_step(const Protocol& protocol, bool (*holds)(const StepFacts&)) {
  return any_step(protocol.steps, holds) || any_step(protocol.finally_steps, holds);
}

}  // namespace

std::int64_t StepCursor::repeat() const {
  const Pass* pass = outermost_repeat(loops_);
  return pass ? pass->index : 0;
}

std::int64_t StepCursor::repeats() const {
  const Pass* pass = outermost_repeat(loops_);
  return pass ? pass->count : 0;
}

bool places_weights(const Steps& steps) {
  return any_step(steps, [](const StepFacts& facts) { return facts.places_weight; });
}

bool has_safe_point(const Steps& steps) {
  return std::ranges::any_of(steps, [](const Step& step) {
    const StepFacts facts = facts_of(step);
    return step.safe_point || (facts.loop && has_safe_point(facts.loop->steps));
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
