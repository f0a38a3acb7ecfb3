// SPDX-License-Identifier: Apache-2.0
// How the simulated gateway handles each line that it receives.
#include <algorithm>
#include <array>
#include <utility>

#include "drivers/zwick/sim.hpp"
#include "drivers/zwick/sim_clerk.hpp"
#include "drivers/zwick/sim_machine.hpp"

namespace lcrig {

namespace {

using frame_link::Line;
using frame_link::Order;
using frame_link::Refusal;
using frame_link::SimMachine;
using frame_link::Verdict;

Refusal syntax(const Error& error) {
  return Refusal("syntax", error.what);
}

Verdict set_limits(SimMachine& m, MonoTime, const Line& line) {
  const auto limits = frame_link::parse_limits(line);
  if (!limits) return syntax(limits.error());
  return m.set_limits(*limits);
}

Verdict move(SimMachine& m, MonoTime t, const Line& line) {
  const auto travel = frame_link::length_of(line, "travel_mm");
  const auto speed = frame_link::speed_of(line);
  if (!travel) return syntax(travel.error());
  if (!speed) return syntax(speed.error());
  return m.move(t, *line.number, travel->si(), speed->si());
}

Verdict move_until(SimMachine& m, MonoTime t, const Line& line) {
  const auto force = frame_link::force_of(line);
  const auto speed = frame_link::speed_of(line);
  const auto guard = frame_link::length_of(line, "guard_mm");
  if (!force) return syntax(force.error());
  if (!speed) return syntax(speed.error());
  if (!guard) return syntax(guard.error());
  return m.move_until(t, *line.number, force->si(), speed->si(), guard->si());
}

Verdict ramp(SimMachine& m, MonoTime t, const Line& line) {
  const auto force = frame_link::force_of(line);
  const auto rate = line.number_of("rate_N_s");
  if (!force) return syntax(force.error());
  if (!rate) return syntax(rate.error());
  return m.ramp(t, *line.number, force->si(), *rate);
}

Verdict hold(SimMachine& m, MonoTime t, const Line& line) {
  const auto mode = line.text("mode");
  if (mode == "travel") {
    m.halt(t, MotionEnd::stopped, "hold");
    return std::nullopt;
  }
  if (mode != "force") return Refusal("syntax", "HOLD takes mode=travel or mode=force");
  const auto force = frame_link::force_of(line);
  if (!force) return syntax(force.error());
  return m.hold_force(t, force->si());
}

Verdict zero(SimMachine& m, MonoTime t, const Line& line) {
  return m.zero(t, line.flag("force"), line.flag("travel"));
}

using Handler = Verdict (*)(SimMachine&, MonoTime, const Line&);
// The order of a motion command; nullopt for a command without DONE.
std::optional<Order> order_of(SimMachine& m, const Line& line, std::string_view text,
                              Handler handler) {
  if (line.word != "MOVE" && line.word != "MOVEF" && line.word != "RAMPF") return std::nullopt;
  Order order;
  order.number = *line.number;
  const auto travel = frame_link::length_of(line, "travel_mm");
  const auto force = frame_link::force_of(line);
  if (travel) order.travel_m = travel->si();
  if (force) order.force_N = force->si();
  order.carry_out = [&m, words = std::string(text), handler](MonoTime t) {
    return handler(m, t, frame_link::parse_line(words).value());
  };
  return order;
}

constexpr std::array<std::pair<std::string_view, Handler>, 6> kHandlers{{
    {"LIMITS", set_limits},
    {"MOVE", move},
    {"MOVEF", move_until},
    {"RAMPF", ramp},
    {"HOLD", hold},
    {"ZERO", zero},
}};

}  // namespace

std::string ZwickSim::hello() const {
  frame_link::Hello hello;
  hello.side = "gateway";
  hello.identity.maker = "lcrig";
  hello.identity.model = recording_ ? "frame recording" : "simulated frame";
  hello.identity.serial = settings_.serial;
  hello.identity.firmware = LCRIG_VERSION;
  hello.identity.simulated = true;
  hello.revision = settings_.revision;
  if (settings_.revision >= 2) hello.origin = machine_ ? machine_->origin() : "recording";
  return frame_link::format_hello(hello);
}

std::string ZwickSim::caps() const {
  FrameCapabilities caps;
  if (machine_) {
    caps = machine_->capabilities();
  } else {
    caps.sample_rate_max_Hz = settings_.rate_max_Hz;
    caps.deceleration = 0.05_m_s2;
  }
  if (settings_.revision < 2) caps.force_loop.reset();
  if (settings_.revision < 3) {
    caps.travel_step.reset();
    caps.force_step.reset();
    caps.filter.reset();
    caps.play.reset();
  }
  if (lies_.other_caps) caps.deceleration = caps.deceleration / 2;
  return frame_link::format_caps(caps);
}

void ZwickSim::begin_session(bool observer) {
  if (machine_) machine_->forget_command();
  session_ = true;
  observer_ = observer;
  watchdog_tripped_ = false;
  batch_.clear();
  out_.clear();
  answers_.clear();
  rate_Hz_ = 0;
  seq_ = 1;
  last_number_ = -1;
  stops_ = 0;
  stop_owed_ = false;
  stop_due_.reset();
  say(hello());
  say(caps());
}

void ZwickSim::open_session() {
  if (machine_) {
    clerk_->end_session();
    machine_->halt(clock_.now(), MotionEnd::stopped, "new session");
    machine_->disarm();
  }
  begin_session(false);
}

// A host with another protocol gets our HELLO but no session.
void ZwickSim::greet(const Line& line) {
  const auto hello = frame_link::parse_hello(line);
  if (!hello) return say(frame_link::format_event("syntax", hello.error().what));
  if (hello->protocol != frame_link::kProtocol) {
    if (session_ && !observer_) end_command("another protocol");
    session_ = false;
    return say(this->hello());
  }
  if (line.word == "HELLO") return open_session();
  observe(line);
}

// Changes nothing at the machine, except that it ends a session that may command.
void ZwickSim::observe(const Line& line) {
  if (session_ && !observer_) end_command("the daemon only observes from now on");
  begin_session(true);
  const auto hz = line.number_of("hz");
  start_samples(std::clamp(hz ? *hz : 0.0, 0.0, settings_.rate_max_Hz));
}

void ZwickSim::on_line(std::string_view text) {
  if (text.empty()) return;
  const MonoTime now = clock_.now();
  catch_up(now);
  const auto line = frame_link::parse_line(text);
  if (!line) {
    const auto number = frame_link::number_of_bad_line(text);
    say(number && session_ ? frame_link::format_err(*number, "syntax", line.error().what)
                           : frame_link::format_event("syntax", line.error().what));
    return;
  }
  if (line->word == "HB" && faults.no_heartbeats) return;
  heard_ = now;
  watchdog_tripped_ = false;
  if (line->word == "STOP") return on_stop();
  const bool observes = line->word == "OBSERVE" && settings_.revision >= 2;
  if (line->word == "HELLO" || observes) return greet(*line);
  if (line->word == "HB" || !session_) return;
  if (line->number) return on_command(*line, text);
  say(frame_link::format_event("unknown", line->word));
}

void ZwickSim::on_stop() {
  ++stops_;
  if (lies_.stop_ignored) return;
  silenced_ = lies_.stop_silences;
  if (silenced_) return;
  if (lies_.stop_pretended) {
    if (machine_) machine_->disown();
    return say_stopped();
  }
  stop_owed_ = true;
  if (clerk_) clerk_->stop(clock_.now());
  if (machine_) machine_->halt(clock_.now(), MotionEnd::stopped, "STOP");
  catch_up(clock_.now());
}

void ZwickSim::answer_stops() {
  stop_owed_ = false;
  stop_due_.reset();
  release_answers(MonoTime::max());
  flush();
  if (lies_.stop_unconfirmed) return;
  if (faults.lose_stopped > 0) {
    --faults.lose_stopped;
    return;
  }
  say_stopped();
}

void ZwickSim::say_stopped() {
  flush();
  MotionOutcome standing;
  if (machine_) {
    const FrameSample s = machine_->sample(clock_.now());
    standing.force_N = s.force_N;
    standing.travel_m = s.travel_m;
  }
  say(frame_link::format_stopped(stops_, standing));
}

void ZwickSim::on_command(const Line& line, std::string_view text) {
  Verdict no = Refusal("unknown_command", "no such command");
  const auto handler =
      std::ranges::find(kHandlers, line.word, [](const auto& h) { return h.first; });
  std::string refusal = std::exchange(faults.refuse_next, {});
  if (refusal.empty() && hooks.refuses) refusal = hooks.refuses();
  if (faults.not_ready && handler != kHandlers.end() && handler->second != zero) {
    refusal = "not_ready";
  }
  const bool in_order =
      *line.number > std::exchange(last_number_, std::max(last_number_, *line.number));
  if (!in_order) {
    no = Refusal("bad_value", "a number that is not larger than every one before");
  } else if (observer_) {
    no = Refusal("observer", "this session only observes");
  } else if (!refusal.empty()) {
    no = Refusal(std::move(refusal), "not now");
  } else if (line.word == "STATUS") {
    no.reset();
  } else if (line.word == "RATE") {
    return set_rate(line);
  } else if (handler != kHandlers.end() && !machine_) {
    no = Refusal("unsupported", "a recording is played: nothing moves");
  } else if (handler != kHandlers.end()) {
    auto order = order_of(*machine_, line, text, handler->second);
    no = order ? clerk_->take(clock_.now(), std::move(*order))
               : handler->second(*machine_, clock_.now(), line);
  }
  if (faults.lose_answers > 0) {
    --faults.lose_answers;
  } else if (no) {
    answer(frame_link::format_err(*line.number, no->code, no->text));
  } else if (line.word == "ZERO" && settings_.revision >= 2) {
    answer(frame_link::format_ok(*line.number, machine_->origin()));
  } else {
    answer(frame_link::format_ok(*line.number));
  }
  catch_up(clock_.now());
}

void ZwickSim::set_rate(const Line& line) {
  const auto hz = line.number_of("hz");
  if (!hz) return answer(frame_link::format_err(*line.number, "syntax", hz.error().what));
  if (*hz < 0) return answer(frame_link::format_err(*line.number, "bad_value", "a negative rate"));
  if (*hz > settings_.rate_max_Hz) {
    return answer(
        frame_link::format_err(*line.number, "machine_limits", "faster than rate_max_hz"));
  }
  flush();
  start_samples(*hz);
  answer(frame_link::format_ok(*line.number));
}

void ZwickSim::start_samples(double rate_Hz) {
  rate_Hz_ = rate_Hz;
  rate_start_ = clock_.now();
  rate_index_ = 1;
}

}  // namespace lcrig
