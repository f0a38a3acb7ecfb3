// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/step.hpp"

namespace lcrig {

std::string_view kind_of(const Step& step) {
  return std::visit([](const auto& s) { return s.kWord; }, step.action);
}

StepFacts facts_of(const Step& step) {
  return std::visit([](const auto& s) { return s.facts(); }, step.action);
}

std::unique_ptr<StepProgress> new_progress(const Step& step) {
  const auto begun = []<class S>(const S& /*step*/) -> std::unique_ptr<StepProgress> {
    return std::make_unique<typename S::Progress>();
  };
  return std::visit(begun, step.action);
}

const Steps& Loop::steps() const {
  return std::visit([](const auto* s) -> const Steps& { return s->steps; }, step_);
}

std::int64_t Loop::passes(const Environment& environment) const {
  return std::visit([&](const auto* s) { return s->passes(environment); }, step_);
}

const Number* Loop::repeats() const {
  return std::visit([](const auto* s) { return s->repeats(); }, step_);
}

const std::string* Loop::variable() const {
  return std::visit([](const auto* s) { return s->variable(); }, step_);
}

std::vector<const Number*> Loop::ends() const {
  return std::visit([](const auto* s) { return s->ends(); }, step_);
}

void Loop::set_variable(std::int64_t pass, Environment& environment) const {
  std::visit([&](const auto* s) { s->set_variable(pass, environment); }, step_);
}

}  // namespace lcrig
