// SPDX-License-Identifier: Apache-2.0
// Exactly one part hangs; what the watchdog looks at shows it, and shows nothing otherwise.
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include "protocols/file/parse.hpp"
#include "protocols/run/run.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// Measures every 100 ms until it hangs.
class StubMeter final : public LcrMeter {
 public:
  explicit StubMeter(Clock& clock) : clock_(clock) {}
  bool hangs = false;

  const LcrCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override { co_return Identity(); }
  Task<Result<LcrSettings>> configure(LcrSettings s) override { co_return s; }
  Task<Result<LcrReading>> measure() override {
    if (hangs) co_await clock_.wait_until(MonoTime::max());
    co_await clock_.wait_for(100ms);
    co_return LcrReading();
  }
  Task<Result<>> correct(Correction) override { co_return Result<>(); }
  Task<Result<>> resync() override { co_return Result<>(); }
  Task<Result<>> make_safe() override { co_return Result<>(); }
  void close() override {}

 private:
  Clock& clock_;
  LcrCapabilities capabilities_;
};

// Stands; its STOP is never confirmed when it hangs.
class StubFrame final : public LoadFrame {
 public:
  explicit StubFrame(Clock& clock) : clock_(clock) { capabilities_.motion = true; }
  bool hangs = false;

  const FrameCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override { co_return Identity(); }
  Task<Result<Identity>> observe(double) override { co_return Identity(); }
  Task<Result<>> arm(FrameLimits) override { co_return Result<>(); }
  Task<Result<>> set_sample_rate(double) override { co_return Result<>(); }
  Task<Result<MotionOutcome>> move_to(Length, Velocity) override { co_return MotionOutcome(); }
  Task<Result<MotionOutcome>> move_until_force(Force, Velocity, Length) override {
    co_return MotionOutcome();
  }
  Task<Result<MotionOutcome>> ramp_force(Force, ForceRate) override { co_return MotionOutcome(); }
  Task<Result<>> hold_travel() override { co_return Result<>(); }
  Task<Result<>> hold_force(Force) override { co_return Result<>(); }
  Task<Result<>> zero(bool, bool) override { co_return Result<>(); }
  Task<Result<MotionOutcome>> place_mass(Mass) override { co_return MotionOutcome(); }
  Task<Result<>> stop() override {
    if (hangs) co_await clock_.wait_until(MonoTime::max());
    co_return Result<>();
  }
  Task<Result<>> resync() override { co_return Result<>(); }
  void close() override {}
  void set_listener(Listener* listener) override { listener_ = listener; }

  // Samples keep coming whatever hangs.
  Task<> send_samples() {
    for (;;) {
      co_await clock_.wait_for(100ms);
      FrameSample s;
      s.force_N = 0;
      s.travel_m = 0;
      s.received = clock_.now();
      if (listener_ != nullptr) listener_->on_samples(std::span(&s, 1));
    }
  }

 private:
  Clock& clock_;
  FrameCapabilities capabilities_;
  Listener* listener_ = nullptr;
};

class NoSink final : public RunSink {
 public:
  void reading(const LcrReading&, const ReadingTag&) override {}
  void samples(std::span<const FrameSample>) override {}
  void level(const LoadLevel&) override {}
  void event(const RunEvent&) override {}
  Task<Result<>> flush() override { co_return Result<>(); }
};

constexpr const char* kProtocol = R"({ "format": "load-protocol/1", "name": "t",
  "limits": { "force_N": [-1, 1], "travel_mm": [-1, 1] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" } },
  "steps": [ { "id": "r", "do": "record", "for_s": 3600 } ], "finally": [] })";

class Hang : public ::testing::Test {
 protected:
  Hang() {
    RunSetup setup(clock, meter, frame, sink, protocol);
    setup.limits = bind_limits(protocol, setup.environment, frame.capabilities()).value();
    run.emplace(io.get_executor(), std::move(setup));
    asio::co_spawn(io, frame.send_samples(), asio::detached);
    asio::co_spawn(io, run->execute(), [this](std::exception_ptr, RunResult) { ended = true; });
    clock.run_for(io, 30s);
  }

  VirtualClock clock;
  asio::io_context io;
  StubMeter meter{clock};
  StubFrame frame{clock};
  NoSink sink;
  Protocol protocol = parse_protocol(kProtocol, "t").value();
  std::optional<lcrig::Run> run;
  bool ended = false;
};

TEST_F(Hang, NothingHangsAndEverythingBeats) {
  for (int i = 0; i < 60; ++i) {
    const auto before = run->beats();
    clock.run_for(io, 1s);
    EXPECT_GT(run->beats(), before);
    EXPECT_FALSE(run->sampler().overdue(clock.now()));
  }
}

TEST_F(Hang, AMeterThatNeverReturnsIsOverdue) {
  meter.hangs = true;
  clock.run_for(io, 5s);
  EXPECT_FALSE(run->sampler().overdue(clock.now())) << "an honest time-out takes longer";
  // The runner ends the exchange of a silent meter by itself; without it this would show.
  EXPECT_TRUE(run->sampler().overdue(clock.now() + 20s));
}

TEST_F(Hang, ARunnerThatWaitsForEverBeatsNoMore) {
  frame.hangs = true;
  run->interrupt(InterruptRequest(Interrupt::abort, "test"));
  clock.run_for(io, 1s);
  const auto before = run->beats();
  clock.run_for(io, 60s);
  EXPECT_EQ(run->beats(), before);
  EXPECT_FALSE(ended);
}

}  // namespace
}  // namespace lcrig
