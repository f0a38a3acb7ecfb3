// SPDX-License-Identifier: Apache-2.0
// The promises of every LoadFrame, whatever is behind it. A new driver adds one line at the end.
#include <gtest/gtest.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/detached.hpp>

#include "drivers/dead_weight/driver.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "drivers/fd_transport.hpp"
#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class Bench {
 public:
  virtual ~Bench() = default;
  virtual LoadFrame& frame() = 0;
  // A motion that takes long in this rig.
  virtual Task<Result<MotionOutcome>> long_motion() = 0;
  // A motion of the same kind beyond wide_limits().
  virtual Task<Result<MotionOutcome>> forbidden_motion() = 0;
  virtual bool cut_link() { return false; }  // false: there is no link to cut

  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  void pass(Duration d) { clock.run_for(io, d); }
  void arm() {
    if (!run(frame().identify()) || !run(frame().arm(wide_limits()))) {
      throw std::runtime_error("does not arm");
    }
  }

  VirtualClock clock;
  asio::io_context io;
  MemoryListener listener;
};

class LinkBench final : public Bench {
 public:
  explicit LinkBench(const MakeWire& make_wire) {
    auto ends = make_wire(io.get_executor(), clock, "sim:frame");
    sim_.emplace(std::move(ends->far), clock, scene_);
    frame_.emplace(std::move(ends->near), clock, io.get_executor());
    frame_->set_listener(&listener);
    asio::co_spawn(io, sim_->run(), asio::detached);
  }
  ~LinkBench() override {
    frame_.reset();
    sim_->close();
    for (io.restart(); io.poll() > 0; io.restart()) {
    }
  }
  LoadFrame& frame() override { return *frame_; }
  Task<Result<MotionOutcome>> long_motion() override { return frame_->move_to(4.0_mm, 0.01_mm_s); }
  Task<Result<MotionOutcome>> forbidden_motion() override {
    return frame_->move_to(6.0_mm, 0.01_mm_s);
  }
  bool cut_link() override { return sim_->close(), true; }

 private:
  LinearScene scene_;
  std::optional<ZwickSim> sim_;
  std::optional<ZwickLink> frame_;
};

class WeightBench final : public Bench {
 public:
  WeightBench() {
    frame_.emplace(person_, clock, io.get_executor());
    frame_->set_listener(&listener);
  }
  ~WeightBench() override {
    frame_.reset();
    for (io.restart(); io.poll() > 0; io.restart()) {
    }
  }
  LoadFrame& frame() override { return *frame_; }
  Task<Result<MotionOutcome>> long_motion() override {
    return frame_->place_mass(Mass::from_si(0.1));
  }
  Task<Result<MotionOutcome>> forbidden_motion() override {
    return frame_->place_mass(Mass::from_si(5));
  }

 private:
  SimOperator person_{clock, 1h};
  std::optional<DeadWeightFrame> frame_;
};

struct Maker {
  const char* name;
  std::unique_ptr<Bench> (*make)();
};

class EveryLoadFrame : public testing::TestWithParam<Maker> {
 protected:
  support::Outcome<Result<MotionOutcome>> out_;  // outlives the tasks of the bench
  std::unique_ptr<Bench> bench_ = GetParam().make();
  Bench& b = *bench_;

  void start_long_motion() {
    b.arm();
    support::spawn(b.io, b.long_motion(), out_);
    b.pass(2s);
    ASSERT_FALSE(out_.done);
  }
};

TEST_P(EveryLoadFrame, SaysWhoItIsAndAgain) {
  const auto first = b.run(b.frame().identify());
  ASSERT_TRUE(first) << first.error().what;
  EXPECT_FALSE(first->model.empty());
  EXPECT_EQ(b.run(b.frame().identify())->text, first->text);
}

TEST_P(EveryLoadFrame, IsObservedAndCommandedAfterwards) {
  const auto seen = b.run(b.frame().observe(10));
  ASSERT_TRUE(seen) << seen.error().what;
  b.pass(2s);
  EXPECT_GE(b.listener.samples.size(), 2U);
  const auto first = b.run(b.frame().identify());
  ASSERT_TRUE(first) << first.error().what;
  EXPECT_EQ(first->serial, seen->serial);
  start_long_motion();
}

TEST_P(EveryLoadFrame, RefusesMotionBeforeItIsArmed) {
  ASSERT_TRUE(b.run(b.frame().identify()));
  const auto r = b.run(b.long_motion());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
}

TEST_P(EveryLoadFrame, RefusesMotionBeyondTheLimits) {
  b.arm();
  EXPECT_FALSE(b.run(b.forbidden_motion()));
}

