// SPDX-License-Identifier: Apache-2.0
// Stops and pauses that wait for the end of what is under way.
#include <fmt/format.h>

#include <utility>

#include "daemon/app.hpp"
#include "daemon/control/audit.hpp"

namespace lcrig {

namespace {

using Kind = PlannedStops::Kind;

std::string at_words(const PlannedStop& stop) {
  return fmt::format("the end of the {} (step {})", place_words(stop.place), stop.step_id);
}

// The thing that the run waits for before it can go on to that end; empty: nothing.
std::string but_first(RunState state) {
  switch (state) {
    case RunState::paused: return "; it is paused, and goes on with `lcrig resume`";
    case RunState::waiting_for_operator:
      return "; it waits for a person first: `lcrig status` says for what";
    case RunState::waiting_for_instrument: return "; it waits for an instrument first";
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

}  // namespace

Task<Result<StopAnswer>> App::ask_at(PlannedStops::Kind kind, StopPlace place, std::string why,
                                     PeerCredentials peer) {
  peer.user = co_await user_name(peer, kNamePatienceOfStops);
  Run* run = live_run();
  if (run == nullptr && use_ == Use::starting) {
    co_return fail(Errc::invalid_request,
                   "the run is still being prepared: `lcrig abort` keeps it from beginning");
  }
  if (run == nullptr) co_return fail(Errc::invalid_request, "no run is going on");
  if (run->is_ending()) {
    co_return StopAnswer(StopState::finally,
                         "the run is ending already: `finally` runs, or is about to");
  }
  const std::string reason = why.empty() ? "by " + peer.user : why + " (by " + peer.user + ")";
  auto asked = run->ask_at(kind, place, reason);
  if (!asked) co_return fail(asked.error());
  const char* request = kind == Kind::stop ? "run.stop" : "run.pause";
  recorder_->event(request_event(clock_.now(), request, peer, why));
  co_return StopAnswer(StopState::later, words_of(kind, *asked, run->progress().state));
}

Task<Result<StopAnswer>> App::pause_at(StopPlace place, PeerCredentials peer) {
  co_return co_await ask_at(Kind::pause, place, std::string(), std::move(peer));
}

Task<Result<StopAnswer>> App::stop_after(StopPlace place, std::string why, PeerCredentials peer) {
  co_return co_await ask_at(Kind::stop, place, std::move(why), std::move(peer));
}

}  // namespace lcrig
