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
  bool fails = false, unplugged = false, repeats = false, sticks = false, slow = false;
  ReadBack now;  // the answer to every question for the settings
  MonoTime changed{};  // until then they are as wanted
  int asked = 0;  // how often that was asked
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
    reading.asked = clock_.now() - 100ms;
    reading.slow = slow;
    reading.fresh = !sticks && (!repeats || measured % 2 == 0);
    co_return reading;
  }
  Task<Result<ReadBack>> read_back(MeterState) override {
    const Exchange exchange(*this);
    ++asked;
    if (unplugged) co_return fail(Errc::disconnected, "unplugged");
    if (fails) co_await clock_.wait_for(100ms);
    if (fails) co_return fail(Errc::no_reply, "silent");
    co_return clock_.now() < changed ? ReadBack() : now;
  }
  Task<Result<LcrSettings>> restore(MeterState wanted) override {
    now.differs.clear();
    co_return wanted.settings;
  }
  Task<Result<Reconnected>> reconnect(MeterState wanted) override {
    ReadBack found = now;
    now.differs.clear();
    co_return Reconnected(wanted.settings, std::move(found));
  }
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
    h.read_back = [this](const ReadBackEvent& e) { equal.push_back(e.equal); };
    h.unproven = [this](const UnprovenEvent& e) { unproven.push_back(e); };
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
  std::vector<bool> equal;
  std::vector<UnprovenEvent> unproven;
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

// A reading of a run without read-backs would stand as one under the settings of the run.
TEST_F(SamplerTest, TheSettingsAreReadBackBeforeTheFirstReadingAndEveryThreeSeconds) {
  sampler.start(true);
  clock.run_for(io, 50ms);
  EXPECT_EQ(meter.asked, 1);
  EXPECT_EQ(meter.measured, 0);
  clock.run_for(io, 31s);
  EXPECT_GE(meter.asked, 10);
  EXPECT_LE(meter.asked, 11);
  EXPECT_TRUE(unproven.empty());
}

TEST_F(SamplerTest, OtherSettingsMakeTheReadingsSinceTheLastEqualReadBackUnproven) {
  sampler.start(true);
  clock.run_for(io, 1500ms);
  const std::size_t before = tags.size();
  meter.now.differs = {"frequency_Hz"};
  clock.run_for(io, 5s);
  EXPECT_EQ(equal, (std::vector<bool>{true, false}));
  ASSERT_EQ(unproven.size(), 1U);
  EXPECT_EQ(unproven[0].readings, static_cast<std::int64_t>(tags.size()));
  EXPECT_GT(tags.size(), before);
  EXPECT_EQ(unproven[0].asked_from_mono_ns, 0);
  EXPECT_GT(unproven[0].asked_to_mono_ns, 2'500'000'000);
  EXPECT_EQ(lost, std::vector<Errc>{Errc::refused});
  EXPECT_FALSE(sampler.is_running());
  EXPECT_TRUE(sampler.is_spoiled(MonoTime{} + 2s));
  EXPECT_FALSE(sampler.is_spoiled(clock.now()));
  ASSERT_TRUE(run_task(io, clock, sampler.reconnect()));
  EXPECT_TRUE(equal.back()) << "the settings that were sent again are read back";
}

TEST_F(SamplerTest, ALevelIsProvenAtItsEnd) {
  std::int64_t taken = 0;
  ASSERT_TRUE(take(taken));
  EXPECT_EQ(equal, (std::vector<bool>{true, true}));
  meter.now.differs = {"level_V"};
  meter.changed = clock.now() + 1s;
  taken = 0;
  EXPECT_FALSE(take(taken));
  EXPECT_EQ(taken, 3);
  ASSERT_EQ(unproven.size(), 1U);
  EXPECT_EQ(unproven[0].readings, 3);
}

TEST_F(SamplerTest, AFailedReadingIsAReasonToAskAtOnce) {
  sampler.start(true);
  clock.run_for(io, 550ms);
  const int asked = meter.asked;
  meter.fails = true;
  clock.run_for(io, 200ms);
  meter.fails = false;
  clock.run_for(io, 400ms);
  EXPECT_GT(meter.asked, asked);
}

TEST_F(SamplerTest, SettingsAreReadBackBeforeTheyAreChanged) {
  sampler.start(true);
  clock.run_for(io, 1s);
  meter.now.differs = {"function"};
  EXPECT_FALSE(run_task(io, clock, sampler.configure(LcrSettings())));
  ASSERT_EQ(unproven.size(), 1U);
  EXPECT_GT(unproven[0].readings, 5);
}

// Panels were used to set another aperture, which looks like the slow state of the meter.
TEST_F(SamplerTest, ASlowMeterIsSetUpAgainOnlyWhenItsSettingsAreUnchanged) {
  sampler.start(true);
  clock.run_for(io, 1s);
  meter.slow = true;
  meter.now.differs = {"aperture"};
  clock.run_for(io, 1s);
  ASSERT_EQ(unproven.size(), 1U) << "sending them again would have hidden it";
  meter.slow = false;
  ASSERT_TRUE(run_task(io, clock, sampler.reconnect()));
  flags.clear();
  sampler.start(true);
  meter.slow = true;
  clock.run_for(io, 250ms);
  meter.slow = false;
  clock.run_for(io, 1s);
  EXPECT_EQ(std::ranges::count(flags, lcr_flag::kAfterSetUp), 1);
}

Task<bool> finish(Sampler& sampler) {
  co_await sampler.finish_proof();
  co_return true;
}

TEST_F(SamplerTest, WhatCannotBeProvenAtTheEndIsUnproven) {
  sampler.start(true);
  clock.run_for(io, 1s);
  run_task(io, clock, stop(sampler));
  meter.unplugged = true;
  EXPECT_TRUE(run_task(io, clock, finish(sampler)));
  ASSERT_EQ(unproven.size(), 1U);
  EXPECT_EQ(unproven[0].readings, static_cast<std::int64_t>(tags.size()));
}

}  // namespace
}  // namespace lcrig
