// SPDX-License-Identifier: Apache-2.0
// The shipped protocols, unedited, on every random rig that has what they need.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

#include "tests/property/own_bounds.hpp"
#include "tests/property/reach.hpp"
#include "tests/support/rig_world.hpp"

namespace lcrig::property {
namespace {

constexpr double kPatience_s = 60;  // for an approach, so that the test does not take too long

// What the file demands of a rig, as a person reads it.
struct Needs {
  const char* file;
  double limit_N = 0, force_N = 0, overshoot_N = 0, speed_m_s = 0;
  double rate_N_s = 0;  // with force control
  double pressure_Pa = 0;  // held by force control
  double way_s = 0;  // longest time for one motion
};
constexpr Needs kShipped[] = {
    {"dynamic-cycles", 1.5, 1.0, 0.2, 0.016e-3, 0, 0, 200},
    {"preconditioning", 1.8, 1.3, 0.3, 0.02e-3, 0, 0, 350},
    {"static-frame", 1.6, 0, 0, 0.05e-3, 0.1, 100e3, 200},
    {"creep", 1.6, 0, 0, 0.05e-3, 0.2, 50e3, 200},
};
constexpr double kRise_N = 0.02, kClearance_m = 5e-3, kClearing_m_s = 0.5e-3;

double search_m_s(const Needs& n, const sim::RandomRig& rig) {
  const double room_N = n.limit_N - kRise_N - 0.05 * n.limit_N;
  return std::min(0.05e-3, kSlack * own_fastest_m_s(rig, kRise_N, kRise_N + 0.5 * room_N));
}

double likely_m(const sim::RandomRig& rig, double force_N) {
  const double frame_m = force_N / rig.plant.frame_stiffness_N_m;
  const double true_m = rig.specimen().shortening_m(force_N) + frame_m;
  return std::max(true_m, OwnContact(rig).generous_way_m(force_N));
}

bool has_travel(const Needs& n, const sim::RandomRig& rig) {
  const PlantConfig& p = rig.plant;
  const double inside_m = likely_m(rig, n.limit_N) + own_stopping_way_m(rig, n.speed_m_s);
  return p.contact_travel_m - p.travel_min_m > kClearance_m + 0.5e-3 &&
         p.travel_max_m - p.contact_travel_m > inside_m + 0.2e-3 && inside_m < 0.9e-3 &&
         inside_m / n.speed_m_s < n.way_s && rig.declared().speed_max.si() > 1.01 * kClearing_m_s;
}

bool has_loop(const Needs& n, const sim::RandomRig& rig) {
  const FrameCapabilities& c = rig.declared();
  const auto& loop = c.force_loop ? c.force_loop : rig.force_loop;
  if (!c.force_hold || !loop) return false;
  const OwnContact contact(rig);
  const double area_m2 = std::numbers::pi / 4 * rig.probe_diameter_m * rig.probe_diameter_m;
  const double held_N = n.pressure_Pa * area_m2, v = loop->approach.si();
  const double beyond_N = n.rate_N_s * to_seconds(loop->lag) + loop->ripple.si();
  const double begun_N = contact.force_after_N(loop->contact.si(), own_stopping_way_m(rig, v));
  // Contact must be above a drifting zero and below the lowest level.
  return held_N + beyond_N < kSlack * n.limit_N && n.rate_N_s < loop->rate_max.si() &&
         begun_N < kSlack * n.limit_N && 0.2e-3 / v < n.way_s &&
         loop->contact.si() < 0.02 * held_N &&
         contact.stiffness_N_m(1.1 * held_N) < kSlack * loop->stiffness_max.si();
}

bool can(const Needs& n, const sim::RandomRig& rig) {
  const FrameCapabilities& c = rig.declared();
  const PlantConfig& p = rig.plant;
  // The cell needs the range, a small offset before it is zeroed, and noise well below 0.02 N.
  const bool has_cell = c.force_max.si() > 1.05 * n.limit_N && p.force_noise_N < kRise_N / 12 &&
                        p.force_offset_N > -0.15 && p.force_offset_N < 0.45 &&
                        2 * rig.force_class_percent / 1000 * c.force_max.si() < kRise_N;
  if (!has_cell || !OwnContact(rig).is_bounded() || !has_travel(n, rig)) return false;
  if (search_m_s(n, rig) < 2 * c.speed_min.si()) return false;
  if (n.rate_N_s > 0) return has_loop(n, rig);
  const double most_N = std::min(n.force_N + n.overshoot_N, n.limit_N - 0.05);
  return kSlack * own_fastest_m_s(rig, n.force_N, most_N) > n.speed_m_s;
}

std::string shipped(const std::string& name) {
  std::ostringstream out;
  out << std::ifstream("protocols/library/" + name + ".json").rdbuf();
  return out.str();
}

std::int64_t wanted() {
  const char* pairs = std::getenv("LCRIG_PAIRS");
  return pairs == nullptr ? 1 : std::max<std::int64_t>(1, std::atoll(pairs) / 100);
}

void expect_success(const sim::RandomRig& rig, const std::string& name) {
  RigWorld w(rig, shipped(name));
  w.longest_s = 20000;
  w.run();
  SCOPED_TRACE(name + " on " + sim::describe(rig));
  ASSERT_FALSE(w.refused) << w.refused->what;
  EXPECT_EQ(w.result->exit_status, ExitStatus::success) << w.result->reason;
}

// A rig with a gap that takes no longer than kPatience_s.
sim::RandomRig near(std::uint64_t seed, const Needs& n, sim::RigOptions options = {}) {
  const sim::RandomRig far = sim::random_rig(seed, options);
  options.gap_m = std::clamp(kPatience_s * search_m_s(n, far), 5e-6, far.gap_m);
  return sim::random_rig(seed, options);
}

TEST(Properties, ShippedProtocolsSucceedUneditedOnEveryRigThatCan) {
  constexpr std::uint64_t kTries = 400;
  for (const Needs& n : kShipped) {
    std::int64_t found = 0;
    for (std::uint64_t seed = 1; seed < kTries * static_cast<std::uint64_t>(wanted()); ++seed) {
      if (!can(n, sim::random_rig(seed))) continue;
      expect_success(near(seed, n), n.file);
      if (++found >= wanted()) break;
    }
    EXPECT_GE(found, wanted()) << n.file << ": no rig has what it needs";
    RecordProperty(n.file, static_cast<int>(found));
  }
}

// A cell that errs within its class. Its range is so small that its zero does for kRise_N.
sim::RandomRig with_cell(std::uint64_t seed, const Needs& n, double class_percent) {
  constexpr double kNominal_N = 3;
  sim::RigOptions options;
  options.force_class_percent = class_percent;
  sim::RandomRig rig = near(seed, n, options);
  rig.plant.force_drift_N_s *= kNominal_N / rig.plant.force_nominal_N;
  rig.plant.force_nominal_N = kNominal_N;
  rig.frame.declared->force_max = Force::from_si(kNominal_N);
  return rig;
}

TEST(Properties, ShippedProtocolsSucceedUneditedOnCellsOfClass3And2) {
  for (const double percent : {3.0, 2.0}) {
    for (const Needs& n : kShipped) {
      std::int64_t found = 0;
      for (std::uint64_t seed = 1; seed < 4000 && found < 3 * wanted(); ++seed) {
        const sim::RandomRig rig = with_cell(seed, n, percent);
        const bool errs = std::abs(rig.plant.force_gain - 1) > 0.01;  // more than class 1 may
        if (!errs || !can(n, rig)) continue;
        expect_success(rig, n.file);
        ++found;
      }
      EXPECT_GE(found, 3 * wanted()) << n.file << ": no rig has what it needs";
    }
  }
}

TEST(Properties, FollowOnlyWatchesAnyFrameOfRevision2) {
  std::int64_t found = 0;
  for (std::uint64_t seed = 1; found < wanted(); ++seed) {
    const sim::RandomRig rig = sim::random_rig(seed);
    if (rig.frame.revision < 2) continue;
    ++found;
    expect_success(rig, "follow");
  }
}

// The frame of the issue: travel from 0 to 60 mm, specimen at 30 mm.
TEST(Properties, ShippedProtocolsSucceedWhereContactIsAt30Of60Mm) {
  for (const Needs& n : kShipped) {
    bool found = false;
    for (std::uint64_t seed = 1; seed < 2000 && !found; ++seed) {
      sim::RandomRig rig = near(seed, n);
      rig.plant.travel_min_m = 0;
      rig.plant.travel_max_m = 60e-3;
      rig.plant.contact_travel_m = 30e-3;
      rig.plant.start_travel_m = 30e-3 - rig.gap_m;
      rig.frame.declared->travel_min = Length::from_si(0);
      rig.frame.declared->travel_max = Length::from_si(60e-3);
      if (!can(n, rig)) continue;
      expect_success(rig, n.file);
      found = true;
    }
    EXPECT_TRUE(found) << n.file << ": no rig has what it needs";
  }
}

}  // namespace
}  // namespace lcrig::property
