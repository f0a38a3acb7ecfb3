// SPDX-License-Identifier: Apache-2.0
#include "model/plant.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "model/response.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

MonoTime at_s(double s) {
  return MonoTime(from_seconds(s));
}

class PlantTest : public testing::Test {
 protected:
  PlantTest() {
    config_.contact_travel_m = 2.5e-3;
    config_.frame_stiffness_N_m = 1e6;
    response_ = make_response(shipped("paper-1"), LevelSettings{}, 20.0_N, 1e-4).value();
    plant_ = std::make_unique<Plant>(*response_, config_);
  }
  PlantConfig config_;
  std::unique_ptr<TabulatedResponse> response_;
  std::unique_ptr<Plant> plant_;
};

TEST_F(PlantTest, TravelAndForceAreInverse) {
  for (double force = 1e-6; force < 40; force *= 1.3) {
    const double travel = plant_->travel_at_force_m(force);
    EXPECT_NEAR(travel - 2.5e-3, response_->shortening_m(force) + force / 1e6, 1e-15);
    EXPECT_NEAR(plant_->force_at_travel_N(travel), force, 1e-9 * force + 1e-12);
  }
  EXPECT_EQ(plant_->force_at_travel_N(2.5e-3), 0);
  EXPECT_EQ(plant_->force_at_travel_N(-1), 0);
}

TEST_F(PlantTest, ConstantSpeedArrivesOnTime) {
  plant_->move_to(at_s(10), 2e-3, 1e-3);
  EXPECT_EQ(plant_->arrival(), at_s(12));
  EXPECT_NEAR(plant_->travel_m(at_s(11)), 1e-3, 1e-15);
  EXPECT_EQ(plant_->travel_m(at_s(13)), 2e-3);
  EXPECT_EQ(plant_->force_N(at_s(13)), 0);
  plant_->move_to(at_s(14), 0, 1e-3);
  EXPECT_NEAR(plant_->travel_m(at_s(15)), 1e-3, 1e-15);
}

TEST_F(PlantTest, SpeedAndTravelKeepTheMachinesLimits) {
  plant_->move_to(at_s(0), 1.0, 1.0);
  EXPECT_NEAR(plant_->travel_m(at_s(1)), 0.01, 1e-12);
  EXPECT_EQ(plant_->travel_m(at_s(1000)), 0.1);
}

TEST_F(PlantTest, CrossingIsTheFirstInstantAtThatForce) {
  plant_->move_to(at_s(0), 3e-3, 16e-6);
  const auto t = plant_->force_crossing(1.0, at_s(0), at_s(1000));
  ASSERT_TRUE(t);
  EXPECT_GE(plant_->force_N(*t), 1.0);
  EXPECT_LT(plant_->force_N(*t - Duration(2)), 1.0);
  EXPECT_FALSE(plant_->force_crossing(1.0, at_s(0), *t - Duration(2)));
  EXPECT_FALSE(plant_->force_crossing(1.0, *t + Duration(1000), at_s(1000)));
  plant_->move_to(*t, 0, 16e-6);
  const auto clear = plant_->force_crossing(0, *t, at_s(1000));
  ASSERT_TRUE(clear);
  EXPECT_NEAR(plant_->travel_m(*clear), 2.5e-3, 1e-13);
}

TEST_F(PlantTest, HaltBrakesAlongAParabola) {
  config_.drive_lag_s = 0.01;
  config_.deceleration_m_s2 = 0.05;
  Plant plant(*response_, config_);
  plant.move_to(at_s(0), 0.05, 5e-3);
  plant.halt(at_s(1));
  const double stop = 5e-3 + 5e-3 * 0.01 + 25e-6 / (2 * 0.05);
  EXPECT_NEAR(plant.travel_m(at_s(1.005)), 5e-3 + 25e-6, 1e-12);
  EXPECT_NEAR(plant.travel_m(at_s(1.06)), 5.05e-3 + 5e-3 * 0.05 - 0.025 * 0.0025, 1e-12);
  EXPECT_NEAR(plant.travel_m(at_s(2)), stop, 1e-12);
  EXPECT_EQ(plant.arrival(), at_s(1.11));
  plant.halt(at_s(1.06));  // half way: 2.5 mm/s left, lag again
  EXPECT_NEAR(plant.travel_m(at_s(2)) - plant.travel_m(at_s(1.06)),
              2.5e-3 * 0.01 + 6.25e-6 / (2 * 0.05), 1e-12);
  plant.halt(at_s(3));
  EXPECT_FALSE(plant.arrival());
}

TEST_F(PlantTest, CrossingInsideTheParabolaIsFound) {
  config_.contact_travel_m = 0;
  Plant plant(*response_, config_);
  plant.move_to(at_s(0), 0.01, 1e-3);
  plant.halt(at_s(0));
  const double end = plant.force_N(at_s(1));
  const auto t = plant.force_crossing(0.9 * end, at_s(0), at_s(1));
  ASSERT_TRUE(t);
  EXPECT_GT(*t, at_s(0.001));
  EXPECT_NEAR(plant.force_N(*t), 0.9 * end, 1e-6 * end);
}

TEST_F(PlantTest, ForceRampApproachesThenRises) {
  plant_->ramp_force(at_s(0), 1.0, 0.1);
  EXPECT_EQ(plant_->force_N(at_s(2.4)), 0);
  EXPECT_NEAR(plant_->travel_m(at_s(1)), 1e-3, 1e-12);
  EXPECT_NEAR(plant_->force_N(at_s(2.5 + 5)), 0.5, 1e-9);
  EXPECT_NEAR(to_seconds(plant_->arrival()->time_since_epoch()), 12.5, 1e-6);
  EXPECT_EQ(plant_->force_N(at_s(20)), 1.0);
  EXPECT_NEAR(plant_->travel_m(at_s(20)), plant_->travel_at_force_m(1.0), 1e-15);
  const auto t = plant_->force_crossing(0.3, at_s(0), at_s(20));
  ASSERT_TRUE(t);
  EXPECT_NEAR(to_seconds(t->time_since_epoch()), 5.5, 1e-6);
}

