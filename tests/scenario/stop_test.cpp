// SPDX-License-Identifier: Apache-2.0
// Every stop in every kind of step, in virtual time: the frame stands soon, `finally` runs once and
// to its end, and the run is closed with the true reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "protocols/file/parse.hpp"
#include "protocols/file/step_kinds.hpp"
#include "storage/chain.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// A rod reports its force at most ten times a second, hence `rate_Hz`.
std::string head(const std::string& rate_Hz) {
  return R"({ "format": "load-protocol/1", "name": "stops",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": )" +
         rate_Hz + " } }, ";
}

const std::string kFrame = head("50") + R"(
  "steps": [
    { "id": "mark", "do": "mark", "text": "begin" },
    { "id": "gap", "do": "set_gap", "gap_mm": 3 },
    { "id": "ask", "do": "ask", "text": "Ready?", "answer": "confirmation", "timeout_s": 600 },
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "loop", "do": "repeat", "count": 2, "steps": [
      { "id": "sweep", "do": "sweep", "name": "f_N", "values": [0.3, 0.5], "steps": [
        { "id": "load", "do": "move_until", "until": { "force_N": "$f_N" }, "speed_mm_s": 0.01, "timeout_s": 60 } ] },
      { "id": "ramp", "do": "ramp", "to": { "force_N": 0.4 }, "force_rate_N_s": 0.05, "timeout_s": 60 },
      { "id": "hold_force", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 2 },
      { "id": "level", "do": "measure", "count": 20, "within_s": 4 },
      { "id": "hold_travel", "do": "hold", "hold": "travel", "for_s": 2 },
      { "id": "set", "do": "set_lcr", "average": 2 },
      { "id": "record", "do": "record", "for_s": 2 },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.1, "timeout_s": 60 } ] } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

const std::string kWeights = head("10") + R"(
  "steps": [
    { "id": "place", "do": "place_weight", "force_N": 0.5 },
    { "id": "level", "do": "measure", "count": 5, "within_s": 4 },
    { "id": "until", "do": "record", "until": "confirmed", "timeout_s": 60 } ],
  "finally": [ { "id": "off", "do": "place_weight", "mass_g": 0 } ] })";

// How the run is stopped. For SIGTERM and SIGINT this is what App::shut_down sends to the run.
enum class Cause { sigterm, sigint, abort, freeze, limit, client_gone };

const char* word(Cause c) {
  switch (c) {
    case Cause::sigterm: return "SIGTERM";
    case Cause::sigint: return "SIGINT";
    case Cause::abort: return "abort";
    case Cause::freeze: return "freeze";
    case Cause::limit: return "limit";
    case Cause::client_gone: return "client_gone";
  }
  return "?";
}

void act(SessionWorld& w, Cause cause) {
  switch (cause) {
    case Cause::sigterm:
    case Cause::sigint: return w.interrupt(Interrupt::abort, word(cause));
    case Cause::abort: return w.interrupt(Interrupt::abort, "by a person");
    case Cause::freeze: return w.interrupt(Interrupt::freeze, "by a person");
    case Cause::limit: return w.interrupt(Interrupt::limit, "force 1.1 N is outside the limits");
    // the client that started it goes away, but the run belongs to the daemon
    case Cause::client_gone: return;
  }
}

struct StepStop {
  std::string step;
  Cause cause;
  bool weights;
};

void walk_steps(const Steps& steps, const std::function<void(const Step&)>& what) {
  for (const Step& step : steps) {
    what(step);
    if (const Loop* loop = facts_of(step).loop) walk_steps(loop->steps, what);
  }
}

// Nothing can happen in a step that takes no time. A loop is no step of a run.
bool takes_time(const Step& step) {
  return kind_of(step) != MarkStep::kWord && kind_of(step) != SetGapStep::kWord &&
         !facts_of(step).loop;
}

std::vector<StepStop> every_stop() {
  std::vector<StepStop> out;
  for (const Cause cause : {Cause::sigterm, Cause::sigint, Cause::abort, Cause::freeze,
                            Cause::limit, Cause::client_gone}) {
    for (const bool weights : {false, true}) {
      const Protocol protocol = parse_protocol(weights ? kWeights : kFrame, "stops").value();
      walk_steps(protocol.steps, [&](const Step& step) {
        if (takes_time(step)) out.push_back({step.id, cause, weights});
      });
    }
  }
  return out;
}

TEST(Stops, ComeInEachKindOfStep) {
  std::set<std::string_view> kinds;
  for (const std::string& text : {kFrame, kWeights}) {
    const Protocol protocol = parse_protocol(text, "stops").value();
    walk_steps(protocol.steps, [&](const Step& step) { kinds.insert(kind_of(step)); });
  }
  const auto look_for = [&]<class... Kind>(std::tuple<Kind...>*) {
    for (const std::string_view word : {Kind::kWord...}) EXPECT_TRUE(kinds.contains(word)) << word;
  };
  look_for(static_cast<StepKinds*>(nullptr));
}

std::int64_t steps_ended(const SessionWorld& world, const char* step, const char* how) {
  return world.count(
      std::string("SELECT COUNT(*) FROM event WHERE kind = 'step_end' AND step_id = '") + step +
      "' AND detail = '" + how + "'");
}

class EveryStop : public ::testing::TestWithParam<StepStop> {};

TEST_P(EveryStop, StopsTheFrameRunsFinallyOnceAndClosesTheRun) {
  const auto [step, cause, weights] = GetParam();
  SessionWorld world(weights ? kWeights : kFrame);
  world.in_memory = true;
  MonoTime asked;
  world.acts.push_back({step, 300ms, [&, c = cause](SessionWorld& w) {
                          asked = w.clock.now();
                          act(w, c);
                        }});
  // A second signal in the middle of `finally` changes nothing.
  const char* last = weights ? "off" : "clear";
  world.acts.push_back(
      {last, 100ms, [](SessionWorld& w) { w.interrupt(Interrupt::abort, "a second signal"); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(world.clock.pending(), 0U) << "a task still waits";
  const auto chain = verify_chain(world.open(), 1);
  ASSERT_TRUE(chain);
  EXPECT_TRUE(chain->intact) << chain->finding;
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM run_end"), 1);
  EXPECT_EQ(steps_ended(world, last, "done"), cause == Cause::freeze ? 0 : 1);
  if (cause == Cause::client_gone) {
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    return;
  }
  EXPECT_EQ(r->exit_status, cause == Cause::limit ? ExitStatus::fail : ExitStatus::abort);
  EXPECT_THAT(r->reason, HasSubstr(cause == Cause::sigterm  ? "SIGTERM"
                                   : cause == Cause::sigint ? "SIGINT"
                                   : cause == Cause::limit  ? "outside the limits"
                                                            : "by a person"));
  if (weights) return;
  const auto stopped =
      world.count("SELECT MIN(at_mono_ns) FROM event WHERE kind = 'stopped' AND at_mono_ns >= " +
                  std::to_string(asked.time_since_epoch().count()));
  EXPECT_LT(Duration(stopped) - asked.time_since_epoch(), 100ms);
  EXPECT_LT(world.real("SELECT MAX(force_N) FROM frame_sample"), 1.02) << "limit 1 N";
}

INSTANTIATE_TEST_SUITE_P(InEveryStep, EveryStop, ::testing::ValuesIn(every_stop()),
                         [](const auto& c) {
                           return std::string(word(c.param.cause)) + "_" + c.param.step +
                                  (c.param.weights ? "_weights" : "");
                         });

}  // namespace
}  // namespace lcrig
