// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/decide.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

namespace lcrig {
namespace {

using testing::HasSubstr;

constexpr Hazard kHazards[] = {Hazard::not_standing, Hazard::left_loaded, Hazard::frame_fault,
                               Hazard::limit, Hazard::other_instrument};
constexpr OnFailure kPolicies[] = {OnFailure::hold, OnFailure::skip, OnFailure::look,
                                   OnFailure::repeat};
constexpr Errc kCodes[] = {
    Errc::no_reply,        Errc::reply_cut_off, Errc::garbled, Errc::refused,
    Errc::unsupported,     Errc::disconnected,  Errc::busy,    Errc::limit_tripped,
    Errc::not_standing,    Errc::frame_fault,   Errc::io,      Errc::bug,
    Errc::invalid_request, Errc::aborted};
constexpr bool kBoth[] = {false, true};

QueueTerms terms_of(OnFailure policy, bool unattended = false) {
  QueueTerms out;
  out.on_failure = policy;
  out.unattended = unattended;
  return out;
}

QueueFacts facts() {
  HeadFacts head;
  head.entry = 4;
  head.protocol = "press";
  head.specimen = "paper-2";
  QueueFacts out;
  out.going = true;
  out.head = head;
  out.on_rig = "paper-2";
  out.person_there = true;
  return out;
}

template <class T>
bool is(const NextAct& act) {
  return std::holds_alternative<T>(act);
}

TEST(NextAct, BeginsTheHeadWhenItsSpecimenIsOnAndAPersonIsThere) {
  const auto act = next_act(facts());
  ASSERT_TRUE(is<Begin>(act));
  EXPECT_EQ(std::get<Begin>(act).entry, 4);
}

// Tries every combination. An entry begins only in one of them, and by itself only where it may.
TEST(NextAct, OfEveryCombinationBeginsOnlyWhatMay) {
  int begun = 0;
  for (const bool going : kBoth)
    for (const bool run : kBoth)
      for (const bool same : kBoth)
        for (const bool there : kBoth)
          for (const bool moves : kBoth)
            for (const bool unattended : kBoth)
              for (const auto state : {EntryState::waiting, EntryState::running,
                                       EntryState::interrupted, EntryState::failed}) {
                QueueFacts f = facts();
                f.going = going;
                f.run_goes_on = run;
                if (!same) f.on_rig = "paper-1";
                f.person_there = there;
                f.head->moves = moves;
                f.head->state = state;
                f.head->terms.unattended = unattended;
                const bool may = going && !run && same && state == EntryState::waiting &&
                                 (there || unattended || !moves);
                EXPECT_EQ(is<Begin>(next_act(f)), may);
                begun += may ? 1 : 0;
              }
  EXPECT_EQ(begun, 7);
}

TEST(NextAct, AnotherSpecimenNeedsAPersonWhateverTheTerms) {
  for (const bool unattended : kBoth) {
    for (const auto& on_rig :
         {std::optional<std::string>(), std::optional<std::string>("paper-1")}) {
      QueueFacts f = facts();
      f.on_rig = on_rig;
      f.head->terms.unattended = unattended;
      const auto act = next_act(f);
      ASSERT_TRUE(is<Gate>(act));
      const Gate& gate = std::get<Gate>(act);
      EXPECT_EQ(gate.kind, QueueGate::specimen);
      EXPECT_THAT(gate.prompt, HasSubstr("put paper-2 on"));
      if (on_rig) {
        EXPECT_THAT(gate.prompt, HasSubstr("take paper-1 off"));
      }
      EXPECT_TRUE(check_answer(gate, " paper-2\n"));
      for (const char* wrong : {"", "paper-1", "yes", "Paper-2", "paper-2 paper-2"}) {
        const auto r = check_answer(gate, wrong);
        ASSERT_FALSE(r) << wrong;
        EXPECT_THAT(r.error().what, HasSubstr("nothing moves"));
      }
    }
  }
}

TEST(NextAct, MotionWithoutAPersonNeedsConsent) {
  QueueFacts f = facts();
  f.person_there = false;
  const auto act = next_act(f);
  ASSERT_TRUE(is<Gate>(act));
  const Gate& gate = std::get<Gate>(act);
  EXPECT_EQ(gate.kind, QueueGate::person);
  EXPECT_TRUE(check_answer(gate, "yes"));
  EXPECT_FALSE(check_answer(gate, "paper-2"));
  EXPECT_FALSE(check_answer(gate, "no"));
}

TEST(NextAct, AnotherProbeOrFixtureNeedsAPerson) {
  for (const auto kind : {QueueGate::probe, QueueGate::fixture}) {
    QueueFacts f = facts();
    f.head->terms.unattended = true;
    const bool probe = kind == QueueGate::probe;
    (probe ? f.head->terms.probe : f.head->terms.fixture) = "tip-4";
    for (const bool known : kBoth) {
      auto& there = probe ? f.probe : f.fixture;
      there = known ? std::optional<std::string>("tip-2") : std::nullopt;
      const auto act = next_act(f);
      ASSERT_TRUE(is<Gate>(act));
      EXPECT_EQ(std::get<Gate>(act).kind, kind);
      EXPECT_TRUE(check_answer(std::get<Gate>(act), "tip-4"));
      EXPECT_FALSE(check_answer(std::get<Gate>(act), "tip-2"));
    }
    (probe ? f.probe : f.fixture) = "tip-4";
    EXPECT_TRUE(is<Begin>(next_act(f)));
  }
}

TEST(NextAct, AStrangerIsWaitedFor) {
  QueueFacts f = facts();
  f.head->terms.unattended = true;
  f.stranger = "at rest 5 pF are shown, but paper-2 had 3.6 pF in run 12";
  const auto act = next_act(f);
  ASSERT_TRUE(is<Gate>(act));
  EXPECT_EQ(std::get<Gate>(act).kind, QueueGate::stranger);
  EXPECT_THAT(std::get<Gate>(act).prompt, HasSubstr("had 3.6 pF in run 12"));
  EXPECT_FALSE(check_answer(std::get<Gate>(act), "yes"));
  EXPECT_TRUE(check_answer(std::get<Gate>(act), "paper-2"));
}

TEST(NextAct, BeginsAtTheLastOfTheTimesThatItWaitsFor) {
  QueueFacts f = facts();
  f.now_unix_s = 1'000'000;
  f.last_end_unix_s = 999'990;
  f.head->terms.rest_s = 60;
  auto act = next_act(f);
  ASSERT_TRUE(is<WaitUntil>(act));
  EXPECT_EQ(std::get<WaitUntil>(act).unix_s, 1'000'050);
  f.head->terms.not_before_unix_s = 1'000'500;
  act = next_act(f);
  ASSERT_TRUE(is<WaitUntil>(act));
  EXPECT_EQ(std::get<WaitUntil>(act).unix_s, 1'000'500);
  EXPECT_THAT(std::get<WaitUntil>(act).why, HasSubstr("not before"));
  f.now_unix_s = 1'000'500;
  EXPECT_TRUE(is<Begin>(next_act(f)));
  f.head->terms.not_after_unix_s = 1'000'499;
  EXPECT_TRUE(is<TooLate>(next_act(f)));
}

// A person acts in the evening, and the run begins at night.
TEST(NextAct, AsksForTheSpecimenBeforeItWaitsForATimeAndForConsentAfterwards) {
  QueueFacts f = facts();
  f.head->terms.not_before_unix_s = 1000;
  f.person_there = false;
  f.on_rig = "paper-1";
  ASSERT_TRUE(is<Gate>(next_act(f)));
  f.on_rig = "paper-2";
  EXPECT_TRUE(is<WaitUntil>(next_act(f)));
  f.now_unix_s = 1000;
  const auto act = next_act(f);
  ASSERT_TRUE(is<Gate>(act));
  EXPECT_EQ(std::get<Gate>(act).kind, QueueGate::person);
}

TEST(DayWindow, KnowsWhenItBeginsAlsoPastMidnight) {
  const auto night = parse_day_window("18:00-06:30");
  ASSERT_TRUE(night);
  EXPECT_EQ(to_string(*night), "18:00-06:30");
  // By its own arithmetic: the minute of the day from the C library.
  const auto minute = [](std::int64_t t) {
    const auto seconds = static_cast<std::time_t>(t);
    std::tm local{};
    ::localtime_r(&seconds, &local);
    return local.tm_hour * 60 + local.tm_min;
  };
  for (std::int64_t t = 1'790'000'000; t < 1'790'000'000 + 86'400; t += 1'237) {
    const auto begin = next_inside(t, *night);
    const int m = minute(t);
    const bool inside = m >= 18 * 60 || m < 6 * 60 + 30;
    EXPECT_EQ(begin == t, inside) << m;
    if (!inside) {
      EXPECT_EQ(minute(begin), 18 * 60);
      EXPECT_LT(begin - t, 12 * 3600);
    }
  }
  for (const char* wrong : {"", "18:00", "18-06", "24:00-06:00", "18:60-06:00", "18:00-18:00",
                            "18:00-06:00 ", "1:00-02:00"}) {
    EXPECT_FALSE(parse_day_window(wrong)) << wrong;
  }
}

TEST(NextAct, AnEmptyQueueIsFinished) {
  QueueFacts f = facts();
  f.head.reset();
  EXPECT_TRUE(is<Finished>(next_act(f)));
  f.going = false;
  EXPECT_TRUE(is<Stay>(next_act(f)));
}

EntryOutcome failed(Errc code, bool begun) {
  EntryOutcome out;
  out.begun = begun;
  out.code = code;
  out.reason = "the reason";
  return out;
}

TEST(Aftermath, ASuccessGoesOnAndForgetsEarlierFailures) {
  EntryOutcome outcome;
  outcome.begun = true;
  outcome.status = ExitStatus::success;
  const auto after = aftermath_of(outcome, terms_of(OnFailure::hold), 1, 2);
  EXPECT_EQ(after.state, EntryState::done);
  EXPECT_FALSE(after.hold);
  EXPECT_EQ(after.failures_in_row, 0);
}

// Safety takes precedence over whatever a batch says.
TEST(Aftermath, EveryHazardHoldsUnderEveryTermsWhateverTheStatus) {
  for (const Hazard hazard : kHazards)
    for (const OnFailure policy : kPolicies)
      for (const bool unattended : kBoth)
        for (const bool begun : kBoth)
          for (const auto status : {ExitStatus::success, ExitStatus::fail, ExitStatus::abort})
            for (const Errc code : kCodes) {
              EntryOutcome outcome = failed(code, begun);
              outcome.status = status;
              outcome.hazard = hazard;
              const auto after = aftermath_of(outcome, terms_of(policy, unattended), 1, 0);
              ASSERT_TRUE(after.hold);
              EXPECT_EQ(after.hold, hazard);
              EXPECT_THAT(after.why, HasSubstr("the reason"));
              EXPECT_NE(after.state, EntryState::skipped);
            }
}

TEST(Aftermath, WhatAPersonStoppedHolds) {
  for (const OnFailure policy : kPolicies) {
    EntryOutcome outcome = failed(Errc::aborted, true);
    outcome.status = ExitStatus::abort;
    EXPECT_EQ(aftermath_of(outcome, terms_of(policy), 1, 0).hold, HoldCause::aborted);
    EXPECT_EQ(aftermath_of(outcome, terms_of(policy), 1, 0).why, "the run was aborted: the reason");
    EXPECT_EQ(aftermath_of(failed(Errc::aborted, false), terms_of(policy), 0, 0).hold,
              HoldCause::aborted);
  }
}

TEST(Aftermath, ByDefaultEveryFailureHolds) {
  for (const Errc code : kCodes)
    for (const bool begun : kBoth) {
      const auto after = aftermath_of(failed(code, begun), QueueTerms(), 1, 0);
      EXPECT_TRUE(after.hold) << to_string(code);
      // A person who stopped a run before it began did not say that it failed.
      const bool stopped = !begun && code == Errc::aborted;
      EXPECT_EQ(after.state, stopped ? EntryState::waiting : EntryState::failed) << to_string(code);
    }
}

TEST(Aftermath, OnlyWhatDidNotBeginIsRepeatedAtOnceAndOnlyAfterALineThatWasDisturbed) {
  constexpr Errc kLine[] = {Errc::no_reply, Errc::reply_cut_off, Errc::garbled, Errc::disconnected};
  for (const Errc code : kCodes)
    for (const bool begun : kBoth) {
      const auto after = aftermath_of(failed(code, begun), terms_of(OnFailure::repeat), 1, 0);
      const bool repeats = !begun && std::ranges::find(kLine, code) != std::end(kLine);
      EXPECT_EQ(!after.hold, repeats) << to_string(code) << (begun ? ", begun" : "");
      if (repeats) {
        EXPECT_EQ(after.state, EntryState::waiting);
      }
    }
}

TEST(Aftermath, SkipsOnlyWhatTermsMayDecideOn) {
  for (const Errc code : {Errc::no_reply, Errc::reply_cut_off, Errc::garbled, Errc::disconnected,
                          Errc::invalid_request, Errc::unsupported}) {
    const auto after = aftermath_of(failed(code, true), terms_of(OnFailure::skip), 1, 0);
    EXPECT_FALSE(after.hold) << to_string(code);
    EXPECT_EQ(after.state, EntryState::skipped);
    EXPECT_EQ(after.failures_in_row, 1);
  }
  for (const Errc code : {Errc::refused, Errc::io, Errc::bug, Errc::limit_tripped,
                          Errc::frame_fault, Errc::not_standing, Errc::aborted, Errc::busy}) {
    EXPECT_TRUE(aftermath_of(failed(code, true), terms_of(OnFailure::skip), 1, 0).hold)
        << to_string(code);
  }
}

TEST(Aftermath, AfterALookAnEntryIsRepeatedOnce) {
  const auto terms = terms_of(OnFailure::look);
  EXPECT_EQ(aftermath_of(failed(Errc::no_reply, true), terms, 1, 0).hold, HoldCause::look);
  EXPECT_EQ(aftermath_of(failed(Errc::no_reply, true), terms, 2, 1).hold, HoldCause::failure);
}

TEST(Aftermath, NoTermsAllowMoreThanTheStatedNumberOfFailuresInARow) {
  for (const OnFailure policy : kPolicies) {
    QueueTerms terms = terms_of(policy);
    terms.failures_max = 5;
    std::int64_t in_row = 0, attempts = 0;
    for (;;) {
      const auto after = aftermath_of(failed(Errc::no_reply, false), terms, attempts, in_row);
      in_row = after.failures_in_row;
      ASSERT_LE(in_row, 5);
      if (after.hold) break;
    }
    EXPECT_GE(in_row, 1);
  }
}

TEST(Aftermath, AnInterruptedRunStaysInterrupted) {
  EntryOutcome outcome = failed(Errc::no_reply, true);
  outcome.status = ExitStatus::interrupted;
  const auto after = aftermath_of(outcome, terms_of(OnFailure::skip), 1, 0);
  EXPECT_EQ(after.state, EntryState::interrupted);
  EXPECT_TRUE(after.hold);
}

TEST(Aftermath, AResumptionThatDidNotBeginNeedsAnotherWord) {
  for (const OnFailure policy : kPolicies)
    for (const Errc code : kCodes) {
      EntryOutcome outcome = failed(code, false);
      outcome.resumes = true;
      const auto after = aftermath_of(outcome, terms_of(policy), 1, 0);
      EXPECT_TRUE(after.hold) << to_string(code);
      if (code != Errc::aborted) {
        EXPECT_EQ(after.state, EntryState::interrupted);
      }
    }
}

TEST(HazardWatch, KeepsTheWorst) {
  HazardWatch watch;
  EXPECT_FALSE(watch.worst());
  watch.take(hazard_of(EventKind::limit));
  watch.take(hazard_of(EventKind::loaded));
  watch.take(hazard_of(EventKind::step_end));
  EXPECT_EQ(watch.worst(), Hazard::left_loaded);
  watch.take(hazard_of(Errc::not_standing));
  EXPECT_EQ(watch.worst(), Hazard::not_standing);
}

TEST(HazardWatch, KnowsWhatTheFrameReportsByItself) {
  for (const EventKind kind :
       {EventKind::device_estop, EventKind::device_drive_off, EventKind::device_drive_fault,
        EventKind::device_shield, EventKind::hands_off}) {
    EXPECT_EQ(hazard_of(kind), Hazard::frame_fault);
  }
  EXPECT_EQ(hazard_of(Errc::frame_fault), Hazard::frame_fault) << "not_ready is one";
  EXPECT_EQ(hazard_of(EventKind::refused), Hazard::other_instrument);
}

TEST(QueueTerms, SurviveTheDatabase) {
  QueueTerms terms;
  terms.on_failure = OnFailure::look;
  terms.failures_max = 7;
  terms.unattended = true;
  terms.rest_s = 90;
  terms.not_before_unix_s = 5;
  terms.not_after_unix_s = 6;
  terms.between = parse_day_window("22:00-05:00");
  terms.probe = "tip-4";
  terms.fixture = "holder-2";
  const auto read = parse_terms(to_json(terms).dump());
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->on_failure, OnFailure::look);
  EXPECT_EQ(read->failures_max, 7);
  EXPECT_TRUE(read->unattended);
  EXPECT_EQ(read->rest_s, 90);
  EXPECT_EQ(read->not_before_unix_s, 5);
  EXPECT_EQ(read->not_after_unix_s, 6);
  EXPECT_EQ(read->between, terms.between);
  EXPECT_EQ(read->probe, "tip-4");
  EXPECT_EQ(read->fixture, "holder-2");
  EXPECT_FALSE(parse_terms("{}")->unattended) << "never by default";
  EXPECT_FALSE(parse_terms(R"({"on_failure":"pray"})"));
  EXPECT_FALSE(parse_terms("nonsense"));
  EXPECT_FALSE(parse_terms(R"({"between":"25:00-01:00"})"));
  EXPECT_FALSE(parse_terms(R"({"rest_s":-1})"));
  EXPECT_FALSE(parse_terms(R"({"not_before_unix_s":7,"not_after_unix_s":6})"));
}

}  // namespace
}  // namespace lcrig
