// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/kinds.hpp"

#include "drivers/faults/script.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {

namespace {

using namespace fault_parameter;
using F = Fault;
using Scene = FaultScene;
using Meter = lcr6100::SimFaults;
using Frame = ZwickSimFaults;
using Lies = ZwickSimLies;
using T = FaultTarget;
using S = FaultShape;
using O = FaultOccasion;
using L = LineFault::Kind;

// These set a member to true, or to a parameter's value, while the fault lasts.
template <bool Meter::* member>
void meter(const F&, bool on, const Scene& scene) {
  scene.bench.break_meter([on](Meter& m) { m.*member = on; });
}
template <double Meter::* member, double F::* parameter, int healthy>
void meter(const F& f, bool on, const Scene& scene) {
  scene.bench.break_meter([&](Meter& m) { m.*member = on ? f.*parameter : healthy; });
}
template <bool Frame::* member>
void frame(const F&, bool on, const Scene& scene) {
  scene.bench.break_frame([on](Frame& m) { m.*member = on; });
}
template <double Frame::* member, double F::* parameter>
void frame(const F& f, bool on, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.*member = on ? f.*parameter : 0; });
}
template <bool Lies::* member>
void lie(const F&, bool on, const Scene& scene) {
  scene.bench.break_frame([on](Frame& m) { m.lies.*member = on; });
}
template <double Lies::* member, double F::* parameter, int healthy = 0>
void lie(const F& f, bool on, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.lies.*member = on ? f.*parameter : healthy; });
}
template <void (FaultSurroundings::*set)(bool)>
void around(const F&, bool on, const Scene& scene) {
  if (scene.around != nullptr) (scene.around->*set)(on);
}

void say_unasked(const F& f, bool, const Scene& scene) {
  scene.bench.say_unasked(f.text);
}
void unplug_meter(const F& f, bool on, const Scene& scene) {
  on ? scene.bench.unplug_meter() : scene.bench.plug_meter(f.other_port);
}
void power_meter(const F&, bool on, const Scene& scene) {
  if (on) return scene.bench.unplug_meter();
  scene.bench.power_meter(scene.first_identity);
  scene.bench.plug_meter();
}
void restart_meter(const F&, bool on, const Scene& scene) {
  if (!on) scene.bench.power_meter(scene.first_identity);
  scene.bench.break_meter([on](Meter& m) { m.off = on; });
}
void turn_meter(const F& f, bool on, const Scene& scene) {
  scene.bench.turn_meter(f.setting, on ? f.to : "");
}
void other_meter(const F& f, bool on, const Scene& scene) {
  scene.bench.unplug_meter();
  scene.bench.power_meter(on ? f.identity : scene.first_identity);
  scene.bench.plug_meter();
}
void unplug_frame(const F& f, bool on, const Scene& scene) {
  on ? scene.bench.unplug_frame() : scene.bench.plug_frame(f.other_port);
}
void power_frame(const F&, bool on, const Scene& scene) {
  if (on) return scene.bench.unplug_frame();
  scene.bench.power_frame();
  scene.bench.plug_frame();
}
void lose_samples(const F& f, bool, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.lose_samples = f.samples; });
}
void jump_clock(const F& f, bool, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.clock_jump_s += f.jump_s; });
}
void spike(const F& f, bool, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.spike_N = f.force_N, m.spike_samples = f.samples; });
}
void stall(const F&, bool, const Scene& scene) {
  scene.bench.stall_frame();
}
void restart_gateway(const F& f, bool, const Scene& scene) {
  scene.bench.restart_gateway(f.forgets_zero);
}
void creep(const F& f, bool on, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.lies.creep_m_s = on ? f.speed_um_s * 1e-6 : 0; });
}
void freeze_clock(const F&, bool on, const Scene& scene) {
  scene.bench.break_frame([on](Frame& m) { m.lies.clock_rate = on ? 0 : 1; });
}
void lose_tare(const F& f, bool, const Scene& scene) {
  scene.bench.break_frame([&](Frame& m) { m.lose_tare = true, m.tell_origin = f.origin_changes; });
}
void change_caps(const F&, bool, const Scene& scene) {
  scene.bench.break_frame([](Frame& m) { m.lies.other_caps = true; });
  scene.bench.restart_gateway(false);
}
void send_operator_away(const F&, bool on, const Scene& scene) {
  scene.bench.set_operator_absent(on);
}
void slow_disk(const F& f, bool on, const Scene& scene) {
  if (scene.around != nullptr) scene.around->set_disk_delay(from_seconds(on ? f.delay_s : 0));
}
void step_wall_clock(const F& f, bool, const Scene& scene) {
  if (scene.around != nullptr) scene.around->step_wall_clock(from_seconds(f.step_s));
}

