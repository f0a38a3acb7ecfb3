// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/run_steering.hpp"

#include <fmt/format.h>

#include <utility>

#include "daemon/app/callers.hpp"
#include "daemon/app/queue_turns.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/operator.hpp"
#include "daemon/session.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

using Kind = PlannedStops::Kind;

std::string at_words(const PlannedStop& stop) {
  return fmt::format("the end of the {} (step {})", place_words(stop.place), stop.step_id);
}

// What the run waits for before it can go on to its planned end; empty: nothing.
std::string but_first(RunState state) {
  switch (state) {
    case RunState::paused: return "; it is paused, and goes on with `lcrig resume`";
    case RunState::waiting_for_operator:
      return "; it waits for a person first: `lcrig status` says for what";
    case RunState::waiting_for_instrument: return "; it waits for an instrument first";
    case RunState::stopping: return "; standstill of the frame is not confirmed yet";
    case RunState::holding_force: return "; it waits for an instrument first, and holds the force";
    case RunState::preparing:
    case RunState::running:
    case RunState::finishing:
    case RunState::ended: break;
  }
  return "";
}

std::string words_of(Kind kind, const PlannedStops::Asked& asked, RunState state) {
  const char* stops = kind == Kind::stop ? "stops at" : "pauses at";
  const std::string then = kind == Kind::stop ? ", then unloads" : "";
  if (asked.was_nearer) {
    return fmt::format("it {} {} already, which comes no later: that stands{}", stops,
                       at_words(asked.stop), but_first(state));
  }
  std::string out = fmt::format("it {} {}, in about {:.0f} s{}", stops, at_words(asked.stop),
                                asked.seconds, then);
  if (asked.replaces) {
    out += fmt::format("; that is nearer than {}, which was asked for before",
                       at_words(*asked.replaces));
  }
  return out + but_first(state);
}

std::string reason_of(const std::string& why, const PeerCredentials& peer) {
  return why.empty() ? "by " + peer.user : why + " (by " + peer.user + ")";
}

}  // namespace

Task<Result<StopAnswer>> RunSteering::pause(PeerCredentials peer) {
  peer.user = co_await parts_.callers.name_for_stop(peer);
  auto live = parts_.use.running();
  if (!live) co_return fail(live.error());
  Run& run = **live;
  parts_.callers.note("run.pause", peer);
  const Run::Taken taken = run.interrupt(InterruptRequest(Interrupt::pause, reason_of("", peer)));
  if (taken != Run::Taken::acts) {
    co_return fail(Errc::invalid_request,
                   "the run is ending and is not paused: the frame moves to unload the specimen; "
                   "lcrig freeze stops it at once");
  }
  co_return co_await confirm_pause(run);
}

// What a person must know if the frame may move, though it was to stop.
std::optional<Error> RunSteering::alarm_of(const Run& run) const {
  const auto words = alarm_words(run.progress().standstill);
  if (words.empty()) return std::nullopt;
  return Error(Errc::not_standing,
               fmt::format("frame: {}; STOP is sent again and again until it is confirmed", words));
}

// How the run ended that was to be stopped or paused.
Error RunSteering::end_of(const Run& run) const {
  const auto& last = parts_.use.last_run();
  const bool gone = parts_.use.live_run() != &run;
  if (gone && last && !last->stands) {
    return Error(Errc::not_standing, "frame: standstill not confirmed: use the E-stop");
  }
  return Error(Errc::aborted, gone && last ? "the run ended instead: " + last->reason
                                           : "the run ends instead: it was stopped");
}

// Returns when `is_known`, or when standstill is not confirmed in time.
template <class Known>
Task<> RunSteering::await_stop(const Run& run, Known is_known) {
  constexpr Duration kLook = 50ms;  // the alarm comes with time alone, and is no event
  const MonoTime alarm = clock_.now() + StandstillWatch::kPatience;
  const MonoTime limit = clock_.now() + 70s;  // enough for two STOPs on the slowest machine
  const auto is_over = [this, &run, &is_known, alarm] {
    if (parts_.use.live_run() != &run || is_known()) return true;
    return clock_.now() >= alarm && alarm_of(run);
  };
  bool over = is_over();
  while (!over && clock_.now() < limit) {
    const MonoTime next = clock_.now() + kLook;
    over = co_await parts_.use.wait(is_over, next);
  }
}

