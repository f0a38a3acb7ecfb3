// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/distrust.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

class Doubt : public RunFixture {
 protected:
  void heed(EventKind kind) { parts().distrust.heed(kind, "detail"); }
  // The run no longer knows anything about the contact.
  void expect_no_place() {
    EXPECT_FALSE(parts().contact.travel_m());
    EXPECT_TRUE(parts().guard.is_distrusted());
    EXPECT_TRUE(parts().pressing->broken());
  }
};

TEST_F(Doubt, AnEmergencyStopLeavesTheFrameToAPerson) {
  heed(EventKind::device_estop);
  ASSERT_TRUE(parts().drive.hands_off());
  EXPECT_THAT(parts().drive.hands_off()->what, HasSubstr("the frame reports estop (detail)"));
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
}

TEST_F(Doubt, ANewZeroAtTheMachineLeavesOnlyTheWayAway) {
  parts().contact.place(1e-3, 0);
  heed(EventKind::device_origin);
  expect_no_place();
  EXPECT_FALSE(parts().drive.hands_off()) << "away from the specimen it may still move";
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
}

TEST_F(Doubt, AZeroThatTheRunAskedForIsNoNews) {
  parts().contact.place(1e-3, 0);
  {
    const ScopedFlag zeroing = parts().distrust.expect_zero();
    heed(EventKind::device_origin);
  }
  EXPECT_TRUE(parts().contact.travel_m());
  EXPECT_TRUE(parts().interrupts.empty());
  heed(EventKind::device_origin);
  EXPECT_FALSE(parts().interrupts.empty()) << "the next one is";
}

TEST_F(Doubt, AZeroOfThisRunThatWasInterruptedIsBlamedOnNobody) {
  {
    const ScopedFlag zeroing = parts().distrust.expect_zero();
  }
  heed(EventKind::device_origin);
  EXPECT_THAT(parts().interrupts.take().why, HasSubstr("a `zero` of this run"));
}

TEST_F(Doubt, AfterAZeroThatWasAnsweredANewOriginIsThatOfAPerson) {
  {
    const ScopedFlag zeroing = parts().distrust.expect_zero();
  }
  parts().distrust.zero_settled();
  heed(EventKind::device_origin);
  EXPECT_THAT(parts().interrupts.take().why, HasSubstr("at the machine"));
}

TEST_F(Doubt, WhereTheOriginIsLostNothingMoves) {
  parts().contact.place(1e-3, 0);
  parts().distrust.lose_origin("restarted");
  expect_no_place();
  EXPECT_TRUE(parts().drive.hands_off());
}

TEST_F(Doubt, WhatIsNotBelievedDecidesWhatIsAllowed) {
  parts().distrust.disbelieve(Contradiction(Disbelief::stillness, "it moves"));
  EXPECT_FALSE(parts().guard.is_distrusted());
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
  parts().distrust.disbelieve(Contradiction(Disbelief::force, "the force lies"));
  EXPECT_TRUE(parts().guard.is_distrusted());
  EXPECT_TRUE(parts().drive.may_move());
  parts().distrust.disbelieve(Contradiction(Disbelief::drive, "the drive lies"));
  EXPECT_FALSE(parts().drive.may_move());
}

TEST_F(Doubt, AFrameOfSomebodyElseMayReportWhatItLikes) {
  setup().commands = false;
  heed(EventKind::device_estop);
  heed(EventKind::device_origin);
  EXPECT_TRUE(parts().interrupts.empty());
}

}  // namespace
}  // namespace lcrig
