// SPDX-License-Identifier: Apache-2.0
#include "protocols/expand.hpp"

#include <gtest/gtest.h>

#include "protocols/steps/mark.hpp"
#include "protocols/steps/repeat.hpp"
#include "protocols/steps/sweep.hpp"

namespace lcrig {
namespace {

Step leaf(const std::string& id) {
  Step s;
  s.id = id;
  s.action = std::make_shared<MarkStep>();
  return s;
}
Step repeat(Number count, Steps steps) {
  Step s;
  RepeatStep r;
  r.count = std::move(count);
  r.steps = std::move(steps);
  s.action = std::make_shared<RepeatStep>(std::move(r));
  return s;
}
Step sweep(const std::string& name, std::vector<double> values, Steps steps) {
  Step s;
  SweepStep w;
  w.name = name;
  for (const double v : values) w.values.emplace_back(v);
  w.steps = std::move(steps);
  s.action = std::make_shared<SweepStep>(std::move(w));
  return s;
}
Steps list(std::initializer_list<Step> steps) {
  return Steps(steps);
}

TEST(StepCursor, YieldsLeavesInOrderOfExecution) {
  Environment env;
  const Steps steps = list({leaf("a"), repeat(Number(2), list({leaf("b"), leaf("c")})), leaf("d")});
  StepCursor cursor(steps, env);
  std::string seen;
  while (const Step* s = cursor.next()) seen += s->id + std::to_string(cursor.repeat()) + " ";
  EXPECT_EQ(seen, "a0 b1 c1 b2 c2 d0 ");
  EXPECT_EQ(cursor.next(), nullptr);
}

TEST(StepCursor, TheOutermostRepeatIsReported) {
  Environment env;
  const Steps steps = list({sweep(
      "x", {1, 2}, list({repeat(Number(3), list({repeat(Number(2), list({leaf("a")}))}))}))});
  StepCursor cursor(steps, env);
  std::string seen;
  while (cursor.next()) seen += std::to_string(cursor.repeat());
  EXPECT_EQ(seen, "112233112233");
}

TEST(StepCursor, SweepVariablesLiveAsLongAsTheirLoop) {
  Environment env;
  const Steps steps = list({sweep("p_kPa", {10e3, 20e3}, list({leaf("a")})), leaf("b")});
  StepCursor cursor(steps, env);
  cursor.next();
  EXPECT_EQ(env.values().at("p_kPa"), 10e3);
  cursor.next();
  EXPECT_EQ(env.values().at("p_kPa"), 20e3);
  EXPECT_EQ(cursor.loops().back().index, 2);
  cursor.next();
  EXPECT_TRUE(env.values().empty());
}

TEST(StepCursor, ALinearSweepEndsExactlyAtItsEnd) {
  Environment env;
  SweepStep s;
  s.from = Number(10e3);
  s.to = Number(100e3);
  s.count = Number(14);
  s.name = "f_Hz";
  const auto value = [&](std::int64_t pass) {
    s.set_variable(pass, env);
    return env.values().at("f_Hz");
  };
  EXPECT_EQ(value(1), 10e3);
  EXPECT_NEAR(value(2), 10e3 + 90e3 / 13, 1e-9);
  EXPECT_EQ(value(14), 100e3);
}

TEST(StepCursor, AnInnerCountMayFollowAnOuterVariable) {
  Environment env;
  Number n;
  n.name = "n";
  const Steps steps = list({sweep("n", {1, 3}, list({repeat(n, list({leaf("a")}))}))});
  StepCursor cursor(steps, env);
  int seen = 0;
  while (cursor.next()) ++seen;
  EXPECT_EQ(seen, 4);
}

TEST(StepCursor, AHundredThousandCyclesNeedNoList) {
  Environment env;
  const Steps steps = list({repeat(Number(100'000), list({leaf("a"), leaf("b")}))});
  StepCursor cursor(steps, env);
  std::int64_t seen = 0;
  while (cursor.next()) ++seen;
  EXPECT_EQ(seen, 200'000);
}

}  // namespace
}  // namespace lcrig
