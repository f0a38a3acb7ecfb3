// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/step.hpp"

namespace lcrig {

std::string_view kind_of(const Step& step) {
  return std::visit([](const auto& s) { return s.kWord; }, step.action);
}

StepFacts facts_of(const Step& step) {
  return std::visit([](const auto& s) { return s.facts(); }, step.action);
}

}  // namespace lcrig
