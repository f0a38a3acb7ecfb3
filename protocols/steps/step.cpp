// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/step.hpp"

#include <cmath>

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

std::int64_t Loop::passes(const Environment& environment) const {
  if (sweep_ != nullptr) return sweep_->passes(environment);
  return std::llround(environment.get(*count_));
}

}  // namespace lcrig
