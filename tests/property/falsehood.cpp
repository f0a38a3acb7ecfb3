// SPDX-License-Identifier: Apache-2.0
#include "tests/property/falsehood.hpp"

#include <stdexcept>

namespace lcrig::property {

namespace {

using Words = std::vector<std::string_view>;

struct Row {
  FrameLie lie;
  std::string_view name;
  Distrust distrust;
  Words words;
};

const std::vector<Row>& rows() {
  using enum FrameLie;
  // The device or the guard may be the first to stop, so their words count as well, and so does a
  // force that pulls.
  static const Words kForce{"against the command", "falls w",     "zero",  "frozen",
                            "outside the limits",  "force limit", "pulls", "does not follow"};
  static const Words kHeld{"does not follow", "falls w", "at once", "jumped"};
  static const Words kDone{"DONE", "without a command", "does not move"};
  static const Words kStop{"standstill", "STOP"};
  static const Words kNothing{};
  static const std::vector<Row> kRows{
      {force_frozen, "force_frozen", Distrust::force, {"frozen", "does not follow"}},
      {force_held, "force_held", Distrust::force, kHeld},
      {force_gain, "force_gain", Distrust::force, kHeld},
      {force_reversed, "force_reversed", Distrust::force, kForce},
      {force_drift, "force_drift", Distrust::nobody, kNothing},
      {force_scatter, "force_scatter", Distrust::nobody, kNothing},
      {tare_lost, "tare_lost", Distrust::force, {"zero", "tare"}},
      {stall, "stall", Distrust::drive, {"does not move"}},
      {drive_reversed, "drive_reversed", Distrust::drive, {"against the command"}},
      {creep, "creep", Distrust::gateway, {"without a command"}},
      {estop, "estop", Distrust::drive, {"E-stop", "fault"}},
      {done_early, "done_early", Distrust::gateway, kDone},
      {done_unmoved, "done_unmoved", Distrust::gateway, kDone},
      {done_late, "done_late", Distrust::drive, {"does not move", "DONE"}},
      {order_late, "order_late", Distrust::drive, {"does not move", "without a command"}},
      {stop_late, "stop_late", Distrust::drive, kStop},
      {stop_unconfirmed, "stop_unconfirmed", Distrust::drive, kStop},
      {stop_ignored, "stop_ignored", Distrust::drive, kStop},
      {clock_rate, "clock_rate", Distrust::nobody, kNothing},
      {clock_jump, "clock_jump", Distrust::nobody, kNothing},
      {samples_late, "samples_late", Distrust::nobody, kNothing},
      {restart_untared, "restart_untared", Distrust::force, {"zero", "restart", "tare"}},
      {caps_changed, "caps_changed", Distrust::drive, {"capabilities"}},
  };
  return kRows;
}

const Row& row_of(FrameLie lie) {
  return rows().at(static_cast<std::size_t>(lie));
}

// Delays every transmission by this time.
ZwickSimHooks lateness(double seconds) {
  ZwickSimHooks hooks;
  if (seconds > 0) {
    hooks.sends = [d = from_seconds(seconds)] { return LineFault(LineFault::Kind::delay, d); };
  }
  return hooks;
}

void set_lie(ZwickSimLies& l, const Falsehood& f, bool on) {
  using enum FrameLie;
  const double value = on ? f.value : 0;
  switch (f.what) {
    case force_frozen: l.force_frozen = on; return;
    case force_held: l.force_held = on; return;
    case force_gain: l.force_gain = on ? f.value : 1; return;
    case force_reversed: l.force_reversed = on; return;
    case force_drift: l.force_drift_N_s = value; return;
    case force_scatter: l.force_scatter = on ? f.value : 1; return;
    case drive_reversed: l.drive_reversed = on; return;
    case creep: l.creep_m_s = value; return;
    case estop: l.estop = on; return;
    case done_early: l.done_early = on; return;
    case done_unmoved: l.done_unmoved = on; return;
    case done_late: l.done_late_s = value; return;
    case order_late: l.order_late_s = value; return;
    case stop_late: l.stop_late_s = value; return;
    case stop_unconfirmed: l.stop_unconfirmed = on; return;
    case stop_ignored: l.stop_ignored = on; return;
    case clock_rate: l.clock_rate = on ? f.value : 1; return;
    case caps_changed: l.other_caps = on; return;
    default: return;
  }
}

}  // namespace

std::string_view to_string(FrameLie lie) {
  return row_of(lie).name;
}
Distrust distrust_of(FrameLie lie) {
  return row_of(lie).distrust;
}
const Words& words_of(FrameLie lie) {
  return row_of(lie).words;
}

FrameLie lie_of(std::string_view name) {
  for (const Row& r : rows()) {
    if (r.name == name) return r.lie;
  }
  throw std::runtime_error("no lie " + std::string(name));
}

Falsehood draw_falsehood(Dice& dice, FrameLie what, const sim::RandomRig& rig) {
  using enum FrameLie;
  Falsehood f;
  f.what = what;
  draw_instant(dice, f);
  if (dice.below(10) < 7) {  // most lies are told early, while there is still something to press
    f.when = RigWorld::Act::When::drive;
    f.n = dice.below(5);
    f.after_s = dice.even(0, 1) * dice.even(0, 3);
  }
  // These show only against a measured contact, so they begin after the search and its steps back.
  if (what == force_held || what == force_gain) f.n += 4 + dice.below(10);
  const double side = dice.below(2) == 0 ? -1 : 1;
  const double delay_s = dice.scale(0.2, 10);
  const bool passes = dice.below(4) == 0;
  if (passes) f.lasts_s = dice.scale(0.5, 20);
  switch (what) {
    case force_gain: f.value = dice.below(2) == 0 ? 0 : dice.scale(0.01, 0.9); break;
    case force_drift: f.value = side * dice.scale(0.002, 1) * rig.limit_N; break;
    case force_scatter: f.value = dice.scale(2, 100); break;
    case creep: f.value = side * dice.scale(0.5e-6, 50e-6); break;
    case done_late: f.value = delay_s; break;
    // Shorter ones are rarely told: the watch waits for twice its stall time.
    case order_late: f.value = 2 * delay_s; break;
    case stop_late: f.value = dice.scale(0.2, 5); break;
    case samples_late: f.value = dice.scale(0.05, 0.9); break;
    case clock_rate: f.value = dice.below(2) == 0 ? 0 : dice.scale(0.3, 3); break;
    case clock_jump: f.value = side * dice.scale(0.1, 100); break;
    case tare_lost: f.value = dice.below(2) == 0 ? 1 : 0; break;
    case estop: f.lasts_s = dice.below(2) == 0 ? 0 : dice.scale(0.05, 2); break;
    default: break;
  }
  return f;
}

void begin_lie(RigWorld& w, const Falsehood& f) {
  using enum FrameLie;
  FaultBench& bench = w.bench();
  if (f.what == stall) return bench.stall_frame();
  if (f.what == restart_untared) return bench.restart_gateway(true);
  if (f.what == samples_late) return bench.hook_frame(lateness(f.value));
  bench.break_frame([&f](ZwickSimFaults& faults) {
    if (f.what == clock_jump) faults.clock_jump_s += f.value;
    if (f.what == tare_lost) faults.lose_tare = true, faults.tell_origin = f.value > 0;
    set_lie(faults.lies, f, true);
  });
  if (f.what == caps_changed) bench.restart_gateway(false);
}

void end_lie(RigWorld& w, const Falsehood& f) {
  if (f.what == FrameLie::samples_late) return w.bench().hook_frame(ZwickSimHooks());
  if (f.what == FrameLie::caps_changed) return;
  w.bench().break_frame([&f](ZwickSimFaults& faults) { set_lie(faults.lies, f, false); });
}

}  // namespace lcrig::property
