// SPDX-License-Identifier: Apache-2.0
// What the queue remembers of the rig: plans, and the instruments of earlier turns.
#include "daemon/queue/plans.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "daemon/control/queue_messages.hpp"
#include "protocols/plan/plan.hpp"

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

TEST(QueuePlans, SayWhichPressureIsMeantWhereProbeAndDiscDiffer) {
  Plan plan;
  plan.pressure.probe_diameter_m = plan.pressure.disc_diameter_m = 8e-3;
  EXPECT_EQ(entry_plan(plan, true).pressure, "");
  plan.pressure.disc_diameter_m = 4e-3;
  const EntryPlan planned = entry_plan(plan, true);
  EXPECT_THAT(planned.pressure, testing::HasSubstr("400 kPa on the disc of 4 mm"));
  EXPECT_EQ(parse_entry_plan(to_json(planned).dump()).pressure, planned.pressure);
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
