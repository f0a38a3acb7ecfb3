// SPDX-License-Identifier: Apache-2.0
// What the search proposes for a target.
#include "budget/search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/protocols/planned.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

Budget reckoned(const std::string& name, double target, const ParameterValues& changed = {}) {
  const auto protocol = load_protocol("protocols/library/" + name + ".json").value();
  const auto environment = bind_parameters(protocol, changed).value();
  const Rig rig = frame_rig();
  SpecimenCurve curve;
  curve.c0_F = 4e-12;
  curve.delta_C_fF = [](double kPa) { return 600 * kPa / (kPa + 60); };
  return reckon_budget(
      {protocol, environment, rig, curve, {Aperture::fast}, {100e3}, target, AnalysisOptions()});
}

// One cycle scatters little enough, but says nothing about differences between cycles.
TEST(Search, OneCycleIsNotProposed) {
  const Budget b = reckoned("dynamic-cycles", 0.5);
  ASSERT_TRUE(b.cheapest);
  EXPECT_EQ(b.cheapest->parameters.at("cycles"), 2);
  ASSERT_FALSE(b.settings[0].curve.empty());
  EXPECT_EQ(b.settings[0].curve.front().parameters.at("cycles"), 2);
}

TEST(Search, OneRepeatIsNotProposed) {
  const Budget b = reckoned("static-frame", 0.5, {{"repeats", "1"}});
  EXPECT_THAT(b.settings[0].planned.note, HasSubstr("one repeat: the interval knows nothing"));
  ASSERT_TRUE(b.cheapest);
  EXPECT_EQ(b.cheapest->parameters.at("repeats"), 3);
}

TEST(Search, OneCycleThatIsAskedForSaysWhatItCannotKnow) {
  const Budget b = reckoned("dynamic-cycles", 0.5, {{"cycles", "1"}});
  EXPECT_THAT(b.settings[0].planned.note, HasSubstr("one cycle: the interval knows nothing"));
  EXPECT_FALSE(b.settings[0].planned.meets(0.5));
}

// One range of three lies beyond every peak; the others meet the target.
TEST(Search, AResultThatCannotBePredictedIsUnmet) {
  const auto protocol = load_protocol("protocols/library/dynamic-cycles.json").value();
  const auto environment = bind_parameters(protocol, {}).value();
  const Rig rig = frame_rig();
  SpecimenCurve curve;
  curve.c0_F = 4e-12;
  curve.delta_C_fF = [](double kPa) { return 600 * kPa / (kPa + 60); };
  AnalysisOptions options;
  options.ranges.push_back({500, 600});  // no cycle comes there
  const Budget b =
      reckon_budget({protocol, environment, rig, curve, {Aperture::fast}, {100e3}, 0.5, options});
  const BudgetPoint& planned = b.settings[0].planned;
  EXPECT_THAT(planned.not_predicted, testing::ElementsAre("sensitivity 500-600 kPa"));
  EXPECT_LE(planned.worst_half_width, 0.5);
  EXPECT_FALSE(planned.meets(0.5));
  EXPECT_FALSE(b.settings[0].to_target);
  EXPECT_FALSE(b.cheapest);
  options.ranges.pop_back();
  EXPECT_TRUE(
      reckon_budget({protocol, environment, rig, curve, {Aperture::fast}, {100e3}, 0.5, options})
          .cheapest);
}

}  // namespace
}  // namespace lcrig
