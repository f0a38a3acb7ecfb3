// SPDX-License-Identifier: Apache-2.0
// Stored words and payloads are a format: databases that are years old must still be readable.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "base/strict_json.hpp"
#include "events/payloads.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

// The second column of the table in docs/events.md, by kind.
std::map<std::string, std::string> documented() {
  std::map<std::string, std::string> out;
  const std::regex row(R"(\| `(\w+)` \| ([^|]*) \|.*)");
  std::istringstream page(read_text_file("docs/events.md").value());
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    EXPECT_TRUE(out.emplace(match[1], match[2]).second) << match[1] << " has two rows";
  }
  return out;
}

TEST(EventKind, EachHasOneWordAndOneRowInThePage) {
  const auto rows = documented();
  auto words = all_words<EventKind>();
  words.pop_back();  // `other` stands for all others
  for (const auto& word : words) {
    EXPECT_EQ(rows.count(word), 1U) << word;
    EXPECT_EQ(to_string(EventName(word).kind()), word);
  }
  EXPECT_EQ(rows.size(), words.size());
}

TEST(EventKind, WhatIsForTheReplayIsLeftOutBySql) {
  for (const auto& word : all_words<EventKind>()) {
    const bool left_out = std::string(kIsShown).find("'" + word + "'") != std::string::npos;
    EXPECT_EQ(left_out, is_for_replay(EventName(word).kind())) << word;
  }
}

TEST(EventKind, AWordThatNobodyKnowsIsKept) {
  const EventName name("device_coffee");
  EXPECT_EQ(name.kind(), EventKind::other);
  EXPECT_EQ(name.word(), "device_coffee");
}

template <class P>
void expect_stored(const P& payload, const std::string& stored) {
  SCOPED_TRACE(to_string(P::kKind));
  EXPECT_EQ(to_json(payload), stored);
  const auto back = from_json<P>(stored);
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(to_json(*back), stored);
  EXPECT_FALSE(from_json<P>("words for people"));
  const auto page = documented();
  const auto object = nlohmann::json::parse(stored);
  for (const auto& [key, value] : object.items()) {
    EXPECT_THAT(page.at(std::string(to_string(P::kKind))), HasSubstr("`" + key + "`"));
  }
}

TEST(EventPayload, OfAMotionIsWhatWasStored) {
  expect_stored(MotionEvent{"target", 1.0, 0.00125},
                R"({"reason":"target","force_N":1,"travel_m":0.00125})");
  expect_stored(MotionEvent{"stopped", std::nullopt, std::nullopt}, R"({"reason":"stopped"})");
  expect_stored(WeightPlacedEvent{"target", 0.5, std::nullopt},
                R"({"reason":"target","force_N":0.5})");
  expect_stored(OvershootEvent{1, 1.25, std::nullopt, 1.1},
                R"({"threshold_N":1,"predicted_N":1.25,"expected_N":null,"observed_N":1.1})");
  expect_stored(OvershootExceededEvent{1, 1.25, 1.2, 1.5},
                R"({"threshold_N":1,"predicted_N":1.25,"expected_N":1.2,"observed_N":1.5})");
}

