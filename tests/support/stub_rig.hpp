// SPDX-License-Identifier: Apache-2.0
// Instruments that do what a test says, and a sink that keeps the events: for the parts of a run
// alone, without drivers and wires.
#pragma once

#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// Measures every 100 ms until it hangs.
class StubMeter final : public LcrMeter {
 public:
  explicit StubMeter(Clock& clock) : clock_(clock) {}
  bool hangs = false;
  int made_safe = 0;

  const LcrCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override { co_return Identity(); }
  Task<Result<LcrSettings>> configure(LcrSettings s) override { co_return s; }
  Task<Result<LcrReading>> measure() override {
    if (hangs) co_await clock_.wait_until(MonoTime::max());
    co_await clock_.wait_for(std::chrono::milliseconds(100));
    co_return LcrReading();
  }
  Task<Result<ReadBack>> read_back(MeterState) override { co_return ReadBack(); }
  Task<Result<Reconnected>> reconnect(MeterState wanted) override {
    co_return Reconnected(wanted.settings, ReadBack());
  }
  Task<Result<>> correct(CorrectionKind) override { co_return Result<>(); }
  Task<Result<>> resync() override { co_return Result<>(); }
  Task<Result<>> make_safe() override {
    ++made_safe;
    co_return Result<>();
  }
  void close() override {}

 private:
  Clock& clock_;
  LcrCapabilities capabilities_;
};

// Every command succeeds at once. When it hangs, a STOP is never confirmed.
class StubFrame final : public LoadFrame {
 public:
  explicit StubFrame(Clock& clock) : clock_(clock) {
    capabilities_.motion = true;
    capabilities_.force_max = Force::from_si(20);
    capabilities_.travel_max = Length::from_si(0.06);
    capabilities_.speed_max = Velocity::from_si(0.01);
    capabilities_.reaction = std::chrono::milliseconds(8);
    capabilities_.deceleration = Acceleration::from_si(0.2);
    capabilities_.device_stop = true;
    capabilities_.travel_step = Length::from_si(1e-9);
  }
  bool hangs = false;
  Result<> stop_says;
  Result<Identity> reconnect_says = Identity();
  MotionOutcome motion_says;  // a motion of the travel ends there instead of at its target
  double force_N = 0, travel_m = 0;  // shown in the samples
  std::function<double(double travel_m)> force_at;  // gives the force instead of `force_N`
  double digit_m = 0;  // step of the travel shown; 0: none
  double noise_N = 0;  // added to every other sample
  Duration sample_period = std::chrono::milliseconds(100);
  bool never_ends = false;  // motions do not end
  Duration motion_lasts{};
  std::optional<std::string> zero_of;  // origin
  std::vector<std::string> commands;  // those it was given

  FrameCapabilities& abilities() { return capabilities_; }
  const FrameCapabilities& capabilities() const override { return capabilities_; }
  std::optional<std::string> origin() const override { return zero_of; }
  Task<Result<Identity>> identify() override { co_return Identity(); }
  Task<Result<Identity>> observe(double) override { return identity_after("observe"); }
  Task<Result<Identity>> reconnect() override {
    commands.push_back("reconnect");
    co_return reconnect_says;
  }
  Task<Result<>> arm(FrameLimits) override { return done_after("arm"); }
  Task<Result<>> set_sample_rate(double) override { return done_after("rate"); }
  Task<Result<MotionOutcome>> move_to(Length to, Velocity) override {
    return moved_after("move_to", to.si());
  }
  Task<Result<MotionOutcome>> move_until_force(Force force, Velocity, Length guard) override {
    return moved_after("move_until_force", place_of(force, guard));
  }
  Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate) override {
    return moved_after("ramp_force", place_of(force, capabilities_.travel_max));
  }
  Task<Result<>> hold_travel() override { return done_after("hold_travel"); }
  Task<Result<>> hold_force(Force) override { return done_after("hold_force"); }
  Task<Result<>> zero(bool, bool) override { return done_after("zero"); }
  Task<Result<MotionOutcome>> place_mass(Mass) override {
    return moved_after("place_mass", travel_m);
  }
  Task<Result<>> stop() override {
    commands.push_back("stop");
    if (hangs) co_await clock_.wait_until(MonoTime::max());
    co_return stop_says;
  }
  Task<Result<>> resync() override { co_return Result<>(); }
  void close() override {}
  void set_listener(Listener* listener) override { listener_ = listener; }

  FrameSample sample() {
    FrameSample s;
    s.force_N = felt_N() + (++samples_ % 2 == 0 ? noise_N : 0);
    s.travel_m = shown_m();
    s.received = clock_.now();
    return s;
  }
  // Samples keep coming even when it hangs.
  Task<> send_samples() {
    for (;;) {
      co_await clock_.wait_for(sample_period);
      const FrameSample s = sample();
      if (listener_ != nullptr) listener_->on_samples(std::span(&s, 1));
    }
  }

 private:
  Task<Result<>> done_after(const char* command) {
    commands.emplace_back(command);
    co_return Result<>();
  }
  Task<Result<Identity>> identity_after(const char* command) {
    commands.emplace_back(command);
    co_return Identity();
  }
  double place_of(Force force, Length end) const {
    double to_m = travel_m;
    constexpr double kStep_m = 1e-7;
    while (force_at && force_at(to_m) < force.si() && to_m < end.si()) to_m += kStep_m;
    return to_m;
  }
  double shown_m() const {
    return digit_m > 0 ? std::round(travel_m / digit_m) * digit_m : travel_m;
  }
  double felt_N() const { return force_at ? force_at(travel_m) : force_N; }
  Task<Result<MotionOutcome>> moved_after(const char* command, double to_m) {
    commands.emplace_back(command);
    if (never_ends) co_await clock_.wait_until(MonoTime::max());
    if (motion_lasts > Duration::zero()) co_await clock_.wait_for(motion_lasts);
    MotionOutcome outcome = motion_says;
    travel_m = motion_says.travel_m.value_or(to_m);
    outcome.travel_m = shown_m();
    outcome.force_N = felt_N();
    co_return outcome;
  }

  Clock& clock_;
  FrameCapabilities capabilities_;
  Listener* listener_ = nullptr;
  std::int64_t samples_ = 0;
};

class EventSink final : public RunSink {
 public:
  std::vector<RunEvent> events;

  void reading(const LcrReading&, const ReadingTag&) override {}
  void samples(std::span<const FrameSample>) override {}
  void level(const LoadLevel&) override {}
  void event(const RunEvent& event) override {
    if (!is_for_replay(event.kind.kind())) events.push_back(event);
  }
  Task<Result<>> flush() override { co_return Result<>(); }

  std::vector<std::string> kinds() const {
    std::vector<std::string> out;
    for (const RunEvent& e : events) out.push_back(e.kind.word());
    return out;
  }
};

}  // namespace lcrig
