// SPDX-License-Identifier: Apache-2.0
// What the frame holds after a step is stated twice: by the step's facts, for a run that continues
// another one and passes over the step, and by what the step does. Both must agree for each kind.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "protocols/file/step_kinds.hpp"
#include "protocols/run/take_over.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

// Steps of each kind. A new kind does not compile until it is here. Loops do nothing by themselves.
template <class Kind>
std::vector<std::string> steps_of() = delete;
template <>
std::vector<std::string> steps_of<ZeroStep>() {
  return {R"("force": true)"};
}
template <>
std::vector<std::string> steps_of<FindContactStep>() {
  return {R"("speed_mm_s": 0.01, "force_N": 0.02, "back_off_mm": 1, "timeout_s": 300)"};
}
template <>
std::vector<std::string> steps_of<RampStep>() {
  return {R"("to": { "travel_mm": 4.7 }, "speed_mm_s": 1, "timeout_s": 60)",
          R"("to": { "force_N": 0.01 }, "speed_mm_s": 0.01, "timeout_s": 60)",
          R"("to": { "force_N": 0.01 }, "force_rate_N_s": 0.1, "timeout_s": 60)"};
}
template <>
std::vector<std::string> steps_of<MoveUntilStep>() {
  return {R"("until": { "travel_mm": 4.7 }, "speed_mm_s": 1, "timeout_s": 60)",
          R"("until": { "force_N": 0.01 }, "speed_mm_s": 0.01, "timeout_s": 60)"};
}
template <>
std::vector<std::string> steps_of<HoldStep>() {
  return {R"("hold": "travel", "for_s": 1)", R"("hold": "force", "for_s": 1)",
          R"("hold": "force", "force_N": 0.4, "for_s": 1)"};
}
template <>
std::vector<std::string> steps_of<MeasureStep>() {
  return {R"("count": 2, "within_s": 1)"};
}
template <>
std::vector<std::string> steps_of<PlaceWeightStep>() {
  return {R"("mass_g": 10)"};
}
template <>
std::vector<std::string> steps_of<RecordStep>() {
  return {R"("for_s": 1)"};
}
template <>
std::vector<std::string> steps_of<SetLcrStep>() {
  return {R"("average": 2)"};
}
template <>
std::vector<std::string> steps_of<RepeatStep>() {
  return {};
}
template <>
std::vector<std::string> steps_of<SweepStep>() {
  return {};
}
template <>
std::vector<std::string> steps_of<MarkStep>() {
  return {R"("text": "here")"};
}
template <>
std::vector<std::string> steps_of<SetGapStep>() {
  return {R"("gap_mm": 1)"};
}
template <>
std::vector<std::string> steps_of<AskStep>() {
  return {R"("text": "?", "answer": "line", "default": "x", "timeout_s": 1,
             "on_timeout": "default")"};
}

constexpr double kHeldBefore_N = 0.25;

// A run of one such step, at a specimen that begins 0.2 mm below the probe.
class HoldingRun final : public RunFixture {
 public:
  HoldingRun(std::string_view kind, const std::string& keys) {
    std::string text(kProtocol);
    const auto steps = text.find("\"steps\""), last = text.find("\"finally\"");
    text.replace(steps, last - steps,
                 fmt::format(R"("steps": [ {{ "id": "a", "do": "{0}", {1} }},
                                           {{ "id": "b", "do": "{0}", {1} }} ], )",
                             kind, keys));
    protocol = parse_protocol(text, "t").value();
    frame.abilities().force_hold = true;
    ForceLoop& loop = frame.abilities().force_loop.emplace();
    loop.approach = Velocity::from_si(1e-5);
    loop.rate_max = ForceRate::from_si(1);
    loop.stiffness_max = Stiffness::from_si(1e6);
    frame.noise_N = 1e-4;
    frame.travel_m = 4.8e-3;
    frame.force_at = [](double travel_m) { return 1e4 * std::max(0.0, travel_m - 5e-3); };
    feed();
    parts().watch.learn_zero(run(parts().meter.measure_alive()).value());
    parts().drive.will_hold(kHeldBefore_N);
  }
  void TestBody() override {}

  std::optional<double> after_execution() {
    parts().log.begin_step(step(0));
    const auto done = run(execute(step(0)));
    EXPECT_TRUE(done) << kind_of(step(0)) << ": " << done.error().what;
    return parts().drive.held_force_N();
  }
  std::optional<double> after_passing_over() {
    Continuation from;
    from.step_id = "b";
    from.point.steps_done = 1;
    from.frame.force_N = 0;
    from.frame.travel_m = frame.travel_m;
    setup().continues = from;
    StepCursor cursor(protocol.steps, values);
    TakeOver take_over(parts());
    const auto passed = run(take_over.pass_done_steps(cursor));
    EXPECT_TRUE(passed) << kind_of(step(0)) << ": " << passed.error().what;
    return parts().drive.held_force_N();
  }

 private:
  Task<Result<>> execute(const Step& step) {
    const auto progress = step.action->new_progress();
    parts().labels.aim(facts_of(step));
    auto task = step.action->execute(parts(), *progress);
    co_return co_await std::move(task);
  }
};

template <class Kind>
void expect_that_facts_are_true() {
  for (const std::string& keys : steps_of<Kind>()) {
    HoldingRun executes(Kind::kWord, keys), passes(Kind::kWord, keys);
    const auto did = executes.after_execution(), says = passes.after_passing_over();
    EXPECT_EQ(did.has_value(), says.has_value()) << Kind::kWord << " " << keys;
    EXPECT_NEAR(did.value_or(0), says.value_or(0), 1e-3) << Kind::kWord << " " << keys;
  }
}

TEST(HeldForce, IsAfterEachKindOfStepWhatItsFactsSay) {
  const auto each = []<class... Kind>(std::tuple<Kind...>*) {
    (expect_that_facts_are_true<Kind>(), ...);
  };
  each(static_cast<StepKinds*>(nullptr));
}

TEST(HeldForce, EndsWithAMotionAndOutlastsAReading) {
  EXPECT_FALSE(HoldingRun("ramp", steps_of<RampStep>()[0]).after_execution());
  EXPECT_EQ(HoldingRun("measure", steps_of<MeasureStep>()[0]).after_execution(), kHeldBefore_N);
  EXPECT_EQ(HoldingRun("hold", steps_of<HoldStep>()[2]).after_execution(), 0.4);
}

}  // namespace
}  // namespace lcrig
