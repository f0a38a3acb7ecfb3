// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/take_over.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/either.hpp"
#include "protocols/expand.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/interrupts.hpp"
#include "protocols/run/losses.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

namespace {

// Speed at which step number `n` (from 0) begins to move, m/s; 0: it does not move, or follows a
// force.
double begun_speed(const Protocol& protocol, Environment env, std::int64_t n) {
  StepCursor ahead(protocol.steps, env);
  const Step* step = ahead.next();
  for (; step != nullptr && n > 0; --n) step = ahead.next();
  if (step == nullptr) return 0;
  const Number* speed = facts_of(*step).speed;
  return speed != nullptr ? env.get(*speed) : 0;
}

}  // namespace

Task<Result<>> TakeOver::ask_person() {
  const Continuation& from = *run_.setup.continues;
  const auto waiting = co_await run_.wait_as(RunState::waiting_for_operator);
  const std::string prompt = fmt::format(
      "Run {} stopped in step {}. Look at the rig: if specimen {} was not touched since, confirm "
      "to go on.",
      from.run, from.step_id, run_.setup.specimen);
  run_.event(EventKind::prompt, prompt);
  co_return co_await run_.setup.person->confirm(prompt);
}

Task<std::optional<InterruptRequest>> TakeOver::confirm_specimen() {
  const Continuation& from = *run_.setup.continues;
  std::optional<InterruptRequest> stop;
  if (!from.confirmed) {
    unconfirmed_ = true;
    auto r = co_await either(ask_person(), run_.interrupts.wait());
    if (r.index() == 1) {
      stop = run_.interrupts.take();
    } else if (const auto& said = std::get<0>(r); !said) {
      stop = InterruptRequest(Interrupt::abort, said.error());
    }
    if (stop && (stop->kind == Interrupt::loss || stop->kind == Interrupt::pause)) {
      stop->kind = Interrupt::fault;
    }
    unconfirmed_ = stop.has_value();
  }
  if (!stop) {
    run_.event(EventKind::confirm, fmt::format("the specimen of run {} was not touched", from.run));
  }
  co_return stop;
}

Result<> TakeOver::compare_frame_at(std::int64_t first_step) const {
  const Continuation& from = *run_.setup.continues;
  LastSeen before = from.frame;
  before.zeroed = from.point.zeroed;
  before.origin = from.point.origin;
  before.begun_m_s = begun_speed(run_.setup.protocol, run_.setup.environment, first_step);
  auto same = compare_origin(run_, before);
  if (same) same = compare_place(run_, before);
  return same;
}

Task<Result<>> TakeOver::pass_done_steps(StepCursor& cursor) {
  const Continuation& from = *run_.setup.continues;
  run_.event(ContinuesEvent{from.run, from.step_id, from.point.steps_done});
  auto heard = co_await run_.meter.await_samples(run_.needs_force());
  if (!heard) co_return heard;
  const std::int64_t first =
      first_step_of(run_.setup.protocol, run_.setup.environment, from.point.steps_done);
  auto same = compare_frame_at(first);
  if (!same) {
    same.error().hands_off = run_.response.lose_origin(same.error().what);
    co_return same;
  }
  run_.watch.take_over_zeros(from.point.zeroed, from.point.zeros_N);
  left_off_.start_travel_m = from.point.travel_m;
  run_.watch.take_over_contact(from.point.contact_travel_m);
  run_.labels.take_from(from.point);
  LcrSettings settings = run_.sampler.settings();
  for (; run_.progress.steps_done() < first; run_.progress.count_step()) {
    const Step* step = cursor.next();
    if (step == nullptr) {
      co_return fail(Errc::invalid_request, "run {}: has no step {}", from.run, first);
    }
    pass_over(*step, settings);
  }
  // The run may have been cut off between an answer and the next step.
  const bool here = first == from.point.steps_done;
  if (here && asked_ < from.answers.size()) {
    left_off_.answer = from.answers[asked_].answer;
    if (!left_off_.answer->from_run) left_off_.answer->from_run = from.run;
  }
  if (!(settings == run_.sampler.settings())) {
    auto set = co_await run_.sampler.configure(std::move(settings));
    if (!set) co_return set;
  }
  co_return co_await run_.drive.restore_hold();
}

// Stores the answer of a skipped step for this run as well, so that the question is not asked
// again.
void TakeOver::keep_answer(std::size_t which) {
  const Continuation& from = *run_.setup.continues;
  if (which >= from.answers.size()) return;
  const StoredAnswer& stored = from.answers[which];
  AnswerEvent kept = stored.answer;
  if (!kept.from_run) kept.from_run = from.run;
  run_.setup.sink.event(RunEvent(run_.setup.clock.now(), stored.step_id, kept));
}

void TakeOver::pass_over(const Step& step, LcrSettings& settings) {
  const StepFacts facts = facts_of(step);
  run_.labels.aim(facts);
  if (facts.sets_meter != nullptr) {
    settings = facts.sets_meter->change(std::move(settings), run_.values);
  }
  if (facts.asks != nullptr) keep_answer(asked_++);
  if (!facts.leaves) return;
  std::optional<double> held_N;
  if (facts.leaves == HoldMode::force) {
    held_N = facts.aim != nullptr ? run_.labels.force_of(*facts.aim) : run_.rig.frame.force_N;
  }
  run_.drive.will_hold(held_N);
}

}  // namespace lcrig
