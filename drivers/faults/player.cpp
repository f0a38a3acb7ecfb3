// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/player.hpp"

#include <spdlog/spdlog.h>
#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "base/text.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {

namespace {

LineFault line_fault(const Fault& f) {
  using enum FaultKind;
  using Kind = LineFault::Kind;
  switch (f.kind) {
    case reply_late:
    case line_late: return LineFault(Kind::delay, from_seconds(f.delay_s));
    case reply_lost:
    case line_lost: return LineFault(Kind::drop);
    case reply_cut:
    case line_cut: return LineFault(Kind::cut);
    case reply_doubled:
    case line_doubled: return LineFault(Kind::twice);
    case reply_garbled:
    case line_garbled: return LineFault(Kind::garble);
    case reply_echoed: return LineFault(Kind::echo);
    default: return LineFault();
  }
}

}  // namespace

FaultPlayer::FaultPlayer(asio::any_io_executor executor, Clock& clock, FaultBench& bench,
                         FaultSurroundings* surroundings, FaultScript script, Told told)
    : executor_(std::move(executor)),
      clock_(clock),
      bench_(bench),
      surroundings_(surroundings),
      script_(std::move(script)),
      told_(std::move(told)),
      random_(script_.seed),
      first_identity_(bench.meter_identity()) {
  for (const Fault& f : script_.faults) states_.emplace_back(f);
  attach();
}

FaultPlayer::~FaultPlayer() {
  bench_.hook_meter(lcr6100::SimHooks());
  bench_.hook_frame(ZwickSimHooks());
}

void FaultPlayer::attach() {
  lcr6100::SimHooks meter;
  meter.answer = [this] { return next_answer(); };
  meter.loses_set = [this] { return counted_event({FaultKind::set_lost}) != nullptr; };
  bench_.hook_meter(std::move(meter));
  ZwickSimHooks frame;
  frame.sends = [this] { return next_transmission(); };
  frame.refuses = [this] {
    const Fault* f = counted_event({FaultKind::refusal});
    return f != nullptr ? f->code : std::string();
  };
  frame.loses_done = [this] { return counted_event({FaultKind::completion_lost}) != nullptr; };
  bench_.hook_frame(std::move(frame));
}

LineFault FaultPlayer::next_answer() {
  using enum FaultKind;
  const Fault* f = counted_event(
      {reply_late, reply_lost, reply_cut, reply_doubled, reply_garbled, reply_echoed});
  return f != nullptr ? line_fault(*f) : LineFault();
}

LineFault FaultPlayer::next_transmission() {
  using enum FaultKind;
  const Fault* f = counted_event({line_late, line_lost, line_cut, line_doubled, line_garbled});
  return f != nullptr ? line_fault(*f) : LineFault();
}

// Every fault of these kinds counts the event. The first one that is due happens.
const Fault* FaultPlayer::counted_event(std::initializer_list<FaultKind> kinds) {
  if (stopped_) return nullptr;
  State* chosen = nullptr;
  for (State& s : states_) {
    if (std::ranges::find(kinds, s.fault->kind) == kinds.end()) continue;
    if (is_due(s) && chosen == nullptr) chosen = &s;
  }
  if (chosen == nullptr) return nullptr;
  happen(*chosen);
  return chosen->fault;
}

bool FaultPlayer::is_due(State& s) {
  const Fault& f = *s.fault;
  if (f.has_window() && !s.open) return false;
  if (f.times && s.fired >= *f.times) return false;
  ++s.seen;
  if (f.every) return s.seen % *f.every == 0;
  if (!f.probability) return true;
  return static_cast<double>(random_() >> 11U) * 0x1p-53 < *f.probability;
}

// Every counted fault becomes an event of the run, but only its first occurrence a line in the log.
void FaultPlayer::happen(State& s) {
  ++s.fired;
  const std::string text = describe(*s.fault);
  const bool quiet = s.fault->shape == FaultShape::counted && s.fired > 1;
  spdlog::log(quiet ? spdlog::level::debug : spdlog::level::info, "fault injected: {}",
              printable(text));
  told_(clock_.now(), text);
}

void FaultPlayer::schedule(MonoTime at, Act act) {
  if (stopped_) return;
  agenda_.emplace(at, std::move(act));
  wakeup_.notify();
  if (std::exchange(running_, true)) return;
  asio::co_spawn(executor_, run(), [this](std::exception_ptr error) {
    running_ = false;
    if (error) std::rethrow_exception(error);
  });
}

