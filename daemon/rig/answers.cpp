// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/answers.hpp"

#include <fmt/ranges.h>

#include <vector>

#include "base/near_word.hpp"
#include "base/strict_json.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

void find_questions(const Steps& steps, std::map<std::string, const StepQuestion*>& out) {
  for (const Step& step : steps) {
    const StepFacts facts = facts_of(step);
    if (facts.asks != nullptr) out[step.id] = facts.asks;
    if (facts.loop) find_questions(facts.loop->steps, out);
  }
}

std::optional<AnswerValue> read_value(const JsonReader& r) {
  if (r.is_string()) return AnswerValue(r.string());
  if (r.is_number()) return AnswerValue(r.number());
  if (r.is_boolean()) return AnswerValue(r.boolean());
  r.refuse("no answer, expected a text, a number or true");
  return std::nullopt;
}

}  // namespace

Result<Answers> parse_answers(std::string_view text, const std::string& name,
                              const Protocol& protocol, const Environment& environment) {
  const auto document = JsonDocument::parse(text, name);
  if (!document) return fail(document.error());
  const JsonReader top(*document);
  top.expect_format("answers/1");
  std::map<std::string, const StepQuestion*> questions;
  find_questions(protocol.steps, questions);
  std::vector<std::string> ids;
  for (const auto& [id, ask] : questions) ids.push_back(id);
  Answers out;
  for (const JsonReader& r : top.object("answers").members()) {
    const std::string id = r.last_key();
    const auto value = read_value(r);
    const auto asks = questions.find(id);
    if (asks == questions.end()) {
      r.refuse_key(fmt::format("protocol {} has no step `{}` that asks{} it has: {}", protocol.name,
                               printable(id, 60), or_comma(guess_words(nearest_word(id, ids))),
                               ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "))));
      continue;
    }
    if (!value) continue;
    // Inside a sweep the range of a question may depend on its variable. Then only the run can
    // check.
    if (asks->second->is_known(environment)) {
      const auto read = read_answer(asks->second->question(id, environment), *value);
      if (!read) r.refuse(read.error().what);
    }
    out[id] = *value;
  }
  top.no_other_keys();
  if (auto ok = top.result(); !ok) return fail(ok.error());
  return out;
}

}  // namespace lcrig