TEST_F(PlantTest, HaltDuringForceControlHoldsTravel) {
  plant_->move_to(at_s(0), 2.5e-3, 5e-3);
  plant_->ramp_force(at_s(1), 1.0, 0.1);
  const double before = plant_->travel_m(at_s(6));
  plant_->halt(at_s(6));
  EXPECT_NEAR(plant_->travel_m(at_s(6)), before, 1e-15);
  EXPECT_GE(plant_->force_N(at_s(7)), 0.5);
  EXPECT_LT(plant_->force_N(at_s(7)), 0.501);
  EXPECT_EQ(plant_->force_N(at_s(7)), plant_->force_N(at_s(100)));
}

TEST_F(PlantTest, DeadWeightActsAtOnce) {
  plant_->put_load(at_s(0), 0.5);
  EXPECT_EQ(plant_->force_N(at_s(0)), 0.5);
  EXPECT_FALSE(plant_->arrival());
  EXPECT_NEAR(plant_->electrical(at_s(0)).capacitance_F, response_->capacitance_F(0.5), 1e-24);
  plant_->put_load(at_s(1), 0);
  EXPECT_NEAR(plant_->electrical(at_s(1)).capacitance_F, response_->c0_F(), 1e-24);
}

TEST_F(PlantTest, CreepFollowsItsPronyTermUnderHeldForce) {
  config_.creep_fraction = 0.03;
  config_.creep_time_s = 10;
  Plant plant(*response_, config_);
  plant.put_load(at_s(0), 0.5);
  EXPECT_EQ(plant.electrical(at_s(0)).capacitance_F, response_->capacitance_F(0.5));
  for (const double t : {1.0, 10.0, 30.0, 1000.0}) {
    const double q = 0.5 * -std::expm1(-t / 10);
    EXPECT_NEAR(plant.electrical(at_s(t)).capacitance_F, response_->capacitance_F(0.5 + 0.03 * q),
                1e-9 * response_->c0_F());
    EXPECT_EQ(plant.force_N(at_s(t)), 0.5);
  }
  plant.put_load(at_s(1000), 0);  // recovers the same way
  EXPECT_NEAR(plant.electrical(at_s(1010)).capacitance_F,
              response_->capacitance_F(0.03 * 0.5 * std::exp(-1)), 1e-9 * response_->c0_F());
}

TEST_F(PlantTest, CreepRelaxesForceUnderHeldTravel) {
  config_.creep_fraction = 0.05;
  config_.creep_time_s = 5;
  Plant plant(*response_, config_);
  plant.move_to(at_s(0), 2.5e-3 + 5e-6, 1e-3);
  const auto touched = plant.force_crossing(0.1, at_s(0), at_s(10));
  ASSERT_TRUE(touched);
  EXPECT_NEAR(plant.force_N(*touched), 0.1, 1e-6);
  const double fresh = plant.force_N(at_s(2.6));
  const double late = plant.force_N(at_s(100));
  EXPECT_LT(late, fresh);
  // Finally the specimen responds to 1.05 times the force, and the frame to the force itself.
  EXPECT_NEAR(response_->shortening_m(1.05 * late) + late / 1e6, 5e-6, 1e-12);
  const double c_fresh = plant.electrical(at_s(2.6)).capacitance_F;
  EXPECT_NEAR(plant.electrical(at_s(100)).capacitance_F, c_fresh, 1e-3 * c_fresh);
  EXPECT_EQ(plant.force_N(at_s(2.6)), fresh);  // looking back gives the same
}

// A meter answers after its window, so the drive may have turned since the middle of the window.
TEST_F(PlantTest, LooksBackBeyondChangesOfTheDrive) {
  for (const double creep : {0.0, 0.05}) {
    config_.creep_fraction = creep;
    Plant plant(*response_, config_);
    plant.move_to(at_s(0), 3e-3, 16e-6);
    const auto peak = plant.force_crossing(1.0, at_s(0), at_s(1000));
    ASSERT_TRUE(peak);
    const MonoTime before = *peak - from_seconds(0.06);
    const double force = plant.force_N(before), travel = plant.travel_m(before);
    const double capacitance = plant.electrical(before).capacitance_F;
    plant.halt(*peak);
    plant.move_to(*peak + from_seconds(0.01), 0, 16e-6);
    EXPECT_EQ(plant.force_N(before), force);
    EXPECT_EQ(plant.travel_m(before), travel);
    EXPECT_EQ(plant.electrical(before).capacitance_F, capacitance);
    EXPECT_LT(capacitance, response_->capacitance_F(0.97));
    EXPECT_LT(plant.force_N(*peak + from_seconds(0.06)), 0.97);  // it has turned
    for (int i = 1; i <= 1000; ++i) plant.move_to(*peak + from_seconds(i), i % 2 * 1e-3, 1e-3);
    EXPECT_EQ(plant.travel_m(*peak + from_seconds(999.5)), 0.5e-3);
  }
}

TEST_F(PlantTest, StrayAndDriftAdd) {
  config_.stray_capacitance_F = 1e-14;
  config_.thermal_drift_F_per_s = 1e-17;
  Plant plant(*response_, config_);
  EXPECT_NEAR(plant.electrical(at_s(100)).capacitance_F, response_->c0_F() + 1.1e-14, 1e-24);
  EXPECT_EQ(plant.electrical(at_s(100)).dissipation, 0.004);
}

}  // namespace
}  // namespace lcrig
