// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/known.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/text.hpp"

namespace lcrig {

namespace {

// Absent: nothing answers at the port. Fault: something answers, but with an error.
InstrumentCondition condition_after(const Error& error) {
  switch (error.code) {
    case Errc::disconnected:
    case Errc::no_reply: return InstrumentCondition::absent;
    case Errc::unsupported: return InstrumentCondition::unasked;
    default: return InstrumentCondition::fault;
  }
}

std::string words(InstrumentCondition condition, const std::string& why) {
  std::string out(to_string(condition));
  return why.empty() ? out : out + ": " + printable(why);
}

}  // namespace

void KnownRig::declare(Instrument which, std::string port, std::string why_unasked,
                       bool simulated) {
  Known& known = of(which);
  known.declared = true;
  known.state.which = which;
  known.state.port = std::move(port);
  known.state.why = std::move(why_unasked);
  known.state.simulated = known.on_simulated_rig = simulated;
}

// The journal reports a change, except during a run, which reports its losses itself.
void KnownRig::learn(Instrument which, InstrumentCondition condition, std::string why,
                     const Learned& from) {
  Known& known = of(which);
  InstrumentState& state = known.state;
  const MonoTime now = clock_.now();
  const bool news = condition != state.condition || why != state.why;
  if (news && known.declared && from.by != LearnedBy::run) {
    spdlog::info("{}: {}", to_string(which), words(condition, why));
  }
  if (condition != state.condition || !known.since) known.since = now;
  if (condition == InstrumentCondition::ready) known.port_there = true;
  state.condition = condition;
  state.why = std::move(why);
  state.learned_by = from.by;
  state.run = from.run;
  known.asked = now;
}

void KnownRig::answered(Instrument which, const Identity& identity, const Learned& from) {
  Known& known = of(which);
  if (!identity.text.empty()) {
    known.state.identity = identity.text;
    known.state.simulated = identity.simulated || known.on_simulated_rig;
  }
  learn(which, InstrumentCondition::ready, "", from);
}

void KnownRig::learned(Instrument which, const Result<Identity>& answer, const Learned& from) {
  if (answer) return answered(which, *answer, from);
  failed(which, answer.error(), from);
}

void KnownRig::failed(Instrument which, const Error& error, const Learned& from) {
  learn(which, condition_after(error), error.what, from);
}

void KnownRig::stated(const FrameCapabilities& counted) {
  InstrumentState& frame = of(Instrument::frame).state;
  frame.statements_known = true;
  frame.unstated = missing_statements(counted);
}

void KnownRig::cannot_state(const StatedFrame& by_person) {
  if (of(Instrument::frame).state.statements_known) return;
  FrameCapabilities able;  // to do whatever a person may have to state something for
  able.motion = able.force_hold = true;
  stated(count_the_worse(able, by_person).capabilities);
}

void KnownRig::confirmed(Instrument which, const Learned& from) {
  learn(which, InstrumentCondition::ready, "", from);
}

void KnownRig::heard(Instrument which) {
  Known& known = of(which);
  if (known.state.condition == InstrumentCondition::ready) known.asked = clock_.now();
}

bool KnownRig::set_port_there(Instrument which, bool there) {
  Known& known = of(which);
  if (there == known.port_there) return false;
  known.port_there = there;
  if (there) {
    spdlog::info("{}: its port {} is there again", to_string(which), known.state.port);
    known.state.condition = InstrumentCondition::unasked;
    known.state.why = "its port came back, and nobody has asked since";
    known.state.learned_by = LearnedBy::port;
    known.state.run.reset();
    known.asked.reset();
    known.since = clock_.now();
  } else {
    spdlog::warn("{}: its port {} went away", to_string(which), known.state.port);
    const bool absent = known.state.condition == InstrumentCondition::absent;
    known.gone = absent ? known.since : clock_.now();
  }
  return true;
}

bool KnownRig::is_ready(Instrument which) const {
  const Known& known = of(which);
  return known.port_there && known.state.condition == InstrumentCondition::ready;
}

bool KnownRig::is_known(Instrument which) const {
  const Known& known = of(which);
  return known.asked || !known.port_there;
}

InstrumentState KnownRig::state_of(const Known& known, std::optional<std::int64_t> run) const {
  const MonoTime now = clock_.now();
  InstrumentState out = known.state;
  auto since = known.since;
  if (!known.port_there) {
    out.condition = InstrumentCondition::absent;
    out.why = "its port is not there";
    out.learned_by = LearnedBy::port;
    out.run.reset();
    since = known.gone;
  } else if (run && out.condition == InstrumentCondition::ready) {
    out.condition = InstrumentCondition::in_use;
    out.run = run;
  }
  if (known.asked) out.age_s = to_seconds(now - *known.asked);
  if (since) out.since_s = to_seconds(now - *since);
  return out;
}

std::vector<InstrumentState> KnownRig::states(std::optional<std::int64_t> run) const {
  std::vector<InstrumentState> out;
  for (const Known& known : known_) {
    if (known.declared) out.push_back(state_of(known, run));
  }
  return out;
}

}  // namespace lcrig