// Answers "paused" only when the frame stands and the run waits.
Task<Result<StopAnswer>> RunSteering::confirm_pause(Run& run) {
  const auto waits_for_instrument = [&run] {
    return run.progress().state == RunState::waiting_for_instrument;
  };
  const auto is_known = [&run, &waits_for_instrument] {
    return run.progress().state == RunState::paused || waits_for_instrument() || run.is_ending();
  };
  co_await await_stop(run, is_known);
  if (parts_.use.live_run() != &run) co_return tl::unexpected(end_of(run));
  if (run.progress().state == RunState::paused) {
    if (run.commands()) co_return StopAnswer(StopState::standing, "paused");
    co_return StopAnswer(StopState::not_ours,
                         "paused; the frame was only observed and is not stopped");
  }
  if (waits_for_instrument()) {
    co_return StopAnswer(StopState::standing,
                         "the frame stands; the run waits for an instrument, and is paused when it "
                         "is back");
  }
  if (auto alarm = alarm_of(run)) co_return tl::unexpected(std::move(*alarm));
  if (run.is_ending()) co_return tl::unexpected(end_of(run));
  co_return fail(Errc::not_standing, "frame: standstill not confirmed: use the E-stop");
}

Task<Result<StopAnswer>> RunSteering::stop_run(Interrupt kind, std::string why,
                                               PeerCredentials peer) {
  peer.user = co_await parts_.callers.name_for_stop(peer);
  const std::string reason = reason_of(why, peer);
  auto live = parts_.use.running();
  if (!live && parts_.use.state() == RigUse::State::starting) {
    // From now on nothing may move. The start that is being prepared answers with an error.
    parts_.use.stop_start(InterruptRequest(kind, reason));
    co_return StopAnswer(StopState::not_begun,
                         "the run that is being prepared does not begin: nothing moves");
  }
  if (!live) co_return fail(live.error());
  Run& run = **live;
  parts_.callers.note(kind == Interrupt::freeze ? "run.freeze" : "run.abort", peer, why);
  const std::uint64_t stands = run.stands(), failures = run.failed_stops();
  const Run::Taken taken = run.interrupt(InterruptRequest(kind, reason));
  if (taken == Run::Taken::finally_goes_on) {
    co_return StopAnswer(
        StopState::finally,
        "`finally` is running and goes on: the frame moves to unload the specimen; "
        "lcrig freeze stops it at once");
  }
  co_return co_await confirm_stop(run, stands, failures);
}

// Answers "stopped" only when the frame confirmed it after the request.
Task<Result<StopAnswer>> RunSteering::confirm_stop(Run& run, std::uint64_t stands,
                                                   std::uint64_t failures) {
  const auto is_known = [&run, stands, failures] {
    return run.stands() != stands || run.failed_stops() > failures;
  };
  co_await await_stop(run, is_known);
  const bool gone = parts_.use.live_run() != &run;
  const auto& ended = parts_.use.last_run();
  const bool failed = gone ? ended && ended->code == Errc::not_standing : run.stands() == stands;
  if (failed) {
    co_return fail(Errc::not_standing, "frame: standstill not confirmed: use the E-stop");
  }
  if (!gone && !run.commands()) {
    co_return StopAnswer(StopState::not_ours,
                         "the recording ends; the frame was only observed and is not stopped");
  }
  co_return StopAnswer(StopState::standing, "stopped");
}

Task<Result<StopAnswer>> RunSteering::abort(std::string why, PeerCredentials peer) {
  return stop_run(Interrupt::abort, std::move(why), std::move(peer));
}

Task<Result<StopAnswer>> RunSteering::freeze(std::string why, PeerCredentials peer) {
  auto stopped = co_await stop_run(Interrupt::freeze, std::move(why), std::move(peer));
  if (stopped && stopped->state == StopState::standing) {
    stopped->note = "stopped; the frame stays where it is";
  }
  co_return stopped;
}

