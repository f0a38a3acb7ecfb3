// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sampler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <vector>

#include "base/either.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// An exchange takes 100 ms. Two at the same time are counted.
class SlowMeter final : public LcrMeter {
 public:
  explicit SlowMeter(Clock& clock) : clock_(clock) {}
  bool fails = false, unplugged = false, repeats = false, sticks = false;
  int under_way = 0, at_once = 0, measured = 0;

  const LcrCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override { co_return Identity(); }
  Task<Result<LcrSettings>> configure(LcrSettings s) override {
    const Exchange exchange(*this);
    co_await clock_.wait_for(100ms);
    co_return s;
  }
  Task<Result<LcrReading>> measure() override {
    const Exchange exchange(*this);
    co_await clock_.wait_for(100ms);
    if (unplugged) co_return fail(Errc::disconnected, "unplugged");
    if (fails) co_return fail(Errc::no_reply, "silent");
    ++measured;
    LcrReading reading;
    reading.fresh = !sticks && (!repeats || measured % 2 == 0);
    co_return reading;
  }
  Task<Result<LcrSettings>> reconnect() override { co_return LcrSettings(); }
  Task<Result<>> correct(CorrectionKind) override { co_return Result<>(); }
  Task<Result<>> resync() override { co_return Result<>(); }
  Task<Result<>> make_safe() override { co_return Result<>(); }
  void close() override {}

 private:
  struct Exchange {
    explicit Exchange(SlowMeter& m) : meter(m) {
      meter.at_once = std::max(meter.at_once, ++meter.under_way);
    }
    ~Exchange() { --meter.under_way; }
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;
    SlowMeter& meter;
  };
  Clock& clock_;
  LcrCapabilities capabilities_;
};

class SamplerTest : public ::testing::Test {
 protected:
  static Sampler::Plan three_in_three_seconds() {
    Sampler::Plan plan;
    plan.level.step_id = "level";
    plan.level.level = 7;
    plan.level.planned_readings = 3;
    plan.within = 3s;
    return plan;
  }
  Sampler::Hooks hooks() {
    Sampler::Hooks h;
    h.tag = [] {
      ReadingTag tag;
      tag.step_id = "behind";
      return tag;
    };
    h.taken = [this](const LcrReading& r, const ReadingTag& tag) {
      flags.push_back(r.flags);
      tags.push_back(tag);
    };
    h.event = [this](EventKind kind, const std::string&) { events.push_back(kind); };
    h.lost = [this](const Error& e) { lost.push_back(e.code); };
    return h;
  }
  Result<> take(std::int64_t& taken) {
    return run_task(io, clock, sampler.take(three_in_three_seconds(), taken));
  }

  VirtualClock clock;
  asio::io_context io;
  SlowMeter meter{clock};
  std::vector<ReadingTag> tags;
  std::vector<std::uint32_t> flags;
  std::vector<EventKind> events;
  std::vector<Errc> lost;
  Sampler sampler{io.get_executor(), clock, meter, LcrSettings(), hooks()};
};

TEST_F(SamplerTest, PlannedReadingsAreTakenAtTheirInstants) {
  const MonoTime begin = clock.now();
  std::int64_t taken = 0;
  ASSERT_TRUE(take(taken));
  ASSERT_EQ(tags.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(tags[i].index, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(tags[i].level, 7);
    EXPECT_EQ(tags[i].step_id, "level");
    EXPECT_EQ(*tags[i].planned - begin, i * 1s);
  }
}

TEST_F(SamplerTest, ARepeatedValueIsNoneOfThePlannedReadings) {
  meter.repeats = true;
  std::int64_t taken = 0;
  ASSERT_TRUE(take(taken));
  EXPECT_EQ(taken, 3);
  EXPECT_EQ(meter.measured, 6);
  EXPECT_EQ(tags.front().index, 0);
}

Task<Result<>> cut_off(Sampler& sampler, Sampler::Plan plan, Clock& clock, std::int64_t& taken) {
  auto task = sampler.take(plan, taken);
  auto r = co_await either(std::move(task), clock.wait_for(1500ms));
  if (r.index() == 1) co_return fail(Errc::aborted, "cut off");
  co_return std::get<0>(r);
}

TEST_F(SamplerTest, AReadingThatWasCutOffIsTakenLater) {
  std::int64_t taken = 0;
  EXPECT_FALSE(
      run_task(io, clock, cut_off(sampler, three_in_three_seconds(), clock, taken)).has_value());
  EXPECT_EQ(taken, 2);
  ASSERT_TRUE(take(taken));
  ASSERT_EQ(tags.size(), 3U);
  EXPECT_EQ(tags.back().index, 3);
}

TEST_F(SamplerTest, ALevelThatGoesOnHasOnlyTheTimeOfItsOtherReadings) {
  meter.sticks = true;
  const auto fails_after = [&](std::int64_t taken) {
    const MonoTime begin = clock.now();
    EXPECT_FALSE(take(taken));
    return clock.now() - begin;
  };
  const Duration all = fails_after(0);
  EXPECT_EQ(fails_after(2), all - 2s) << "the third of three readings in three seconds";
}

Task<bool> stop(Sampler& sampler) {
  co_await sampler.stop();
  co_return !sampler.is_running();
}

TEST_F(SamplerTest, ReadingsInTheBackgroundLeaveTheMeterToPlannedOnes) {
  sampler.start(true);
  clock.run_for(io, 1s);
  EXPECT_GE(tags.size(), 9U);
  EXPECT_EQ(tags.back().step_id, "behind");
  std::int64_t taken = 0;
  ASSERT_TRUE(take(taken));
  auto settings = run_task(io, clock, sampler.configure(LcrSettings()));
  EXPECT_TRUE(settings);
  EXPECT_EQ(meter.at_once, 1);
  EXPECT_TRUE(sampler.is_running());
  EXPECT_TRUE(run_task(io, clock, stop(sampler)));
  EXPECT_EQ(meter.under_way, 0);
}

TEST_F(SamplerTest, AMeterIsLostAfterFiveFailuresInARowAndAtOnceWhenUnplugged) {
  meter.fails = true;
  sampler.start(true);
  clock.run_for(io, 500ms);
  EXPECT_TRUE(lost.empty());
  clock.run_for(io, 1s);
  EXPECT_EQ(lost, std::vector<Errc>{Errc::no_reply});
  EXPECT_EQ(std::ranges::count(events, EventKind::retry), 5);
  meter.unplugged = true;
  std::int64_t taken = 0;
  EXPECT_FALSE(take(taken));
  EXPECT_EQ(lost.back(), Errc::disconnected);
}

TEST_F(SamplerTest, TheFirstReadingOfAMeterThatIsBackSaysSo) {
  std::int64_t taken = 0;
  ASSERT_TRUE(run_task(io, clock, sampler.reconnect()));
  ASSERT_TRUE(take(taken));
  EXPECT_EQ(flags, (std::vector<std::uint32_t>{lcr_flag::kAfterGap, 0, 0}));
}

}  // namespace
}  // namespace lcrig
