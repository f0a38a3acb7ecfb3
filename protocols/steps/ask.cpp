// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/ask.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/decimal.hpp"
#include "base/either.hpp"
#include "base/text.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kTextMax = 1'000, kChoiceMax = 200;  // bytes
constexpr std::size_t kChoicesMax = 20;

// A number in the unit of the question, rounded to twelve digits to remove the error of the factor.
double in_unit(double si, double to_si) {
  return round_to_digits(si / to_si, 12);
}

std::string one_line(const JsonReader& r, std::size_t most) {
  std::string out = r.nonempty_string(most);
  if (trimmed(out) != out || printable(out) != out) {
    r.refuse("blanks at its ends, or a line end, expected one line");
  }
  return out;
}

void read_choices(const StepReader& r, AskStep& out) {
  const JsonReader list = r.json.at("choices");
  for (const JsonReader& item : list.items(2, kChoicesMax)) {
    std::string choice = one_line(item, kChoiceMax);
    if (std::ranges::find(out.choices, choice) != out.choices.end()) {
      item.refuse(fmt::format("\"{}\" for the second time, expected another choice", choice));
    }
    out.choices.push_back(std::move(choice));
  }
}

// Finds the range, such as "range_um": [20, 400]. Its suffix is the unit of the answers; a pure
// number has none.
std::optional<QuantityField> find_range(const StepReader& r) {
  if (const auto plain = r.json.find("range")) return QuantityField{*plain, "range", Unit()};
  for (const std::string& key : r.json.keys()) {
    const KeyParts parts = split_key(key);
    if (parts.stem == "range") return r.json.find_quantity("range", parts.dimension());
  }
  for (const std::string& key : r.json.keys()) {
    if (!key.starts_with("range_")) continue;
    r.json.at(key).refuse_key(
        fmt::format("`{}` names no unit, expected that of the answer, like range_um, range_degC or "
                    "range_percent; range for a pure number",
                    printable(key, kChoiceMax)));
  }
  return std::nullopt;
}

void read_range(const StepReader& r, AskStep& out) {
  const auto range = find_range(r);
  if (!range) {
    return r.json.refuse(
        "a number without a range, expected the least and the greatest one, like range_um: [20, "
        "400]; its unit is that of the answer");
  }
  const Dimension dimension = range->unit.dimension;
  out.unit = std::string(range->unit.suffix);
  out.to_si = range->unit.to_si;
  const auto ends = range->value.items(2, 2);
  if (ends.size() != 2) return;
  out.min = r.scope.read(ends[0], dimension, out.to_si, kAnyNumber);
  out.max = r.scope.read(ends[1], dimension, out.to_si, kAnyNumber);
  out.default_number = r.optional("default", dimension, kAnyNumber);
  const auto plain = out.unit.empty() ? r.json.find("default") : std::nullopt;
  if (plain) out.default_number = r.scope.read(*plain, dimension, 1, kAnyNumber);
  if (out.min->name.empty() && out.max->name.empty() && !(out.min->value < out.max->value)) {
    range->value.refuse(fmt::format("from {:.6g} to {:.6g}, expected the least number first",
                                    out.min->value / out.to_si, out.max->value / out.to_si));
  }
}

// Checks the default as far as the file alone allows; the plan checks the rest.
void check_default(const StepReader& r, const AskStep& ask) {
  const bool given = ask.default_number || ask.default_text;
  if (ask.on_timeout == OnTimeout::use_default && !given) {
    r.json.refuse(fmt::format("\"on_timeout\": \"default\" without a default, expected {}",
                              ask.type == AnswerType::number ? "default, in the unit of the range"
                              : ask.type == AnswerType::confirmation
                                  ? "abort or wait: nobody but a person "
                                    "confirms"
                                  : "\"default\": \"...\""));
  }
  const bool chosen = ask.type == AnswerType::choice && ask.default_text && r.json.sound();
  if (chosen && std::ranges::find(ask.choices, *ask.default_text) == ask.choices.end()) {
    r.json.at("default").refuse(
        fmt::format("\"{}\", expected one of the choices", printable(*ask.default_text)));
  }
}

}  // namespace

AskStep AskStep::parse(const StepReader& r) {
  AskStep out;
  out.text = one_line(r.json.at("text"), kTextMax);
  const JsonReader type = r.json.at("answer");
  out.type = type.word<AnswerType>();
  out.timeout = r.timeout();
  if (const auto what = r.json.find("on_timeout")) {
    out.on_timeout = what->word<OnTimeout>();
  }
  if (!type.sound()) {  // which of these keys it may have is unknown
    for (const std::string& key : r.json.keys()) r.json.has(key);
    return out;
  }
  const bool worded = out.type == AnswerType::choice || out.type == AnswerType::line;
  if (out.type == AnswerType::choice) read_choices(r, out);
  if (out.type == AnswerType::number) read_range(r, out);
  if (const auto text = worded ? r.json.find("default") : std::nullopt) {
    out.default_text = one_line(*text, out.type == AnswerType::line ? kAnswerMax : kChoiceMax);
  }
  check_default(r, out);
  return out;
}

Question AskStep::question(const std::string& step_id, const Environment& environment) const {
  Question out;
  out.step_id = step_id;
  out.text = text;
  out.type = type;
  out.choices = choices;
  out.unit = unit;
  if (min) out.min = in_unit(environment.get(*min), to_si);
  if (max) out.max = in_unit(environment.get(*max), to_si);
  if (default_number) out.fallback = in_unit(environment.get(*default_number), to_si);
  if (default_text) out.fallback = *default_text;
  out.on_timeout = on_timeout;
  return out;
}