Task<Result<StopAnswer>> RunSteering::ask_at(PlannedStops::Kind kind, StopPlace place,
                                             std::string why, PeerCredentials peer) {
  peer.user = co_await parts_.callers.name_for_stop(peer);
  auto live = parts_.use.running();
  if (!live && parts_.use.state() == RigUse::State::starting) {
    co_return fail(Errc::invalid_request,
                   "the run is still being prepared: `lcrig abort` keeps it from beginning");
  }
  if (!live) co_return fail(live.error());
  Run& run = **live;
  if (run.is_ending() && run.is_frozen()) co_return tl::unexpected(end_of(run));
  if (run.is_ending()) {
    co_return StopAnswer(StopState::finally,
                         "the run is ending already: `finally` runs, or is about to");
  }
  auto asked = run.ask_at(kind, place, reason_of(why, peer));
  if (!asked) co_return fail(asked.error());
  parts_.callers.note(kind == Kind::stop ? "run.stop" : "run.pause", peer, why);
  co_return StopAnswer(StopState::later, words_of(kind, *asked, run.progress().state));
}

Task<Result<StopAnswer>> RunSteering::pause_at(StopPlace place, PeerCredentials peer) {
  return ask_at(Kind::pause, place, std::string(), std::move(peer));
}

Task<Result<StopAnswer>> RunSteering::stop_after(StopPlace place, std::string why,
                                                 PeerCredentials peer) {
  return ask_at(Kind::stop, place, std::move(why), std::move(peer));
}

Task<Result<>> RunSteering::confirm(PeerCredentials peer) {
  const Run* run = parts_.use.live_run();
  if (run != nullptr && run->question()) {
    const Question& question = run->question()->question;
    if (question.type != AnswerType::confirmation) {
      co_return fail(Errc::invalid_request, "step {} asks for {}: `lcrig answer VALUE`",
                     question.step_id, expected_words(question));
    }
    auto answered = co_await answer(AnswerRequest(), std::move(peer));
    if (!answered) co_return fail(answered.error());
    co_return Result<>();
  }
  const std::string asked = parts_.person.prompt();
  QueueRunner* const queue = parts_.queue.runner();
  const bool at_gate = queue != nullptr && queue->awaits_consent();
  const auto entry = at_gate ? queue->status().entry : std::nullopt;
  peer.user = co_await parts_.callers.name_of(peer);
  const bool confirmed = parts_.person.prompt() == asked && parts_.person.confirmed();
  if (!confirmed && at_gate) {
    co_return co_await queue->answer("yes", entry, std::move(peer));
  }
  if (!confirmed) co_return fail(Errc::invalid_request, "nothing waits for confirmation");
  parts_.callers.note("run.confirm", peer);
  co_return Result<>();
}

// Answers a client only when the answer is in the database. The answer belongs to the question that
// was open when it came; by the time the peer's name is known, another one may be open.
Task<Result<Answered>> RunSteering::answer(AnswerRequest request, PeerCredentials peer) {
  const Run* asking = parts_.use.live_run();
  if (!request.question && asking != nullptr && asking->question()) {
    request.question = asking->question()->number;
  }
  peer.user = co_await parts_.callers.name_of(peer);
  auto live = parts_.use.running();
  if (!live) co_return fail(live.error());
  Run& run = **live;
  const std::int64_t number = run.progress().run;
  if (!run.question() && !parts_.person.prompt().empty()) {
    co_return fail(Errc::invalid_request,
                   "run {} waits for a confirmation, not for an answer: `lcrig confirm`", number);
  }
  if (!run.question() && run.progress().state == RunState::paused) {
    co_return fail(
        Errc::invalid_request,
        "run {} is paused and waits for no answer: `lcrig resume`; what it asked it asks "
        "again then",
        number);
  }
  auto answered = run.answer(request.value, peer.user, request.question);
  if (!answered) co_return fail(answered.error());
  answered->run = number;
  parts_.callers.note("run.answer", peer);
  auto stored = co_await parts_.recorder->flush();
  if (!stored) co_return fail(stored.error());
  co_return answered;
}

}  // namespace lcrig