TEST(EventPayload, OfAContactIsWhatWasStored) {
  expect_stored(RestEvent{-0.001, 2e-4, 25, 0.5e-3},
                R"({"force_N":-0.001,"scatter_N":0.0002,"samples":25,"travel_m":0.0005})");
  expect_stored(DriftEvent{0, 2e-4, 25, std::nullopt},
                R"({"force_N":0,"scatter_N":0.0002,"samples":25})");
  expect_stored(ContactEvent{0.003, 0.02, 0.0},
                R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
  expect_stored(NoContactEvent{0.003, 0.02, 1e-05},
                R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":1e-05})");
  expect_stored(StiffnessEvent{0.02, 1250.5, std::nullopt, 900.0},
                R"({"force_N":0.02,"stiffness_N_m":1250.5,"at_most_N_m":null,"at_least_N_m":900})");
  expect_stored(ZeroEvent{0.01}, R"({"force_before_N":0.01})");
  expect_stored(GapStatedEvent{0.004}, R"({"contact_travel_m":0.004})");
}

TEST(EventPayload, OfALossIsWhatWasStored) {
  const char* absence = R"({"instrument":"meter","seconds":1.500,"away_s":1.250,"attempts":3})";
  expect_stored(GapEvent{"meter", 1.5, 1.25, 3}, absence);
  expect_stored(ReconnectedEvent{"meter", 1.5, 1.25, 3}, absence);
  expect_stored(LevelAbandonedEvent{3, 30}, R"({"level":3,"readings":30})");
  expect_stored(ClockStepEvent{-3600}, R"({"seconds":-3600.000})");
  expect_stored(LateSamplesEvent{0.25}, R"({"age_s":0.250})");
}

TEST(EventPayload, OfAReadBackIsWhatWasStored) {
  expect_stored(ReadBackEvent{true, std::nullopt}, R"({"equal":true})");
  expect_stored(ReadBackEvent{false, std::vector<std::string>{"frequency_Hz", "function"}},
                R"({"equal":false,"differs":["frequency_Hz","function"]})");
  EXPECT_FALSE(from_json<ReadBackEvent>(R"({"differs":["level_V"]})"));
  expect_stored(UnprovenEvent{1000000000, 2500000000, 26, "the meter restarted"},
                R"({"asked_from_mono_ns":1000000000,"asked_to_mono_ns":2500000000,"readings":26,)"
                R"("why":"the meter restarted"})");
}

TEST(EventPayload, OfAStateIsWhatWasStored) {
  RunPoint p;
  p.steps_done = 17;
  p.levels = 5;
  expect_stored(
      p, R"({"level_in_repeat":0,"level_repeat":-1,"levels":5,"steps_done":17,"zeroed":false})");
  p.contact_travel_m = 2;
  p.travel_m = -2.5e-3;
  p.origin = "18 \"x\"";
  p.zeroed = true;
  expect_stored(p, R"({"contact_travel_m":2.0,"level_in_repeat":0,"level_repeat":-1,"levels":5,)"
                   R"("origin":"18 \"x\"","steps_done":17,"travel_m":-0.0025,"zeroed":true})");
  p.zeros_N = 0.25;
  EXPECT_EQ(from_json<RunPoint>(to_json(p))->zeros_N, 0.25) << "known to the run that goes on";
  expect_stored(ContinuesEvent{12, "load", 4}, R"({"run":12,"step":"load","steps_done":4})");
}

TEST(EventPayload, OfAnAnswerIsWhatWasStored) {
  AnswerEvent number{"Thickness \"by gauge\"",
                     "number",
                     125.5,
                     "um",
                     std::nullopt,
                     "person",
                     "ada",
                     2,
                     std::nullopt};
  expect_stored(
      number, R"({"question":"Thickness \"by gauge\"","type":"number","number":125.5,"unit":"um",)"
              R"("source":"person","by":"ada","repeat":2})");
  expect_stored(AnswerEvent{"The surface", "choice", std::nullopt, std::nullopt, "dusty", "default",
                            std::nullopt, 0, 7},
                R"({"question":"The surface","type":"choice","text":"dusty","source":"default",)"
                R"("repeat":0,"from_run":7})");
}

TEST(EventPayload, OfAStopThatWaitsIsWhatWasStored) {
  const char* stored = R"({"place":"level","step":"measure","steps_done":12,"why":"by lab"})";
  expect_stored(StopAfterEvent{"level", "measure", 12, "by lab"}, stored);
  expect_stored(PauseAtEvent{"level", "measure", 12, "by lab"}, stored);
}

