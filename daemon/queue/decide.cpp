// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/decide.hpp"

#include <array>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kYes = "yes";

// A line was disturbed, or nobody answered. Of a run that did not begin it is what touched nothing.
bool is_line_trouble(Errc code) {
  switch (code) {
    case Errc::no_reply:
    case Errc::reply_cut_off:
    case Errc::garbled:
    case Errc::disconnected: return true;
    default: return false;
  }
}

// What terms may decide on. Everything else holds the queue: stops, hazards, a disk or a program
// that fails, and what the frame refuses in a run.
bool may_be_skipped(const EntryOutcome& outcome) {
  if (!outcome.code) return false;
  switch (*outcome.code) {
    case Errc::invalid_request:
    case Errc::unsupported: return true;
    case Errc::refused: return !outcome.begun;
    default: return is_line_trouble(*outcome.code);
  }
}

// The closed list of what did not touch the specimen.
bool may_be_repeated_at_once(const EntryOutcome& outcome) {
  return !outcome.begun && outcome.code && is_line_trouble(*outcome.code);
}

std::string reason_of(const EntryOutcome& outcome) {
  if (!outcome.reason.empty()) return outcome.reason;
  return std::string(to_string(outcome.status));
}

Aftermath held(Aftermath after, HoldCause cause, std::string why) {
  after.hold = cause;
  after.why = std::move(why);
  return after;
}

// Of a failure that terms may decide on.
Aftermath as_terms_say(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                       Aftermath after) {
  const std::string reason = reason_of(outcome);
  if (after.failures_in_row >= terms.failures_max && terms.on_failure != OnFailure::hold) {
    return held(
        std::move(after), HoldCause::too_many_failures,
        fmt::format("{} failures in a row; the last one: {}", after.failures_in_row, reason));
  }
  switch (terms.on_failure) {
    case OnFailure::skip: after.entry = EntryState::skipped; return after;
    case OnFailure::repeat:
      if (!may_be_repeated_at_once(outcome)) break;
      after.entry = EntryState::waiting;
      return after;
    case OnFailure::look:
      if (attempts > 1) break;  // it was repeated already
      return held(std::move(after), HoldCause::look, reason);
    case OnFailure::hold: break;
  }
  return held(std::move(after), HoldCause::failure, reason);
}

}  // namespace

std::string_view to_string(HoldCause cause) {
  constexpr std::array<std::string_view, 14> kWords{
      "not_started",       "person", "restart",          "empty",   "not_standing", "left_loaded",
      "frame_fault",       "limit",  "other_instrument", "aborted", "failure",      "look",
      "too_many_failures", "bug"};
  return kWords[static_cast<std::size_t>(cause)];
}

HoldCause cause_of(Hazard hazard) {
  switch (hazard) {
    case Hazard::not_standing: return HoldCause::not_standing;
    case Hazard::left_loaded: return HoldCause::left_loaded;
    case Hazard::frame_fault: return HoldCause::frame_fault;
    case Hazard::limit: return HoldCause::limit;
    case Hazard::other_instrument: return HoldCause::other_instrument;
  }
  return HoldCause::bug;
}

std::string_view to_string(Gate::Kind kind) {
  return kind == Gate::Kind::specimen ? "specimen" : "person";
}

Result<> check_answer(const Gate& gate, std::string_view answer) {
  if (trimmed(answer) == gate.expected) return {};
  if (gate.kind == Gate::Kind::specimen) {
    return fail(Errc::invalid_request,
                "the next run needs `{}` on the rig, and not `{}`: nothing moves; put it on and "
                "type its name, or take the entry out (`lcrig queue remove {}`)",
                gate.expected, printable(answer, 60), gate.entry);
  }
  return fail(Errc::invalid_request,
              "`{}` is no consent: type `{}` when you are at the rig; nothing moves until then",
              printable(answer, 60), gate.expected);
}

NextAct next_act(const QueueFacts& facts) {
  if (!facts.going || facts.run_goes_on) return Stay();
  if (!facts.head) return Finished();
  const HeadFacts& head = *facts.head;
  if (head.state != EntryState::waiting) return Stay();
  Gate gate;
  gate.entry = head.entry;
  if (facts.on_rig != head.specimen) {
    gate.kind = Gate::Kind::specimen;
    gate.expected = head.specimen;
    const std::string off = facts.on_rig ? fmt::format("take {} off, ", *facts.on_rig) : "";
    gate.prompt =
        fmt::format("entry {}: {}put {} on, then type its name", head.entry, off, head.specimen);
    return gate;
  }
  if (head.moves && !head.terms.unattended && !facts.person_there) {
    gate.kind = Gate::Kind::person;
    gate.expected = kYes;
    gate.prompt =
        fmt::format("entry {}: {} on {} moves the frame; type yes when you are at the rig",
                    head.entry, head.protocol, head.specimen);
    return gate;
  }
  return Begin{head.entry};
}

Aftermath aftermath_of(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                       std::int64_t failures_in_row) {
  Aftermath after;
  // What was refused before anything was commanded waits on.
  after.entry = outcome.begun ? EntryState::failed : EntryState::waiting;
  after.failures_in_row = failures_in_row + 1;
  if (outcome.status == ExitStatus::success) {
    after.entry = EntryState::done;
    after.failures_in_row = 0;
  } else if (outcome.status == ExitStatus::interrupted) {
    after.entry = EntryState::interrupted;
  }
  if (outcome.hazard) {
    return held(std::move(after), cause_of(*outcome.hazard),
                fmt::format("{} ({})", words_of(*outcome.hazard), reason_of(outcome)));
  }
  if (outcome.status == ExitStatus::success) return after;
  if (outcome.status != ExitStatus::fail || outcome.code == Errc::aborted) {
    return held(std::move(after), HoldCause::aborted, reason_of(outcome));
  }
  // Nobody but a person says again that the specimen was not touched meanwhile.
  if (outcome.resumes && !outcome.begun) after.entry = EntryState::interrupted;
  if (!may_be_skipped(outcome) || after.entry == EntryState::interrupted) {
    return held(std::move(after), HoldCause::failure, reason_of(outcome));
  }
  return as_terms_say(outcome, terms, attempts, std::move(after));
}

}  // namespace lcrig
