// SPDX-License-Identifier: Apache-2.0
// Properties that must hold on rigs that the product was not developed on (issue "The real rig
// first"). Rig and protocol are random. The daemon knows only what a config file would say.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <variant>

#include "protocols/file/step_kinds.hpp"
#include "tests/property/lie_judge.hpp"
#include "tests/property/own_bounds.hpp"
#include "tests/property/recipe.hpp"
#include "tests/property/sweep.hpp"

namespace lcrig::property {
namespace {

// A new kind of step has to be in the random protocols, too.
TEST(Recipes, ContainEachKindOfStep) {
  std::set<std::string_view> missing;
  const auto each = [&]<class... Kind>(std::tuple<Kind...>*) {
    (missing.insert(Kind::kWord), ...);
  };
  each(static_cast<StepKinds*>(nullptr));
  Dice dice(1);
  const auto number = [&] { return static_cast<int>(dice.below(1001)); };
  for (std::uint64_t seed = 1; seed <= 300 && !missing.empty(); ++seed) {
    Recipe recipe;
    recipe.beyond = number();
    std::ranges::generate(recipe.base, number);
    recipe.steps.resize(12);
    for (Choice& c : recipe.steps) {
      c.kind = static_cast<int>(dice.below(kKindsOfSteps));
      std::ranges::generate(c.at, number);
    }
    const std::string text = write_protocol(recipe, sim::random_rig(seed)).text;
    std::erase_if(missing, [&](std::string_view kind) {
      return text.find(fmt::format(R"("do":"{}")", kind)) != text.npos;
    });
  }
  EXPECT_THAT(missing, testing::IsEmpty());
}

using When = RigWorld::Act::When;
using What = Happening::Kind;

constexpr const char* kPlannedStops = "planned stops";

void interrupt_it(std::uint64_t draw, Case& c) {
  Dice dice(draw);
  Happening h;
  h.kind = std::array{What::abort, What::freeze, What::shutdown, What::pause}.at(
      static_cast<std::size_t>(dice.below(4)));
  draw_instant(dice, h);
  if (h.kind == What::pause) h.lasts_s = dice.even(0.05, 3);
  c.happenings.push_back(h);
}

void stop_it_later(std::uint64_t draw, Case& c) {
  Dice dice(draw);
  Happening h;
  h.kind =
      std::array{What::after_step, What::after_level, What::after_cycle, What::after_repeat}.at(
          static_cast<std::size_t>(dice.below(4)));
  draw_instant(dice, h);
  h.lasts_s = 0;
  c.happenings.push_back(h);
}

void lose_it(std::uint64_t draw, Case& c) {
  Dice dice(draw);
  Happening h;
  h.kind = std::array{What::deaf, What::silent, What::unplug}.at(
      static_cast<std::size_t>(dice.below(3)));
  h.when = When::drive;
  h.n = dice.below(8);
  h.after_s = dice.even(0, 1) * dice.even(0, 1) * 2;
  if (dice.below(3) == 0) h.lasts_s = dice.even(0.1, 6);
  c.happenings.push_back(h);
}

void break_it(std::uint64_t draw, Case& c) {
  static constexpr const char* kFaults[] = {
      R"("on":"frame","fault":"line_late","delay_s":0.7)",
      R"("on":"frame","fault":"line_lost","probability":0.02)",
      R"("on":"frame","fault":"line_garbled","probability":0.02)",
      R"("on":"frame","fault":"refusal")",
      R"("on":"frame","fault":"completion_lost")",
      R"("on":"frame","fault":"stall")",
      R"("on":"frame","fault":"heartbeat_lost","for_s":3)",
      R"("on":"frame","fault":"gateway_restarted","forgets_zero":true)",
      R"("on":"frame","fault":"power_cycle","for_s":1)",
      R"("on":"frame","fault":"unplug","for_s":1)",
      R"("on":"frame","fault":"samples_lost","samples":20)",
      R"("on":"frame","fault":"force_spike","force_N":100,"samples":2)",
      R"("on":"meter","fault":"silent")",
      R"("on":"meter","fault":"unplug","for_s":2)",
      R"("on":"meter","fault":"reply_garbled","probability":0.3)",
      R"("on":"bench","fault":"disk_full")",
      R"("on":"bench","fault":"disk_read_only","for_s":2)"};
  Dice dice(draw);
  const std::string fault = kFaults[dice.below(std::ssize(kFaults))];
  const bool counted = fault.find("probability") != std::string::npos;
  std::string when;
  if (!counted || dice.below(2) == 0) {
    static constexpr const char* kSteps[] = {"find_contact", "move_until", "ramp", "hold"};
    when = dice.below(3) == 0
               ? fmt::format(R"(,"at_s":{:.3f})", dice.even(0, 20))
               : fmt::format(R"(,"in_step":"{}","after_s":{:.3f},"times":1)", kSteps[dice.below(4)],
                             dice.even(0, 1) * dice.even(0, 2));
  }
  c.fault_script = R"({"format":"faults/1","faults":[{)" + fault + when + "}]}";
}

Broken both(Broken a, const Broken& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

void count_instants(const Trial& t, Counters& n) {
  auto& w = const_cast<Trial&>(t).world();
  for (const auto& a : w.acted) {
    const std::string what(to_string(t.what().happenings.front().kind));
    ++n[what];
    if (!a.prepared) ++n["in preparation"];
    if (a.moving && !a.finishing) ++n["in a motion"];
    if (a.finishing) ++n["in finally"];
  }
}

const std::vector<std::string> kMotions{"force-stopped motions",
                                        "force-controlled rises",
                                        "holds",
                                        "contacts found",
                                        "stiffness measured",
                                        "polled rigs",
                                        "revision 1",
                                        "rigs that drift",
                                        "rigs with missing forces"};

TEST(Properties, TheTrueForceStaysWithinTheLimitAndThePrintedUncertainty) {
  Kind kind{"force", 1.5, false, 500, {}};
  sweep(
      kind,
      [](Trial& t, Counters&) { return both(force_within_limit(t), travel_within_limits(t)); },
      kMotions);
}

TEST(Properties, HealthyRunsAreAcceptedAndSucceed) {
  Kind kind{"healthy", 1, false, 0, {}};
  const Summary s = sweep(kind,
                          [](Trial& t, Counters& n) {
                            if (t.world().result && t.what().is_within) ++n["runs within"];
                            return both(both(healthy_runs_succeed(t), force_within_limit(t)),
                                        stiffness_is_not_underestimated(t));
                          },
                          {"runs within", "force-stopped motions", "stiffness measured"});
  const auto accepted = static_cast<double>(s.counters.at("accepted"));
  EXPECT_GE(accepted / static_cast<double>(s.pairs), 0.9) << "refused too often";
}

TEST(Properties, ALostHostStaysWithinTheSecondFigure) {
  Kind kind{"lost", 1, false, 300, lose_it};
  sweep(kind,
        [](Trial& t, Counters& n) {
          count_instants(t, n);
          return both(lost_within_the_second_figure(t), travel_within_limits(t));
        },
        {"in a motion", "deaf", "silent", "unplug", "losses"});
}

TEST(Properties, ALieIsNotPressedOnTwice) {
  Kind kind{"lies", 1, true, 300, {}};
  sweep(kind,
        [](Trial& t, Counters&) {
          return both(lies_are_not_pressed_again(t), ends_standing_and_honest(t));
        },
        {"predictions broken", "stopped by the guard", "ended fail"});
}

TEST(Properties, AfterAStopNothingMovesButFinally) {
  Kind kind{"stops", 1.5, false, 200, interrupt_it};
  sweep(kind,
        [](Trial& t, Counters& n) {
          count_instants(t, n);
          return both(both(nothing_moves_after_the_stop(t), ends_standing_and_honest(t)),
                      both(force_within_limit(t), travel_within_limits(t)));
        },
        {"abort", "freeze", "shutdown", "pause", "in preparation", "in a motion", "in finally",
         "left loaded, and said so"});
}

TEST(Properties, AStopThatWaitsFinishesWhatIsUnderWay) {
  Kind kind{kPlannedStops, 0.5, false, 0, stop_it_later};
  sweep(kind,
        [](Trial& t, Counters& n) {
          count_instants(t, n);
          return both(both(finishes_what_is_under_way(t), ends_standing_and_honest(t)),
                      both(force_within_limit(t), travel_within_limits(t)));
        },
        {"after_step", "after_level", "after_cycle", "after_repeat", "ended stopped",
         "ended success"});
}

TEST(Properties, AFaultLeavesTheRigStandingAndUnloadedOrSaysSo) {
  Kind kind{"faults", 1, false, 200, break_it};
  sweep(kind, [](Trial& t, Counters&) { return ends_standing_and_honest(t); },
        {"faults injected", "ended fail", "losses"});
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

TEST(Properties, ARefusalMovesNothingAndItsAdviceIsGood) {
  Kind kind{"refusals", 2, false, 900, {}};
  sweep(kind,
        [](Trial& t, Counters& n) {
          Broken out = refused_and_nothing_moved(t);
          if (!t.world().refused || t.world().refused->code != Errc::invalid_request) return out;
          return both(std::move(out), advice_is_good(t.what(), n));
        },
        {"refused", "refused with a number", "advice led to acceptance"});
}

// Too rare among random rigs for a sweep of this size: 3 of 1000 pairs.
TEST(Properties, ARefusalThatNoChangeHelpsIsTrue) {
  for (const char* name : {"no-change-helps-a-search", "no-change-helps-a-depth"}) {
    SCOPED_TRACE(name);
    const Case c = parse_case(text_of(fmt::format("tests/property/cases/{}.json", name)));
    Counters n;
    for (const std::string& b : advice_is_good(c, n)) ADD_FAILURE() << b;
    EXPECT_EQ(n["refused: no change helps"], 1);
  }
}

Broken judge_all(Trial& t) {
  if (!t.what().lies.empty()) {
    Counters none;
    return lies_come_out(t, none);
  }
  Broken out = both(force_within_limit(t), travel_within_limits(t));
  out = both(std::move(out), stiffness_is_not_underestimated(t));
  if (t.what().happenings.empty() && t.what().fault_script.empty()) {
    out = both(std::move(out), healthy_runs_succeed(t));
  }
  out = both(std::move(out), ends_standing_and_honest(t));
  out = both(std::move(out), nothing_moves_after_the_stop(t));
  out = both(std::move(out), lies_are_not_pressed_again(t));
  out = both(std::move(out), refused_and_nothing_moved(t));
  if (t.what().property == kPlannedStops) out = both(std::move(out), finishes_what_is_under_way(t));
  const bool lost = !t.what().happenings.empty() && is_of_link(t.what().happenings.front().kind);
  if (lost) out = both(std::move(out), lost_within_the_second_figure(t));
  Counters nowhere;
  const bool refused = t.world().refused && t.world().refused->code == Errc::invalid_request;
  if (refused) out = both(std::move(out), advice_is_good(t.what(), nowhere));
  return out;
}

TEST(Properties, CasesThatFailedOnceStayMended) {
  for (const auto& entry : std::filesystem::directory_iterator("tests/property/cases")) {
    if (entry.path().extension() != ".json") continue;
    SCOPED_TRACE(entry.path().filename());
    Trial t(parse_case(text_of(entry.path())));
    t.run();
    for (const std::string& b : judge_all(t)) ADD_FAILURE() << b;
  }
}

TEST(Properties, OneCase) {
  const char* path = std::getenv("LCRIG_CASE");
  if (path == nullptr) GTEST_SKIP() << "LCRIG_CASE=FILE plays one case and tells of it";
  Trial t(parse_case(text_of(path)));
  t.run();
  const RigWorld& w = t.world();
  fmt::print("{}\n", sim::describe(t.rig()));
  if (w.refused) fmt::print("refused: {}\n", w.refused->what);
  if (w.plan) {
    fmt::print("plan: worst {:.5g} N, lost {:.5g} N, uncertainty {:.3g} N, {:.4g} s\n",
               w.plan->worst_force_N, w.plan->lost_force_N, t.uncertainty_N(), w.plan->duration_s);
  }
  for (const RunEvent& e : w.events) {
    if (e.kind == EventKind::plan || e.kind == EventKind::state) continue;
    fmt::print("{:10.4f} {} {} {}\n", to_seconds(e.t.time_since_epoch()), e.kind.word(), e.step_id,
               e.detail);
  }
  for (std::size_t i = 0; i < w.changes.size(); ++i) {
    const auto& c = w.changes[i];
    fmt::print("{:10.4f} drive {} from {:.6f} mm {:.5g} N to {:.6g}{}\n",
               to_seconds(c.at.time_since_epoch()), static_cast<int>(c.drive), c.from_m * 1e3,
               c.force_N, c.to, w.was_finishing[i] ? " (finishing)" : "");
  }
  for (const RigWitness::Word& word : w.witness.words) {
    fmt::print("{:10.4f} {} {}\n", to_seconds(word.at.time_since_epoch()), word.is_sent ? ">" : "<",
               word.line);
  }
  if (w.result) fmt::print("{}: {}\n", to_string(w.result->exit_status), w.result->reason);
  fmt::print("true: peak {:.6g} N, at the end {:.6g} N, {}; outside {:.3g} um\n", w.all.peak_N,
             w.last_N, w.stood ? "stands" : "moves", w.outside_m * 1e6);
  for (const std::string& b : judge_all(t)) ADD_FAILURE() << b;
}

}  // namespace
}  // namespace lcrig::property