TEST(EventPayload, OfSettingsAndRequestsIsWhatWasStored) {
  SettingsEvent s{"Cp-D", 1000.0, 1.0, std::nullopt, Aperture::fast, 1.0, LcrTrigger::internal,
                  0.065};
  expect_stored(s,
                R"({"function":"Cp-D","frequency_Hz":1000,"level_V":1,"bias_V":null,)"
                R"("aperture":"fast","average":1,"trigger":"internal","conversion_time_s":0.065})");
  const auto of_another_meter = from_json<SettingsEvent>(R"({"aperture": "turbo", "level_V": 1})");
  EXPECT_FALSE(of_another_meter->aperture) << "a word that nobody knows is left out";
  EXPECT_EQ(of_another_meter->level_V, 1);
  EXPECT_EQ(from_json<SettingsEvent>(R"({"frequency_Hz": 2000})")->frequency_Hz, 2000);
  expect_stored(
      RequestEvent{"run.abort", "lab", 1000, 4711, "wrong \"specimen\""},
      R"({"pid":4711,"request":"run.abort","uid":1000,"user":"lab","why":"wrong \"specimen\""})");
}

TEST(EventPayload, OfAStepThatEndedIsAWord) {
  EXPECT_EQ(to_json(StepEndEvent()), "done");
  EXPECT_EQ(to_json(StepEndEvent{EventKind::abort}), "abort");
  EXPECT_FALSE(from_json<StepEndEvent>("done")->stopped_by);
  EXPECT_EQ(from_json<StepEndEvent>("limit")->stopped_by, EventKind::limit);
}

TEST(EventPayload, SaysWhatIsMissing) {
  const auto got = from_json<LevelAbandonedEvent>(R"({"level":"three"})");
  ASSERT_FALSE(got);
  EXPECT_THAT(got.error().what, HasSubstr("`level`"));
}

TEST(RunEvents, KeepThePayloadThatTheyWereMadeOf) {
  const RunEvent made(MonoTime(), "load", LevelAbandonedEvent{3, 30});
  EXPECT_EQ(made.kind, EventKind::level_abandoned);
  EXPECT_EQ(made.detail, R"({"level":3,"readings":30})");
  ASSERT_NE(made.as<LevelAbandonedEvent>(), nullptr);
  EXPECT_EQ(made.as<LevelAbandonedEvent>()->readings, 30);
  EXPECT_EQ(made.as<ZeroEvent>(), nullptr);
  const RunEvent words(MonoTime(), EventKind::mark, "load", "half way");
  EXPECT_EQ(words.as<LevelAbandonedEvent>(), nullptr);
}

// The page lists what belongs to each word.
TEST(EventPayload, OfWhatTheWatchWasToldIsReadBack) {
  const std::string page = read_text_file("docs/events.md").value();
  for (const std::string& word : all_words<WatchInput>())
    EXPECT_THAT(page, HasSubstr("`" + word + "`"));
  WatchInputEvent e(WatchInput::order);
  e.samples = 1200;
  e.judging = e.holds = true;
  e.force_N = 0.1;
  e.against_N = 1.0 / 3;
  e.worst_N = std::numeric_limits<double>::infinity();  // JSON has none
  e.reason = "\"quoted\"";
  const std::string stored = to_json(e);
  const auto back = from_json<WatchInputEvent>(stored);
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(to_json(*back), stored);
  EXPECT_EQ(back->what, WatchInput::order);
  EXPECT_EQ(back->against_N, e.against_N);
  EXPECT_GT(*back->worst_N, 1e300);
  EXPECT_FALSE(back->travel_m);
  EXPECT_FALSE(from_json<WatchInputEvent>(R"({"what":"nonsense","samples":1})"));
}

TEST(EventPayload, OfTheWatchKeepsItsTables) {
  WatchSetupEvent e;
  e.rate_Hz = 50;
  e.gap_min_m = -1e-3;
  e.at_most_N_m = {1.0 / 3, 2e3, std::numeric_limits<double>::infinity()};
  const auto back = from_json<WatchSetupEvent>(to_json(e));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(back->at_most_N_m, e.at_most_N_m);
  EXPECT_EQ(back->gap_min_m, e.gap_min_m);
  EXPECT_FALSE(back->if_free_N_m);
  EXPECT_FALSE(from_json<WatchSetupEvent>(R"({"format":1})"));
}

}  // namespace
}  // namespace lcrig