TEST_P(EveryLoadFrame, RefusesLimitsBeyondTheMachine) {
  ASSERT_TRUE(b.run(b.frame().identify()));
  auto limits = wide_limits();
  limits.force_max = Force::from_si(1e6);
  EXPECT_FALSE(b.run(b.frame().arm(limits)));
  EXPECT_FALSE(b.run(b.long_motion())) << "refused limits do not arm";
}

TEST_P(EveryLoadFrame, StopIsIdempotentAndFast) {
  b.arm();
  for (int i = 0; i < 3; ++i) {
    const MonoTime begin = b.clock.now();
    EXPECT_TRUE(b.run(b.frame().stop()));
    EXPECT_LT(b.clock.now() - begin, 10ms);
  }
}

TEST_P(EveryLoadFrame, StopEndsAMotionWithItsReason) {
  start_long_motion();
  const MonoTime begin = b.clock.now();
  EXPECT_TRUE(b.run(b.frame().stop()));
  EXPECT_LT(b.clock.now() - begin, 10ms);
  b.clock.run(b.io, [this] { return out_.done; });
  EXPECT_LT(b.clock.now() - begin, 10ms);
  ASSERT_TRUE(out_.value && *out_.value);
  EXPECT_EQ((*out_.value)->reason, MotionEnd::stopped);
}

TEST_P(EveryLoadFrame, StopWorksAfterTheMotionTaskWasCancelled) {
  b.arm();
  asio::cancellation_signal cancel;
  bool ended = false;
  asio::co_spawn(
      b.io, b.long_motion(),
      asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr, Result<MotionOutcome> r) {
        ended = true;
        EXPECT_FALSE(r);
      }));
  b.pass(2s);
  ASSERT_FALSE(ended);
  cancel.emit(asio::cancellation_type::terminal);
  b.pass(1ms);
  EXPECT_TRUE(ended);
  EXPECT_TRUE(b.run(b.frame().stop()));
  support::spawn(b.io, b.long_motion(), out_);
  b.pass(1s);
  EXPECT_FALSE(out_.done) << "the frame is free for the next motion";
  EXPECT_TRUE(b.run(b.frame().stop()));
  b.pass(10ms);
}

TEST_P(EveryLoadFrame, CloseEndsEveryWaitAndLeavesNoWaiter) {
  start_long_motion();
  b.frame().close();
  b.frame().close();
  b.pass(1ms);
  ASSERT_TRUE(out_.done);
  EXPECT_EQ(out_.value->error().code, Errc::disconnected);
  EXPECT_EQ(b.clock.pending(), 0U);
  EXPECT_TRUE(b.listener.lost.empty());
  EXPECT_FALSE(b.run(b.long_motion()));
}

TEST_P(EveryLoadFrame, ACutLinkEndsEveryWaitAndIsReportedOnce) {
  start_long_motion();
  if (!b.cut_link()) GTEST_SKIP() << "this rig has no link";
  b.pass(1ms);
  ASSERT_TRUE(out_.done);
  EXPECT_EQ(out_.value->error().code, Errc::disconnected);
  EXPECT_EQ(b.run(b.frame().stop()).error().code, Errc::disconnected);
  EXPECT_EQ(b.listener.lost.size(), 1U);
  EXPECT_EQ(b.clock.pending(), 0U);
}

TEST_P(EveryLoadFrame, SamplesAreNumberedWithoutAHole) {
  b.arm();
  ASSERT_TRUE(b.run(b.frame().set_sample_rate(10)));
  b.pass(60s);
  const auto& s = b.listener.samples;
  ASSERT_GE(s.size(), 590U);
  for (std::size_t i = 1; i < s.size(); ++i) {
    ASSERT_EQ(s[i].device_seq, s[i - 1].device_seq + 1);
    ASSERT_GE(s[i].received, s[i - 1].received);
    ASSERT_EQ(s[i].flags & frame_flag::kAfterGap, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Drivers, EveryLoadFrame,
                         testing::Values(Maker{"zwick",
                                               []() -> std::unique_ptr<Bench> {
                                                 return std::make_unique<LinkBench>(
                                                     make_memory_pipe);
                                               }},
                                         Maker{"zwick_socketpair",
                                               []() -> std::unique_ptr<Bench> {
                                                 return std::make_unique<LinkBench>(
                                                     make_socketpair);
                                               }},
                                         Maker{"dead_weight",
                                               []() -> std::unique_ptr<Bench> {
                                                 return std::make_unique<WeightBench>();
                                               }}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace lcrig