Task<> FaultPlayer::run() {
  while (!stopped_) {
    const auto first = agenda_.begin();
    const MonoTime due = agenda_.empty() ? MonoTime::max() : first->first;
    if (due > clock_.now()) {
      co_await clock_.wait_until(due, wakeup_);
      continue;
    }
    const Act act = std::move(first->second);
    agenda_.erase(first);
    act();
  }
}

void FaultPlayer::begin() {
  for (State& s : states_) {
    if (!s.fault->at_s) continue;
    schedule(clock_.now() + from_seconds(*s.fault->at_s), [this, &s] { open(s); });
  }
}

// Counted faults end with their step. Lasting faults may go on after the step in which they began.
void FaultPlayer::enter_step(std::string_view id, std::string_view kind, bool finishing) {
  const std::uint64_t step = ++step_;
  for (State& s : states_) {
    const auto& wanted = s.fault->in_step;
    if (!wanted) continue;
    if (s.fault->shape == FaultShape::counted) s.open = false;
    if (*wanted != id && *wanted != kind && !(finishing && *wanted == "finally")) continue;
    if (s.fault->after_s <= 0) {
      open(s);  // before the step does anything
      continue;
    }
    schedule(clock_.now() + from_seconds(s.fault->after_s), [this, &s, step] {
      if (step_ == step) open(s);  // otherwise the step has already ended
    });
  }
}

void FaultPlayer::open(State& s) {
  const Fault& f = *s.fault;
  const bool counted = f.shape == FaultShape::counted;
  const bool spent = f.times && s.fired >= *f.times;
  if (spent || (s.open && f.shape == FaultShape::lasting)) return;
  s.open = f.shape != FaultShape::once;
  const std::int64_t serial = ++s.opened;
  if (!counted) {
    happen(s);
    act(f, true);
  }
  const MonoTime now = clock_.now();
  if (f.for_s) {
    schedule(now + from_seconds(*f.for_s), [this, &s, serial] {
      if (s.open && s.opened == serial) close(s);
    });
  }
  if (f.every_s && (!f.times || s.fired < *f.times)) {
    schedule(now + from_seconds(*f.every_s), [this, &s] { open(s); });
  }
}

void FaultPlayer::close(State& s) {
  s.open = false;
  if (s.fault->shape != FaultShape::lasting) return;
  act(*s.fault, false);
  const std::string text = describe(*s.fault) + ": over";
  spdlog::info("fault injected: {}", printable(text));
  told_(clock_.now(), text);
}

void FaultPlayer::stop() {
  if (std::exchange(stopped_, true)) return;
  for (State& s : states_) {
    if (s.open && s.fault->shape == FaultShape::lasting) act(*s.fault, false);
    s.open = false;
    if (s.fired == 0) {
      spdlog::warn("{}: {} never happened: its time, step or event did not come", s.fault->where,
                   s.fault->name);
    }
  }
  agenda_.clear();
  wakeup_.notify();
}

std::vector<std::int64_t> FaultPlayer::happened() const {
  std::vector<std::int64_t> out;
  out.reserve(states_.size());
  for (const State& s : states_) out.push_back(s.fired);
  return out;
}

void FaultPlayer::act(const Fault& fault, bool on) {
  switch (fault.on) {
    case FaultTarget::meter: return act_on_meter(fault, on);
    case FaultTarget::frame: return act_on_frame(fault, on);
    case FaultTarget::bench: return act_on_bench(fault, on);
  }
}

void FaultPlayer::act_on_meter(const Fault& f, bool on) {
  using enum FaultKind;
  const auto set = [&](auto change) { bench_.break_meter(change); };
  using Faults = lcr6100::SimFaults;
  switch (f.kind) {
    case stuck: return set([on](Faults& s) { s.stuck = on; });
    case overload: return set([on](Faults& s) { s.overload = on; });
    case meter_silent: return set([on](Faults& s) { s.silent = on; });
    case slow: return set([&](Faults& s) { s.slow_factor = on ? f.factor : 1; });
    case meter_noise: return set([&](Faults& s) { s.byte_noise = on ? f.byte_probability : 0; });
    case unsolicited: return bench_.say_unasked(f.text);
    case meter_unplug: return on ? bench_.unplug_meter() : bench_.plug_meter(f.other_port);
    case meter_power_cycle:
      if (on) return bench_.unplug_meter();
      bench_.power_meter(first_identity_);
      return bench_.plug_meter();
    case other_instrument:
      bench_.unplug_meter();
      bench_.power_meter(on ? f.identity : first_identity_);
      return bench_.plug_meter();
    default: return;
  }
}

