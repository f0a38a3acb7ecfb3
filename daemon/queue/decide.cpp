// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/decide.hpp"

#include <cmath>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kYes = "yes";

// Whether a line was disturbed or nobody answered. If the run did not begin, nothing was touched.
bool is_line_trouble(Errc code) {
  switch (code) {
    case Errc::no_reply:
    case Errc::reply_cut_off:
    case Errc::garbled:
    case Errc::disconnected: return true;
    default: return false;
  }
}

// Whether the terms of an entry may decide about this failure. Everything else holds the queue:
// stops, hazards, failures of disk or program, and refusals of the frame during a run.
bool may_be_skipped(const EntryOutcome& outcome) {
  if (!outcome.code) return false;
  switch (*outcome.code) {
    case Errc::invalid_request:
    case Errc::unsupported: return true;
    case Errc::refused: return !outcome.begun;
    default: return is_line_trouble(*outcome.code);
  }
}

// Only these failures certainly did not touch the specimen.
bool may_be_repeated_at_once(const EntryOutcome& outcome) {
  return !outcome.begun && outcome.code && is_line_trouble(*outcome.code);
}

std::string reason_of(const EntryOutcome& outcome) {
  if (!outcome.reason.empty()) return outcome.reason;
  return std::string(to_string(outcome.status));
}

EntryEnd held(EntryEnd after, HoldCause cause, std::string why) {
  after.hold = cause;
  after.why = std::move(why);
  return after;
}

Gate gate_for(QueueGate kind, const HeadFacts& head, std::string expected, std::string prompt) {
  Gate out;
  out.kind = kind;
  out.entry = head.entry;
  out.expected = std::move(expected);
  out.prompt = fmt::format("entry {}: {}", head.entry, prompt);
  return out;
}

// Words such as "take paper-1 off, put paper-2 on, then type its name".
std::string exchange_words(const std::optional<std::string>& before, const std::string& now) {
  const std::string off = before ? fmt::format("take {} off, ", *before) : "";
  return fmt::format("{}put {} on, then type its name", off, now);
}

// The gate for whatever must be put on the rig, as far as the entry names it.
std::optional<Gate> gate_of_setup(const QueueFacts& facts, const HeadFacts& head) {
  const auto& terms = head.terms;
  if (facts.on_rig != head.specimen) {
    return gate_for(QueueGate::specimen, head, head.specimen,
                    exchange_words(facts.on_rig, head.specimen));
  }
  if (!terms.probe.empty() && facts.probe != terms.probe) {
    return gate_for(QueueGate::probe, head, terms.probe,
                    "probe: " + exchange_words(facts.probe, terms.probe));
  }
  if (!terms.fixture.empty() && facts.fixture != terms.fixture) {
    return gate_for(QueueGate::fixture, head, terms.fixture,
                    "fixture: " + exchange_words(facts.fixture, terms.fixture));
  }
  if (!facts.stranger) return std::nullopt;
  return gate_for(QueueGate::stranger, head, head.specimen,
                  fmt::format("{}; look what is on the rig, put {} on, then type its name",
                              *facts.stranger, head.specimen));
}

// The latest of all times that the entry has to wait for.
std::optional<WaitUntil> wait_of(const QueueFacts& facts, const HeadFacts& head) {
  const BeginTime begin = begin_time(head.terms, facts.now_unix_s, facts.last_end_unix_s);
  if (begin.why.empty()) return std::nullopt;
  WaitUntil out;
  out.entry = head.entry;
  out.unix_s = begin.unix_s;
  out.why =
      fmt::format("entry {} begins at {} ({})", head.entry, local_time(begin.unix_s), begin.why);
  return out;
}

// The end of an entry whose terms decide about its failure.
EntryEnd as_terms_say(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                      EntryEnd after) {
  const std::string reason = reason_of(outcome);
  if (after.failures_in_row >= terms.failures_max && terms.on_failure != OnFailure::hold) {
    return held(
        std::move(after), HoldCause::too_many_failures,
        fmt::format("{} failures in a row; the last one: {}", after.failures_in_row, reason));
  }
  switch (terms.on_failure) {
    case OnFailure::skip: after.state = EntryState::skipped; return after;
    case OnFailure::repeat:
      if (!may_be_repeated_at_once(outcome)) break;
      after.state = EntryState::waiting;
      return after;
    case OnFailure::look:
      if (attempts > 1) break;  // it has already been repeated
      return held(std::move(after), HoldCause::look, reason);
    case OnFailure::hold: break;
  }
  return held(std::move(after), HoldCause::failure, reason);
}

}  // namespace

