// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/levels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "protocols/steps/find_contact.hpp"
#include "protocols/steps/measure.hpp"

namespace lcrig {
namespace {

constexpr double kArea_m2 = 2e-4, kGravity_m_s2 = 9.81;

PressureArea over_probe() {
  PressureArea out;
  out.probe_diameter_m = std::sqrt(4 * kArea_m2 / std::numbers::pi);
  return out;
}

Target target(TargetKind kind, double value) {
  Target t;
  t.kind = kind;
  t.value = Number(value);
  return t;
}

class Levels : public ::testing::Test {
 protected:
  void aim(TargetKind kind, double value) {
    const Target to = target(kind, value);
    labels.aim(StepFacts(FrameUse::hold(HoldMode::force, &to), kNoReadings, kNoSettings,
                         kNoQuestion, kNoLoop));
  }
  LoadLevel next() { return labels.next("m", 5, MonoTime()); }

  Environment environment;
  LevelLabels labels{environment, over_probe(), kGravity_m_s2};
};

TEST_F(Levels, AreNumberedThroughTheRunAndWithinEachRepeat) {
  EXPECT_EQ(next().level, 1);
  labels.enter_repeat(1);
  EXPECT_EQ(next().index, 1);
  EXPECT_EQ(next().index, 2);
  labels.enter_repeat(2);
  const LoadLevel level = next();
  EXPECT_EQ(level.level, 4);
  EXPECT_EQ(level.repeat, 2);
  EXPECT_EQ(level.index, 1);
}

TEST_F(Levels, CarryTheForceThatTheLastLoadStepAimedAt) {
  aim(TargetKind::force, 0.5);
  const LoadLevel level = next();
  EXPECT_DOUBLE_EQ(*level.target_force_N, 0.5);
  EXPECT_DOUBLE_EQ(*level.target_pressure_Pa, 0.5 / kArea_m2);
  EXPECT_EQ(level.planned_readings, 5);
}

TEST_F(Levels, OfAPressureCarryItsForce) {
  aim(TargetKind::pressure, 1000);
  EXPECT_DOUBLE_EQ(*next().target_force_N, 1000 * kArea_m2);
}

// A stored pressure is over the probe, also where the protocol states it on the disc.
TEST_F(Levels, OfAPressureOnTheDiscCarryTheForceOverTheDisc) {
  PressureArea pressure = over_probe();
  pressure.disc_diameter_m = *pressure.probe_diameter_m / 2;
  pressure.on = PressureOn::disc;
  LevelLabels on_disc(environment, pressure, kGravity_m_s2);
  const Target to = target(TargetKind::pressure, 1000);
  on_disc.aim(StepFacts(FrameUse::hold(HoldMode::force, &to), kNoReadings, kNoSettings, kNoQuestion,
                        kNoLoop));
  const LoadLevel level = on_disc.next("m", 5, MonoTime());
  EXPECT_DOUBLE_EQ(*level.target_force_N, 1000 * kArea_m2 / 4);
  EXPECT_DOUBLE_EQ(*level.target_pressure_Pa, 250);
}

TEST_F(Levels, AtATravelCarryNoForce) {
  aim(TargetKind::force, 0.5);
  aim(TargetKind::gap, 1e-3);
  EXPECT_FALSE(next().target_force_N);
  EXPECT_FALSE(next().target_pressure_Pa);
}

TEST_F(Levels, UnderAWeightCarryItsForce) {
  aim(TargetKind::mass, 0.1);
  EXPECT_DOUBLE_EQ(*next().target_force_N, 0.1 * kGravity_m_s2);
}

TEST_F(Levels, KeepTheirForceUntilAMotionGoesElsewhere) {
  aim(TargetKind::force, 0.5);
  labels.aim(MeasureStep().facts());
  EXPECT_DOUBLE_EQ(*next().target_force_N, 0.5);
  labels.aim(FindContactStep().facts());
  EXPECT_FALSE(next().target_force_N);
}

TEST_F(Levels, AnAbandonedOneKeepsItsPlaceAndGetsANewNumber) {
  labels.enter_repeat(1);
  next();
  labels.abandon();
  const LoadLevel again = next();
  EXPECT_EQ(again.level, 2);
  EXPECT_EQ(again.index, 1);
}

TEST_F(Levels, OfARunThatGoesOnCountOn) {
  labels.enter_repeat(3);
  next();
  next();
  RunPoint point;
  labels.write_to(point);
  LevelLabels later(environment, over_probe(), kGravity_m_s2);
  later.take_from(point);
  later.enter_repeat(3);
  const LoadLevel level = later.next("m", 5, MonoTime());
  EXPECT_EQ(level.level, 3);
  EXPECT_EQ(level.index, 3);
}

}  // namespace
}  // namespace lcrig
