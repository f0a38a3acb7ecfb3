// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/planned_stops.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Kind = PlannedStops::Kind;

// 1 load, 2 level, 3 note, 4 load, 5 level, 6 note
constexpr const char* kTwoPasses = R"({ "format": "load-protocol/1", "name": "t",
  "limits": { "force_N": [-1, 1], "travel_mm": [0, 60] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
                       "aperture": "fast" } },
  "steps": [ { "id": "pass", "do": "repeat", "count": 2, "steps": [
    { "id": "load", "do": "ramp", "to": { "travel_mm": 1 }, "speed_mm_s": 1, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 5, "within_s": 5 },
    { "id": "note", "do": "mark", "text": "x" } ] } ],
  "finally": [ { "id": "c", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 1,
                 "timeout_s": 60 } ] })";

class PlannedStopsTest : public RunFixture {
 protected:
  void SetUp() override { protocol = parse_protocol(kTwoPasses, "t").value(); }

  PlannedStops& stops() { return parts().stops; }
  // Carries out `done` steps and begins the next one.
  void begin_walk(std::int64_t done) {
    walk_.emplace(stops(), cursor_, false);
    for (std::int64_t i = 0; i < done; ++i) {
      const Step& over = *cursor_.next();
      stops().enter(over);
      stops().leave(over);
    }
    done_ = done;
    stops().enter(*cursor_.next());
  }
  void end_walk() { walk_.reset(); }
  Result<PlannedStops::Asked> ask(Kind kind, StopPlace place) {
    return stops().ask(kind, place, "by me", done_, [](const auto&) { return 10.0; });
  }

 private:
  Environment environment_;
  StepCursor cursor_{protocol.steps, environment_};
  std::optional<PlannedStops::Walk> walk_;
  std::int64_t done_ = 0;
};

TEST_F(PlannedStopsTest, NeedAStepThatRuns) {
  const auto before = ask(Kind::stop, StopPlace::step);
  ASSERT_FALSE(before);
  EXPECT_EQ(before.error().code, Errc::invalid_request);
  begin_walk(0);
  EXPECT_TRUE(ask(Kind::stop, StopPlace::step));
  end_walk();
  EXPECT_FALSE(ask(Kind::pause, StopPlace::step));
}

TEST_F(PlannedStopsTest, AreAtTheEndOfWhatIsUnderWay) {
  begin_walk(0);
  const auto asked = ask(Kind::stop, StopPlace::level);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->stop.step_id, "level");
  EXPECT_EQ(asked->stop.after_steps, 2);
  EXPECT_EQ(asked->seconds, 10);  // for the level, after the motion that is running
  EXPECT_THAT(sink.kinds(), ElementsAre("stop_after"));
}

TEST_F(PlannedStopsTest, CountFromTheStepsThatAreDone) {
  begin_walk(4);
  EXPECT_EQ(ask(Kind::pause, StopPlace::repeat)->stop.after_steps, 6);
}

TEST_F(PlannedStopsTest, TheNearerOfTwoPlacesCounts) {
  begin_walk(0);
  EXPECT_FALSE(ask(Kind::stop, StopPlace::repeat)->replaces);
  const auto nearer = ask(Kind::stop, StopPlace::level);
  ASSERT_TRUE(nearer && nearer->replaces);
  EXPECT_EQ(nearer->replaces->step_id, "note");
  const auto later = ask(Kind::stop, StopPlace::repeat);
  EXPECT_TRUE(later->was_nearer);
  EXPECT_EQ(later->stop.place, StopPlace::level);
  EXPECT_EQ(stops().waiting(Kind::stop)->after_steps, 2);
  EXPECT_THAT(sink.kinds(), ElementsAre("stop_after", "stop_after"));  // the last changed nothing
}

TEST_F(PlannedStopsTest, AreTakenOnceWhenTheirStepsAreDone) {
  begin_walk(0);
  ASSERT_TRUE(ask(Kind::stop, StopPlace::level));
  EXPECT_FALSE(stops().take_due(Kind::stop, 1));
  EXPECT_TRUE(stops().take_due(Kind::stop, 2));
  EXPECT_FALSE(stops().take_due(Kind::stop, 3));
}

TEST_F(PlannedStopsTest, AStopAndAPauseWaitBesideEachOther) {
  begin_walk(0);
  ASSERT_TRUE(ask(Kind::stop, StopPlace::repeat));
  ASSERT_TRUE(ask(Kind::pause, StopPlace::level));
  EXPECT_TRUE(stops().take_due(Kind::pause, 2));
  EXPECT_FALSE(stops().take_due(Kind::stop, 2));
  EXPECT_TRUE(stops().take_due(Kind::stop, 3));
}

TEST_F(PlannedStopsTest, WithoutASafePointThePlacesThatThereAreAreNamed) {
  begin_walk(0);
  const auto asked = ask(Kind::stop, StopPlace::safe_point);
  ASSERT_FALSE(asked);
  EXPECT_THAT(asked.error().what, HasSubstr("expected one of step, level, cycle, repeat"));
  EXPECT_THAT(sink.kinds(), IsEmpty());
}

}  // namespace
}  // namespace lcrig