bool AskStep::is_known(const Environment& environment) const {
  const auto known = [&](const std::optional<Number>& n) {
    return !n || n->name.empty() || environment.values().contains(n->name);
  };
  return known(min) && known(max) && known(default_number);
}

namespace {

// Checks the values that the plan's references give to the range and to the default.
MaybeRefusal unfit(const AskStep& ask, const Question& q, const PlannedRig& rig) {
  if (q.type != AnswerType::number) return std::nullopt;
  if (q.min > q.max) {
    return Refusal(fmt::format("its range is from {} to {} {}: nothing fits", q.min, q.max, q.unit),
                   at_most(*ask.min, rig.get(*ask.max), rig.asked()));
  }
  if (!q.fallback || read_answer(q, *q.fallback)) return std::nullopt;
  const bool above = std::get<double>(*q.fallback) > q.max;
  return Refusal(fmt::format("its default {} does not fit, expected {}",
                             answer_words(*q.fallback, q.unit), expected_words(q)),
                 above ? at_most(*ask.default_number, rig.get(*ask.max), rig.asked())
                       : at_least(*ask.default_number, rig.get(*ask.min), rig.asked()));
}

}  // namespace

StepPlan AskStep::plan(PlannedRig& rig) const {
  const double patience_s = rig.get(timeout);
  StepPlan out(std::min(PlannedRig::kByHand_s, patience_s));
  out.by_hand = true;
  const Question q = question("", rig.environment());
  if (auto why = unfit(*this, q, rig)) out.refuse(std::move(*why));
  constexpr std::string_view kThen[] = {"the run ends", "it waits on", "the default is taken"};
  out.note =
      fmt::format("a person answers with {}; about {:.0f} s; after {:.6g} s {}", expected_words(q),
                  out.seconds, patience_s, kThen[static_cast<std::size_t>(on_timeout)]);
  return out;
}

namespace {

Task<> respond(RunParts& run, Question question, Result<>& said) {
  if (run.setup.respondent == nullptr) {
    co_await run.questions.answered();
    co_return;
  }
  auto given = co_await run.setup.respondent->answer(std::move(question));
  if (given) {
    run.questions.accept(*given);
  } else {
    said = fail(given.error());
  }
}

// Does what the protocol says when nobody answered in time.
Task<Result<>> after_timeout(const Question& question, double patience_s, bool told,
                             RunParts& run) {
  const std::string why =
      fmt::format("step {}: nobody answered within {:.6g} s", question.step_id, patience_s);
  if (question.on_timeout == OnTimeout::abort) {
    run.questions.withdraw(why + ", and the run was ended");
    co_return fail(Errc::aborted, "{}, and the protocol ends the run then", why);
  }
  if (question.on_timeout == OnTimeout::use_default) {
    run.questions.accept(GivenAnswer{question.fallback.value(), AnswerSource::fallback, ""});
    co_return Result<>();
  }
  if (!told) run.event(EventKind::late, why + "; the run waits on");
  run.questions.wait_on();
  Result<> said;
  co_await respond(run, question, said);
  co_return said;
}

Task<Result<>> wait_for_answer(const Question& question, double patience_s, RunParts& run,
                               AskStep::Progress& progress) {
  Clock& clock = run.setup.clock;
  const MonoTime begin = clock.now();
  const MonoTime until = progress.time.begin(begin, from_seconds(patience_s));
  const Questions::Wait wait(run.questions, question, run.labels.repeat(), until);
  Result<> said;
  auto answer = respond(run, question, said);
  auto first = co_await either(std::move(answer), clock.wait_until(until));
  static_cast<void>(first);
  // Includes an answer at the instant of the time-out or of an interrupt.
  progress.answered = run.questions.take();
  if (progress.answered || !said) co_return said;
  if (clock.now() < until) co_return fail(Errc::aborted, "the question was withdrawn");
  auto late = co_await after_timeout(question, patience_s, until == begin, run);
  progress.answered = run.questions.take();
  if (late && !progress.answered) late = fail(Errc::aborted, "the question was withdrawn");
  co_return late;
}

}  // namespace

Task<Result<>> AskStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  if (run.questions.take()) progress.answered = true;
  if (progress.kept_answer) {  // an answer to the run that this one continues
    run.event(*progress.kept_answer);
    progress.kept_answer.reset();
    progress.answered = true;
  }
  if (progress.answered) co_return co_await run.drive.restore_hold();
  // A frame that holds a force moves to keep it. No person should reach under a probe that may
  // move, so the frame holds its travel until the answer.
  const Question asked = question(run.log.step_id(), run.values);
  Clock& clock = run.setup.clock;
  MonoTime until = progress.time.begin(clock.now(), from_seconds(run.get(timeout)));
  if (on_timeout == OnTimeout::wait) until = MonoTime::max();
  auto shown = co_await run.wait_for_person(until);
  if (!shown) co_return fail(shown.error());
  std::optional<ProgressKeeper::Shown> waiting(std::move(*shown));
  run.event(EventKind::prompt, prompt_words(asked));
  auto got = co_await wait_for_answer(asked, run.get(timeout), run, progress);
  waiting.reset();
  if (!got) co_return got;
  co_return co_await run.drive.restore_hold();
}

}  // namespace lcrig