void FaultPlayer::act_on_frame(const Fault& f, bool on) {
  using enum FaultKind;
  const auto set = [&](auto change) { bench_.break_frame(change); };
  using Faults = ZwickSimFaults;
  switch (f.kind) {
    case samples_lost: return set([&](Faults& s) { s.lose_samples = f.samples; });
    case clock_jump: return set([&](Faults& s) { s.clock_jump_s += f.jump_s; });
    case force_spike:
      return set([&](Faults& s) { s.spike_N = f.force_N, s.spike_samples = f.samples; });
    case stall: return bench_.stall_frame();
    case overshoot: return set([&](Faults& s) { s.late_stop_s = on ? f.delay_s : 0; });
    case heartbeat_lost: return set([on](Faults& s) { s.no_heartbeats = on; });
    case gateway_restarted: return bench_.restart_gateway(f.forgets_zero);
    case frame_noise: return set([&](Faults& s) { s.byte_noise = on ? f.byte_probability : 0; });
    case frame_silent: return set([on](Faults& s) { s.silent = on; });
    case deaf: return set([on](Faults& s) { s.deaf = on; });
    case frame_unplug: return on ? bench_.unplug_frame() : bench_.plug_frame(f.other_port);
    case frame_power_cycle:
      if (on) return bench_.unplug_frame();
      bench_.power_frame();
      return bench_.plug_frame();
    case tare_lost:
      return set([&](Faults& s) { s.lose_tare = true, s.tell_origin = f.origin_changes; });
    case caps_changed:
      set([](Faults& s) { s.lies.other_caps = true; });
      return bench_.restart_gateway(false);
    default: return lie(f, on);
  }
}

void FaultPlayer::lie(const Fault& f, bool on) {
  using enum FaultKind;
  const auto set = [&](auto change) {
    bench_.break_frame([&](ZwickSimFaults& s) { change(s.lies); });
  };
  using Lies = ZwickSimLies;
  switch (f.kind) {
    case force_frozen: return set([on](Lies& s) { s.force_frozen = on; });
    case force_held: return set([on](Lies& s) { s.force_held = on; });
    case force_gain: return set([&](Lies& s) { s.force_gain = on ? f.factor : 1; });
    case force_reversed: return set([on](Lies& s) { s.force_reversed = on; });
    case force_drift: return set([&](Lies& s) { s.force_drift_N_s = on ? f.rate_N_s : 0; });
    case force_scatter: return set([&](Lies& s) { s.force_scatter = on ? f.factor : 1; });
    case drive_reversed: return set([on](Lies& s) { s.drive_reversed = on; });
    case creep: return set([&](Lies& s) { s.creep_m_s = on ? f.speed_um_s * 1e-6 : 0; });
    case done_early: return set([on](Lies& s) { s.done_early = on; });
    case done_unmoved: return set([on](Lies& s) { s.done_unmoved = on; });
    case done_late: return set([&](Lies& s) { s.done_late_s = on ? f.delay_s : 0; });
    case order_late: return set([&](Lies& s) { s.order_late_s = on ? f.delay_s : 0; });
    case clock_frozen: return set([on](Lies& s) { s.clock_rate = on ? 0 : 1; });
    case clock_rate: return set([&](Lies& s) { s.clock_rate = on ? f.factor : 1; });
    case estop: return set([on](Lies& s) { s.estop = on; });
    case stop_late: return set([&](Lies& s) { s.stop_late_s = on ? f.delay_s : 0; });
    case stop_unconfirmed: return set([on](Lies& s) { s.stop_unconfirmed = on; });
    case stop_ignored: return set([on](Lies& s) { s.stop_ignored = on; });
    default: return;
  }
}

void FaultPlayer::act_on_bench(const Fault& f, bool on) {
  using enum FaultKind;
  if (f.kind == operator_absent) return bench_.set_operator_absent(on);
  if (surroundings_ == nullptr) return;
  switch (f.kind) {
    case disk_full: return surroundings_->set_disk_full(on);
    case disk_read_only: return surroundings_->set_disk_read_only(on);
    case disk_slow: return surroundings_->set_disk_delay(from_seconds(on ? f.delay_s : 0));
    case memory_short: return surroundings_->set_memory_short(on);
    case wall_clock_step: return surroundings_->step_wall_clock(from_seconds(f.step_s));
    default: return;
  }
}

}  // namespace lcrig
