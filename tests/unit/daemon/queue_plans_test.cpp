// SPDX-License-Identifier: Apache-2.0
// What the queue remembers of the rig: plans, and the instruments of earlier turns.
#include "daemon/queue/plans.hpp"

#include <gmock/gmock.h>

namespace lcrig {
namespace {

Identity instrument(const std::string& serial) {
  Identity out;
  out.text = "maker,model," + serial;
  out.model = "model";
  out.serial = serial;
  return out;
}

TEST(KnownIdentities, AreThoseOfTheFirstTurn) {
  KnownIdentities known;
  const auto meter = instrument("m1"), frame = instrument("f1");
  EXPECT_TRUE(known.compare(meter, frame, false));
  EXPECT_TRUE(known.compare(meter, frame, false));
  const auto other = known.compare(instrument("m2"), frame, false);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Errc::refused);
  EXPECT_THAT(other.error().what, testing::HasSubstr("m2"));
  EXPECT_FALSE(known.compare(meter, instrument("f2"), false));
  EXPECT_TRUE(known.compare(meter, frame, false)) << "the first ones stay";
}

TEST(KnownIdentities, OfARodAreNotThoseOfTheFrame) {
  KnownIdentities known;
  const auto meter = instrument("m1");
  EXPECT_TRUE(known.compare(meter, instrument("f1"), false));
  EXPECT_TRUE(known.compare(meter, instrument("rod"), true));
  EXPECT_FALSE(known.compare(meter, instrument("f1"), true));
  EXPECT_TRUE(known.compare(meter, instrument("f1"), false));
}

TEST(QueuePlans, AreFoundByWhatAPlanDependsOn) {
  QueuePlans plans;
  RunRequest run;
  run.protocol_text = "{}";
  run.specimen_text = "paper";
  EXPECT_FALSE(plans.find(run));
  EntryPlan plan;
  plan.duration_s = 12;
  plans.keep(run, plan);
  run.note = "another note";
  ASSERT_TRUE(plans.find(run));
  EXPECT_EQ(plans.find(run)->duration_s, 12);
  run.parameters["repeats"] = 2.0;
  EXPECT_FALSE(plans.find(run));
  run.parameters.clear();
  plans.forget();
  EXPECT_FALSE(plans.find(run));
}

}  // namespace
}  // namespace lcrig