BeginTime begin_time(const QueueTerms& terms, std::int64_t now_unix_s,
                     std::optional<std::int64_t> last_end_unix_s) {
  BeginTime out;
  out.unix_s = now_unix_s;
  const auto wait_until = [&out](std::int64_t unix_s, std::string why) {
    if (unix_s <= out.unix_s) return;
    out.unix_s = unix_s;
    out.why = std::move(why);
  };
  if (last_end_unix_s && terms.rest_s > 0) {
    const auto rest_s = static_cast<std::int64_t>(std::ceil(terms.rest_s));
    wait_until(*last_end_unix_s + rest_s, fmt::format("a rest of {} s", rest_s));
  }
  if (terms.not_before_unix_s) wait_until(*terms.not_before_unix_s, "not before");
  if (terms.between) {
    wait_until(next_inside(out.unix_s, *terms.between), "between " + to_string(*terms.between));
  }
  return out;
}

Result<> check_begin(const QueueTerms& terms, std::int64_t now_unix_s) {
  if (!terms.not_after_unix_s) return {};
  const std::int64_t last = *terms.not_after_unix_s;
  if (last < now_unix_s) {
    return fail(Errc::invalid_request, "not after {}: that is over, it could never begin",
                local_time(last));
  }
  const BeginTime begin = begin_time(terms, now_unix_s, std::nullopt);
  if (begin.unix_s <= last) return {};
  return fail(Errc::invalid_request, "not after {}, and not before {} ({}): it could never begin",
              local_time(last), local_time(begin.unix_s), begin.why);
}

Result<> check_answer(const Gate& gate, std::string_view answer) {
  if (trimmed(answer) == gate.expected) return {};
  if (gate.kind != QueueGate::person) {
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
  const auto& last = head.terms.not_after_unix_s;
  if (last && facts.now_unix_s > *last) {
    TooLate late;
    late.entry = head.entry;
    late.why = fmt::format("entry {} was to begin before {}: queue it anew", head.entry,
                           local_time(*last));
    return late;
  }
  // Ask a person first; afterwards the rest can go on by itself at any hour.
  if (auto gate = gate_of_setup(facts, head)) return *std::move(gate);
  if (auto wait = wait_of(facts, head)) return *std::move(wait);
  if (head.moves && !head.terms.unattended && !facts.person_there) {
    return gate_for(QueueGate::person, head, std::string(kYes),
                    fmt::format("{} on {} moves the frame; type yes when you are at the rig",
                                head.protocol, head.specimen));
  }
  return Begin{head.entry};
}

EntryEnd aftermath_of(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                      std::int64_t failures_in_row) {
  EntryEnd after;
  after.detail = outcome.reason;
  // An entry that did not begin because of a hazard or a stop is still waiting. An entry whose
  // terms decide has failed.
  after.state = outcome.begun ? EntryState::failed : EntryState::waiting;
  after.failures_in_row = failures_in_row + 1;
  if (outcome.status == ExitStatus::success) {
    after.state = EntryState::done;
    after.failures_in_row = 0;
  } else if (outcome.status == ExitStatus::interrupted) {
    after.state = EntryState::interrupted;
  }
  if (outcome.hazard) {
    return held(std::move(after), *outcome.hazard,
                fmt::format("{} ({})", words_of(*outcome.hazard), reason_of(outcome)));
  }
  if (outcome.status == ExitStatus::success) return after;
  if (outcome.status != ExitStatus::fail || outcome.code == Errc::aborted) {
    const auto* const how = outcome.status == ExitStatus::stopped ? "stopped" : "aborted";
    return held(std::move(after), HoldCause::aborted,
                fmt::format("the run was {}: {}", how, reason_of(outcome)));
  }
  // Only a person can confirm again that the specimen was not touched. So a continuation that did
  // not begin stays interrupted.
  after.state = outcome.resumes && !outcome.begun ? EntryState::interrupted : EntryState::failed;
  if (!may_be_skipped(outcome) || after.state == EntryState::interrupted) {
    return held(std::move(after), HoldCause::failure, reason_of(outcome));
  }
  return as_terms_say(outcome, terms, attempts, std::move(after));
}

}  // namespace lcrig
