// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/player.hpp"

#include <spdlog/spdlog.h>
#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "base/text.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {

FaultPlayer::FaultPlayer(asio::any_io_executor executor, Clock& clock, FaultBench& bench,
                         FaultSurroundings* surroundings, FaultScript script, Told told)
    : executor_(std::move(executor)),
      clock_(clock),
      bench_(bench),
      surroundings_(surroundings),
      script_(std::move(script)),
      told_(std::move(told)),
      random_(script_.seed),
      first_identity_(bench.meter_identity()),
      changed_(clock) {
  for (const Fault& f : script_.faults) states_.emplace_back(f);
  attach();
}

FaultPlayer::~FaultPlayer() {
  bench_.hook_meter(lcr6100::SimHooks());
  bench_.hook_frame(ZwickSimHooks());
}

void FaultPlayer::attach() {
  lcr6100::SimHooks meter;
  meter.answer = [this] { return next_line(FaultOccasion::answer); };
  meter.loses_set = [this] { return counted_event(FaultOccasion::set) != nullptr; };
  bench_.hook_meter(std::move(meter));
  ZwickSimHooks frame;
  frame.sends = [this] { return next_line(FaultOccasion::transmission); };
  frame.refuses = [this] {
    const Fault* f = counted_event(FaultOccasion::command);
    return f != nullptr ? f->code : std::string();
  };
  frame.loses_done = [this] { return counted_event(FaultOccasion::completion) != nullptr; };
  bench_.hook_frame(std::move(frame));
}

LineFault FaultPlayer::next_line(FaultOccasion occasion) {
  const Fault* f = counted_event(occasion);
  return f != nullptr ? LineFault(f->kind->line, from_seconds(f->delay_s)) : LineFault();
}

// Every fault of this occasion counts the event. The first one that is due happens.
const Fault* FaultPlayer::counted_event(FaultOccasion occasion) {
  if (stopped_) return nullptr;
  State* chosen = nullptr;
  for (State& s : states_) {
    if (s.fault->kind->counts != occasion) continue;
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

// Each occurrence of a counted fault becomes an event of the run, but only the first is logged.
void FaultPlayer::happen(State& s) {
  ++s.fired;
  const std::string text = describe(*s.fault);
  const bool quiet = s.fault->is(FaultShape::counted) && s.fired > 1;
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
    changed_.notify_all();
    if (error) std::rethrow_exception(error);
  });
}

Task<bool> FaultPlayer::ended(MonoTime limit) {
  return changed_.wait([this] { return !running_; }, limit);
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
    if (s.fault->is(FaultShape::counted)) s.open = false;
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
  const bool counted = f.is(FaultShape::counted);
  const bool spent = f.times && s.fired >= *f.times;
  if (spent || (s.open && f.is(FaultShape::lasting))) return;
  s.open = !f.is(FaultShape::once);
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
  if (!s.fault->is(FaultShape::lasting)) return;
  act(*s.fault, false);
  const std::string text = describe(*s.fault) + ": over";
  spdlog::info("fault injected: {}", printable(text));
  told_(clock_.now(), text);
}

void FaultPlayer::stop() {
  if (std::exchange(stopped_, true)) return;
  for (State& s : states_) {
    if (s.open && s.fault->is(FaultShape::lasting)) act(*s.fault, false);
    s.open = false;
    if (s.fired == 0) {
      spdlog::warn("{}: {} never happened: its time, step or event did not come", s.fault->where,
                   s.fault->kind->name);
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
  const FaultScene scene{bench_, surroundings_, first_identity_};
  fault.kind->act(fault, on, scene);
}

}  // namespace lcrig
