// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/parse.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/steps/find_contact.hpp"
#include "protocols/steps/move_until.hpp"
#include "protocols/steps/ramp.hpp"
#include "protocols/steps/set_lcr.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

Protocol shipped(const std::string& name) {
  auto r = load_protocol("protocols/library/" + name + ".json");
  if (!r) throw std::runtime_error(r.error().what);
  return *r;
}

TEST(ParseProtocol, ValuesAreSi) {
  const auto p = load_protocol("tests/corpus/protocol/accept/all_steps.json");
  ASSERT_TRUE(p) << p.error().what;
  const auto& contact = dynamic_cast<const FindContactStep&>(*p->steps.at(1).action);
  EXPECT_DOUBLE_EQ(contact.speed.value, 50e-6);
  EXPECT_DOUBLE_EQ(contact.force.value, 0.02);
  EXPECT_DOUBLE_EQ(contact.back_off.value, 0.5e-3);
  EXPECT_DOUBLE_EQ(contact.timeout.value, 300);
  const auto& ramp = dynamic_cast<const RampStep&>(*p->steps.at(2).action);
  EXPECT_DOUBLE_EQ(ramp.speed->value, 50e-6);
  EXPECT_EQ(ramp.to.kind, TargetKind::gap);
  const auto& until = dynamic_cast<const MoveUntilStep&>(*p->steps.at(4).action);
  EXPECT_EQ(until.until.value.name, "force_N");
  EXPECT_EQ(until.final_from->name, "share");
  const auto& set = dynamic_cast<const SetLcrStep&>(*p->steps.at(10).action);
  EXPECT_DOUBLE_EQ(set.frequency->value, 20e3);
  EXPECT_TRUE(set.bias_off);
  EXPECT_EQ(p->steps.at(4).pointer, "/steps/4");
}

TEST(ParseProtocol, SamplingOfFollowPollsEveryTenMilliseconds) {
  const Protocol p = shipped("follow");
  EXPECT_EQ(p.sample.lcr.function, LcrFunction::CpRp);
  EXPECT_DOUBLE_EQ(p.sample.lcr.frequency.si(), 20e3);
  EXPECT_EQ(p.sample.lcr.trigger, LcrTrigger::internal);
  EXPECT_EQ(*p.sample.lcr.poll_interval, std::chrono::milliseconds(10));
  EXPECT_EQ(p.on_loss, OnLoss::abort);
}

TEST(ParseProtocol, AutoApertureIsKeptForThePlan) {
  const auto p = load_protocol("tests/corpus/protocol/accept/minimal.json");
  ASSERT_TRUE(p);
  EXPECT_TRUE(p->sample.aperture_auto);
}

TEST(ParseProtocol, AnErrorNamesFileLineAndColumn) {
  const auto r = parse_protocol("{ \"format\": \"load-protocol/1\",\n  \"name\": 5 }", "x.json");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().what, "x.json:1:1 /: the key `limits` is missing, found format, name");
  EXPECT_NE(r.error().detail.find("x.json:2:11 /name: 5, expected a string"), std::string::npos);
}

TEST(BindParameters, DefaultsAndOverridesBecomeSi) {
  const Protocol p = shipped("dynamic-cycles");
  const auto env = bind_parameters(p, {{"speed_mm_s", "0.02"}, {"cycles", "7"}});
  ASSERT_TRUE(env) << env.error().what;
  EXPECT_DOUBLE_EQ(env->values().at("speed_mm_s"), 2e-5);
  EXPECT_DOUBLE_EQ(env->values().at("cycles"), 7);
  EXPECT_DOUBLE_EQ(env->values().at("force_N"), 1);
}

std::string bind_error(const std::string& name, const std::string& value) {
  const auto r = bind_parameters(shipped("dynamic-cycles"), {{name, value}});
  return r ? "bound" : r.error().what;
}

TEST(BindParameters, BadValuesNameTheParameterItsRangeAndUnit) {
  EXPECT_EQ(bind_error("force_N", "6"),
            "parameter force_N: 6 is out of range, expected 0.01 to 5 N");
  EXPECT_THAT(bind_error("force_N", "1,5"), HasSubstr("\"1,5\" is no number"));
  EXPECT_THAT(bind_error("force_N", "1,5"), HasSubstr("with a point: 1.5"));
  EXPECT_THAT(bind_error("force_N", "1,500"), HasSubstr("1.500 or 1500?"));
  EXPECT_THAT(bind_error("force_N", "1kN"), HasSubstr("its unit is N, by its name"));
  EXPECT_THAT(bind_error("force_N", ""), HasSubstr("is no number"));
  EXPECT_THAT(bind_error("force_N", "nan"), HasSubstr("is no number"));
  EXPECT_THAT(bind_error("force_N", "1 N"), HasSubstr("is no number"));
  EXPECT_THAT(bind_error("cycles", "2.5"), HasSubstr("is a fraction, expected a whole number"));
}

TEST(BindParameters, AnUnknownNameIsRefusedWithTheNearest) {
  EXPECT_THAT(bind_error("forse_N", "1"),
              HasSubstr("no parameter `forse_N`, did you mean `force_N`?"));
  EXPECT_THAT(bind_error("banana", "1"), HasSubstr("it has: cycles, force_N"));
  EXPECT_THAT(bind_error("force_mN", "1"), HasSubstr("`_mN` is not known here; it takes force_N"));
  EXPECT_THAT(bind_error("force", "1"), HasSubstr("`force` has no unit; it takes force_N"));
}

}  // namespace
}  // namespace lcrig
