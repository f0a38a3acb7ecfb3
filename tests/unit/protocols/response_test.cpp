// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/response.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

class Responding : public RunFixture {
 protected:
  void handle(EventKind kind) { parts().response.handle(kind, "detail"); }
  // The run no longer knows anything about the contact.
  void expect_no_place() {
    EXPECT_FALSE(parts().rig.contact.travel_m);
    EXPECT_FALSE(parts().rig.trust.force);
    EXPECT_TRUE(parts().rig.trust.no_pressing);
  }
};

TEST_F(Responding, AnEmergencyStopLeavesTheFrameToAPerson) {
  handle(EventKind::device_estop);
  ASSERT_TRUE(parts().drive.hands_off());
  EXPECT_THAT(parts().drive.hands_off()->what, HasSubstr("the frame reports estop (detail)"));
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
}

TEST_F(Responding, ANewZeroAtTheMachineLeavesOnlyTheWayAway) {
  parts().watch.place_contact(1e-3, 0);
  handle(EventKind::device_origin);
  expect_no_place();
  EXPECT_FALSE(parts().drive.hands_off()) << "away from the specimen it may still move";
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
}

TEST_F(Responding, AZeroThatTheRunAskedForIsNoNews) {
  parts().watch.place_contact(1e-3, 0);
  {
    const ScopedFlag zeroing = parts().response.expect_zero(true);
    handle(EventKind::device_origin);
  }
  EXPECT_TRUE(parts().rig.contact.travel_m);
  EXPECT_TRUE(parts().interrupts.empty());
  handle(EventKind::device_origin);
  EXPECT_FALSE(parts().interrupts.empty()) << "the next one is";
}

TEST_F(Responding, AZeroOfThisRunThatWasInterruptedIsBlamedOnNobody) {
  {
    const ScopedFlag zeroing = parts().response.expect_zero(true);
  }
  handle(EventKind::device_origin);
  EXPECT_THAT(parts().interrupts.take().why, HasSubstr("a `zero` of this run"));
}

TEST_F(Responding, AfterAZeroThatWasAnsweredANewOriginIsThatOfAPerson) {
  {
    const ScopedFlag zeroing = parts().response.expect_zero(true);
  }
  parts().response.zero_settled();
  handle(EventKind::device_origin);
  EXPECT_THAT(parts().interrupts.take().why, HasSubstr("at the machine"));
}

TEST_F(Responding, WhereTheOriginIsLostNothingMoves) {
  parts().watch.place_contact(1e-3, 0);
  parts().response.lose_origin("restarted");
  expect_no_place();
  EXPECT_TRUE(parts().drive.hands_off());
}

TEST_F(Responding, WhatIsNotBelievedDecidesWhatIsAllowed) {
  parts().response.act(Doubt::standstill, Response::stop, "it moves");
  EXPECT_TRUE(parts().rig.trust.force);
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
  parts().response.act(Doubt::force, Response::stop_and_retreat, "the force lies");
  EXPECT_FALSE(parts().rig.trust.force);
  EXPECT_TRUE(parts().drive.may_move());
  parts().response.act(Doubt::drive, Response::lock_out, "the drive lies");
  EXPECT_FALSE(parts().drive.may_move());
}

TEST_F(Responding, AFrameOfSomebodyElseMayReportWhatItLikes) {
  setup().commands = false;
  handle(EventKind::device_estop);
  handle(EventKind::device_origin);
  EXPECT_TRUE(parts().interrupts.empty());
}

}  // namespace
}  // namespace lcrig