// lint: table
constexpr FaultKind kKinds[] = {
    {T::meter, "reply_late", S::counted, kDelay, nullptr, O::answer, L::delay},
    {T::meter, "reply_lost", S::counted, 0, nullptr, O::answer, L::drop},
    {T::meter, "reply_cut", S::counted, 0, nullptr, O::answer, L::cut},
    {T::meter, "reply_doubled", S::counted, 0, nullptr, O::answer, L::twice},
    {T::meter, "reply_garbled", S::counted, 0, nullptr, O::answer, L::garble},
    {T::meter, "reply_echoed", S::counted, 0, nullptr, O::answer, L::echo},
    {T::meter, "set_lost", S::counted, 0, nullptr, O::set},
    {T::meter, "unsolicited", S::once, kText, say_unasked},
    {T::meter, "stuck", S::lasting, 0, meter<&Meter::stuck>},
    {T::meter, "overload", S::lasting, 0, meter<&Meter::overload>},
    {T::meter, "slow", S::lasting, kFactor, meter<&Meter::slow_factor, &F::factor, 1>},
    {T::meter, "line_noise", S::lasting, kBytes,
     meter<&Meter::byte_noise, &F::byte_probability, 0>},
    {T::meter, "silent", S::lasting, 0, meter<&Meter::silent>},
    {T::meter, "unplug", S::lasting, kOtherPort, unplug_meter},
    {T::meter, "power_cycle", S::lasting, 0, power_meter},
    {T::meter, "restart_behind_port", S::lasting, kNeedsEnd, restart_meter},
    {T::meter, "panel_change", S::lasting, kPanel, turn_meter},
    {T::meter, "setting_takes_effect_late", S::lasting, kDelay,
     meter<&Meter::late_settings_s, &F::delay_s, 0>},
    {T::meter, "other_instrument", S::lasting, kIdentity, other_meter},
    {T::frame, "line_late", S::counted, kDelay, nullptr, O::transmission, L::delay},
    {T::frame, "line_lost", S::counted, 0, nullptr, O::transmission, L::drop},
    {T::frame, "line_cut", S::counted, 0, nullptr, O::transmission, L::cut},
    {T::frame, "line_doubled", S::counted, 0, nullptr, O::transmission, L::twice},
    {T::frame, "line_garbled", S::counted, 0, nullptr, O::transmission, L::garble},
    {T::frame, "refusal", S::counted, kCode, nullptr, O::command},
    {T::frame, "completion_lost", S::counted, 0, nullptr, O::completion},
    {T::frame, "samples_lost", S::once, kSamples, lose_samples},
    {T::frame, "clock_jump", S::once, kJump, jump_clock},
    {T::frame, "force_spike", S::once, kForce | kSamples, spike},
    {T::frame, "stall", S::once, 0, stall},
    {T::frame, "overshoot", S::lasting, kDelay, frame<&Frame::late_stop_s, &F::delay_s>},
    {T::frame, "heartbeat_lost", S::lasting, 0, frame<&Frame::no_heartbeats>},
    {T::frame, "gateway_restarted", S::once, kForgets, restart_gateway},
    {T::frame, "line_noise", S::lasting, kBytes, frame<&Frame::byte_noise, &F::byte_probability>},
    {T::frame, "silent", S::lasting, 0, frame<&Frame::silent>},
    {T::frame, "deaf", S::lasting, 0, frame<&Frame::deaf>},
    {T::frame, "unplug", S::lasting, kOtherPort, unplug_frame},
    {T::frame, "power_cycle", S::lasting, 0, power_frame},
    {T::frame, "force_frozen", S::lasting, 0, lie<&Lies::force_frozen>},
    {T::frame, "force_held", S::lasting, 0, lie<&Lies::force_held>},
    {T::frame, "force_gain", S::lasting, kGain, lie<&Lies::force_gain, &F::factor, 1>},
    {T::frame, "force_reversed", S::lasting, 0, lie<&Lies::force_reversed>},
    {T::frame, "force_drift", S::lasting, kRate, lie<&Lies::force_drift_N_s, &F::rate_N_s>},
    {T::frame, "force_scatter", S::lasting, kFactor, lie<&Lies::force_scatter, &F::factor, 1>},
    {T::frame, "drive_reversed", S::lasting, 0, lie<&Lies::drive_reversed>},
    {T::frame, "creep", S::lasting, kSpeed, creep},
    {T::frame, "done_early", S::lasting, 0, lie<&Lies::done_early>},
    {T::frame, "done_unmoved", S::lasting, 0, lie<&Lies::done_unmoved>},
    {T::frame, "done_late", S::lasting, kDelay, lie<&Lies::done_late_s, &F::delay_s>},
    {T::frame, "order_late", S::lasting, kDelay, lie<&Lies::order_late_s, &F::delay_s>},
    {T::frame, "clock_frozen", S::lasting, 0, freeze_clock},
    {T::frame, "clock_rate", S::lasting, kGain, lie<&Lies::clock_rate, &F::factor, 1>},
    {T::frame, "tare_lost", S::once, kOrigin, lose_tare},
    {T::frame, "estop", S::lasting, 0, lie<&Lies::estop>},
    {T::frame, "stop_late", S::lasting, kDelay, lie<&Lies::stop_late_s, &F::delay_s>},
    {T::frame, "stop_unconfirmed", S::lasting, 0, lie<&Lies::stop_unconfirmed>},
    {T::frame, "stop_ignored", S::lasting, 0, lie<&Lies::stop_ignored>},
    {T::frame, "stop_pretended", S::lasting, 0, lie<&Lies::stop_pretended>},
    {T::frame, "stop_silences", S::lasting, 0, lie<&Lies::stop_silences>},
    {T::frame, "caps_changed", S::once, 0, change_caps},
    {T::bench, "operator_absent", S::lasting, kNeedsEnd, send_operator_away},
    {T::bench, "disk_full", S::lasting, 0, around<&FaultSurroundings::set_disk_full>},
    {T::bench, "disk_read_only", S::lasting, 0, around<&FaultSurroundings::set_disk_read_only>},
    {T::bench, "disk_slow", S::lasting, kDelay, slow_disk},
    {T::bench, "wall_clock_step", S::once, kStep, step_wall_clock},
    {T::bench, "memory_short", S::lasting, 0, around<&FaultSurroundings::set_memory_short>},
};

}  // namespace

std::span<const FaultKind> fault_kinds() {
  return kKinds;
}

}  // namespace lcrig
