// SPDX-License-Identifier: Apache-2.0
// The stiffness that looks at a frame reveal, on drives with and without lost motion.
#include "protocols/contact/contact_slope.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/relaxing_contact.hpp"

namespace lcrig {
namespace {

constexpr std::size_t kSamples = 15;  // of a look
constexpr double kNoContact_N = 0.1;  // of the force where it touched

struct DriveWithPlay {
  double stiffness_N_m = 41e3;
  double play_m = 0, digit_m = 1e-7, noise_N = 5e-4;
  double relaxes = 0;  // share of the force, over all looks together
};

// Steps back from `felt_N`, doubling each step, until a third of the force is left.
class WayBack {
 public:
  WayBack(const DriveWithPlay& drive, double felt_N, unsigned seed) : drive_(drive), random_(seed) {
    const double depth_m = felt_N / drive.stiffness_N_m;
    look(felt_N, 0);
    double left_N = felt_N;
    for (double step_m = std::max(2e-7, drive.digit_m); left_N > felt_N / 3; step_m *= 2) {
      const double back_m = std::max(0.0, step_m - drive.play_m);
      left_N = drive.stiffness_N_m * std::max(0.0, depth_m - back_m);
      look(left_N, step_m);
      if (left_N > kNoContact_N * felt_N) ++touching_;
    }
  }
  std::optional<ContactSlope> slope() const { return contact_slope(looks_, touching_, facts()); }
  double proven_N_m() const { return proven_stiffness_N_m(looks_, facts()); }

 private:
  RetreatFacts facts() const {
    return {looks_.front().force_N(), 0, 0, std::max(2e-7, drive_.digit_m)};
  }
  void look(double force_N, double back_m) {
    std::normal_distribution<double> noise(0, drive_.noise_N);
    const double travel_m = std::round((6.01145e-3 - back_m) / drive_.digit_m) * drive_.digit_m;
    const double relaxed = 1 - drive_.relaxes * static_cast<double>(looks_.size()) / 8;
    std::vector<FrameSample> samples(kSamples);
    for (FrameSample& s : samples) {
      s.force_N = force_N * relaxed + noise(random_);
      s.travel_m = travel_m;
    }
    looks_.emplace_back().add(samples);
  }

  const DriveWithPlay drive_;
  std::mt19937 random_;
  std::vector<RestMeasurement> looks_;
  std::size_t touching_ = 1;
};

TEST(ContactSlope, IsMeasuredOnADriveWithoutPlay) {
  const auto slope = WayBack(DriveWithPlay(), 0.35, 1).slope();
  ASSERT_TRUE(slope);
  EXPECT_NEAR(slope->about, 41e3, 2e3);
  EXPECT_LE(slope->at_least, 41e3);
  EXPECT_GE(slope->at_most, 41e3);
  EXPECT_LT(slope->at_most, 1.1 * 41e3);
}

TEST(ContactSlope, IsMeasuredBehindThePlay) {
  DriveWithPlay drive;
  drive.play_m = 1.5e-6;
  const auto slope = WayBack(drive, 0.35, 1).slope();
  ASSERT_TRUE(slope);
  EXPECT_LE(slope->at_least, 41e3);
  EXPECT_GE(slope->at_most, 41e3);
  EXPECT_LT(slope->at_most, 1.2 * 41e3);
}

// The force fell a little on the first step after the play, and was gone after the next one.
TEST(ContactSlope, IsNotToldWhereThePlayTookUpTheWay) {
  DriveWithPlay drive;
  drive.stiffness_N_m = 280e3;
  drive.play_m = 3e-6;
  EXPECT_FALSE(WayBack(drive, 0.6, 1).slope());
}

// The change is so small that only a very good cell shows it.
TEST(ContactSlope, IsMeasuredOnAContactThatStiffens) {
  const std::vector<double> forces_N{4.11852, 4.1181,  4.11706, 4.11623, 4.1126,  4.10702, 4.09427,
                                     4.0694,  4.01919, 3.91969, 3.72102, 3.32477, 2.53623};
  std::vector<RestMeasurement> looks;
  double back_m = 0;
  for (const double force_N : forces_N) {
    std::vector<FrameSample> samples(kSamples);
    for (std::size_t i = 0; i < kSamples; ++i) {
      samples[i].force_N = force_N + (i % 2 == 0 ? 1.2e-3 : -1.2e-3);
      samples[i].travel_m = 2e-3 - back_m;
    }
    looks.emplace_back().add(samples);
    back_m = back_m > 0 ? 2 * back_m : 2e-7;
  }
  const auto slope = contact_slope(looks, looks.size(), {forces_N.front(), 0, 0, 2e-7});
  ASSERT_TRUE(slope);
  EXPECT_GE(slope->at_most, 3860) << "the whole way";
  EXPECT_LT(slope->at_most, 3950);
}

// The watch of a cell that lies needs it on the contacts whose slope is not known.
TEST(ContactSlope, LessIsProvenWhereverTheForceFell) {
  for (const double play_m : {0.0, 3e-6, 15e-6}) {
    for (unsigned seed = 1; seed <= 50; ++seed) {
      DriveWithPlay drive;
      drive.play_m = play_m;
      const double proven_N_m = WayBack(drive, 0.3, seed).proven_N_m();
      EXPECT_LE(proven_N_m, 1.001 * drive.stiffness_N_m) << play_m << ", seed " << seed;
      EXPECT_GE(proven_N_m, (play_m > 0 ? 0.2 : 0.8) * drive.stiffness_N_m)
          << play_m << ", seed " << seed;
    }
  }
}

// The looks of a probe at a specimen that relaxes: some at contact, then one after each step back,
// with noise and drift of the cell.
class RelaxingWayBack {
 public:
  struct Cell {
    double noise_N = 5e-4, drift_N_s = 0, digit_m = 1e-7;
  };

  RelaxingWayBack(const RelaxingRig& rig, const Cell& cell, std::size_t looks_at_contact,
                  unsigned seed)
      : cell_(cell), random_(seed), contact_(rig, kContact_m, MonoTime()) {
    const double touched_m = std::round(contact_.touched_m() / cell.digit_m) * cell.digit_m;
    look_at_contact(looks_at_contact);
    const double felt_N = looks_.front().force_N();
    double step_m = std::max(2e-7, cell.digit_m);
    for (; step_m < 5e-4 && looks_.back().force_N() > 0.3 * felt_N; step_m *= 2) {
      travel_m_ = touched_m - step_m;
      now_ += from_seconds(0.1 + step_m / 1e-5);
      looks_.push_back(look());
    }
  }
  double proven_N_m() const {
    const double drift_N_s = std::abs(cell_.drift_N_s);
    return proven_stiffness_N_m(
        looks_, {looks_.front().force_N(), drift_N_s, relaxes_N_s_, std::max(2e-7, cell_.digit_m)});
  }

 private:
  static constexpr double kContact_m = 5e-3;

  void look_at_contact(std::size_t looks) {
    travel_m_ = contact_.touched_m();
    std::vector<RestMeasurement> seen(1, look());
    while (seen.size() < looks) {
      const RestMeasurement now = look();
      for (const RestMeasurement& before : seen) {
        relaxes_N_s_ = std::min(relaxes_N_s_, fastest_fall_N_s(before, now));
      }
      seen.push_back(now);
    }
    looks_.push_back(seen.back());
  }
  RestMeasurement look() {
    std::normal_distribution<double> noise(0, cell_.noise_N);
    std::vector<FrameSample> samples(kSamples);
    for (FrameSample& s : samples) {
      now_ += std::chrono::milliseconds(20);
      const double drifted_N = cell_.drift_N_s * to_seconds(now_.time_since_epoch());
      s.received = now_;
      s.force_N = contact_.force_at(travel_m_, now_) + drifted_N + noise(random_);
      s.travel_m = std::round(travel_m_ / cell_.digit_m) * cell_.digit_m;
    }
    RestMeasurement rest;
    rest.add(samples);
    return rest;
  }

  const Cell cell_;
  std::mt19937 random_;
  RelaxingContact contact_;
  MonoTime now_{};
  double travel_m_ = 0;
  double relaxes_N_s_ = HUGE_VAL;
  std::vector<RestMeasurement> looks_;
};

// What is proven decides whether a cell is believed, so it must not be too much: no more than the
// specimen gives back quickly. Errors of three standard deviations and a digit are taken off, so
// the largest share was 0.98.
TEST(ContactSlope, NoMoreIsProvenThanThereIsOfASpecimenThatRelaxes) {
  std::mt19937 random(5);
  const auto even = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const auto over_decades = [&](double low, double high) {
    return std::exp(even(std::log(low), std::log(high)));
  };
  constexpr unsigned kRigs = 4000;
  unsigned proven = 0;
  for (unsigned i = 0; i < kRigs; ++i) {
    RelaxingRig rig;
    rig.stiffness_N_m = over_decades(5e3, 600e3);
    rig.falls = even(0, 0.4);
    rig.relaxes_s = over_decades(0.3, 2);
    rig.play_m = i % 4 == 0 ? 0 : even(0, 20e-6);
    rig.felt_N = even(0.1, 0.95);
    rig.approach_s = over_decades(0.02, 20);
    RelaxingWayBack::Cell cell;
    cell.noise_N = over_decades(1e-4, 5e-3);
    cell.drift_N_s = even(-2e-3, 2e-3);
    cell.digit_m = i % 5 == 0 ? 1e-6 : 1e-7;
    const RelaxingWayBack way(rig, cell, 2 + i % 5, i);
    const double share = way.proven_N_m() / rig.quick_N_m();
    if (share > 0) ++proven;
    EXPECT_LE(share, 1) << "rig " << i;
  }
  EXPECT_GT(proven, 0.99 * kRigs);
}

// The contact was lost after it. Such a way may be none, and two digits may differ by rounding.
TEST(ContactSlope, IsNotToldOfAWayOfASingleDigit) {
  constexpr double kDigit_m = 2e-6;
  for (int place = 1; place <= 1000; ++place) {
    std::vector<RestMeasurement> looks;
    for (int i = 0; i < 3; ++i) {
      std::vector<FrameSample> samples(kSamples);
      for (std::size_t k = 0; k < kSamples; ++k) {
        samples[k].force_N = 0.35 - 0.15 * i + (k % 2 == 0 ? 1e-3 : -1e-3);
        samples[k].travel_m = (2 * place - i) * kDigit_m;
      }
      looks.emplace_back().add(samples);
    }
    const auto slope = contact_slope(looks, 2, {0.35, 0, 0, kDigit_m});
    EXPECT_FALSE(slope) << place << ": at most " << slope->at_most;
  }
}

// Looks a second apart at these forces, `step_m` further back each, with a noise of 1 mN.
std::vector<RestMeasurement> looks_of(const std::vector<double>& forces_N, double step_m) {
  std::vector<RestMeasurement> looks;
  for (std::size_t i = 0; i < forces_N.size(); ++i) {
    std::vector<FrameSample> samples(kSamples);
    for (std::size_t k = 0; k < kSamples; ++k) {
      samples[k].received = MonoTime() + std::chrono::seconds(i + 1);
      samples[k].force_N = forces_N[i] + (k % 2 == 0 ? 1e-3 : -1e-3);
      samples[k].travel_m = 2e-3 - static_cast<double>(i) * step_m;
    }
    looks.emplace_back().add(samples);
  }
  return looks;
}

// One step in contact is enough, if its fall is clear.
TEST(ContactSlope, IsToldFromASingleStep) {
  const auto slope = contact_slope(looks_of({0.35, 0.2, 0.1}, 5e-6), 2, {0.35, 0, 0, 1e-7});
  ASSERT_TRUE(slope);
  EXPECT_NEAR(slope->about, 30e3, 1e3);
}

// What the cell shows once the contact was lost is no force of the contact. Only the step that lost
// it counts, because the contact is at least as stiff as that.
TEST(ContactSlope, DoesNotDependOnLooksAfterTheContactWasLost) {
  const std::vector<double> forces_N{0.35, 0.2, 0.05, 0};
  const auto alone = contact_slope(looks_of(forces_N, 5e-6), 3, {0.35, 0, 0, 1e-7});
  ASSERT_TRUE(alone);
  for (const double later_N : {-2.0, 0.0, 2.0}) {
    auto more_N = forces_N;
    more_N.push_back(later_N);
    more_N.push_back(-later_N);
    const auto same = contact_slope(looks_of(more_N, 5e-6), 3, {0.35, 0, 0, 1e-7});
    ASSERT_TRUE(same) << later_N;
    EXPECT_DOUBLE_EQ(same->at_most, alone->at_most);
    EXPECT_DOUBLE_EQ(same->about, alone->about);
  }
}

TEST(ContactSlope, TheFastestFallIsThatOfTheMeansAndTheirErrors) {
  const auto looks = looks_of({0.35, 0.25, 0.4}, 0);
  const double error_N = 3 * std::hypot(looks[0].error_N(), looks[1].error_N());
  EXPECT_NEAR(fastest_fall_N_s(looks[0], looks[1]), 0.1 + error_N, 1e-9);
  EXPECT_NEAR(fastest_fall_N_s(looks[0], looks[2]), 0, 1e-12) << "it rose";
  EXPECT_EQ(seconds_between(looks[2], looks[0]), 2);
  EXPECT_EQ(seconds_between(looks[0], RestMeasurement()), 0);
  EXPECT_EQ(seconds_between(RestMeasurement(), looks[0]), 0);
  EXPECT_TRUE(std::isinf(fastest_fall_N_s(looks[0], RestMeasurement())));
}

TEST(ContactSlope, WithoutATravelIsNotTold) {
  FrameSample sample;
  sample.force_N = 1;
  std::vector<RestMeasurement> looks(2);
  looks[0].add(std::span(&sample, 1));
  sample.force_N = 0.5;
  looks[1].add(std::span(&sample, 1));
  EXPECT_FALSE(contact_slope(looks, 2, {1, 0, 0, 1e-7}));
}

// Random drives: how many slopes were reported, and how many of these were too low.
class SlopesOfDrives : public testing::Test {
 protected:
  void try_drives(double most_play_m, double relaxes) {
    std::mt19937 random(7);
    const auto even = [&](double low, double high) {
      return std::uniform_real_distribution(low, high)(random);
    };
    for (unsigned seed = 0; seed < kDrives; ++seed) {
      DriveWithPlay drive;
      drive.stiffness_N_m = std::exp(even(std::log(5e3), std::log(300e3)));
      drive.play_m = even(0, most_play_m);
      drive.digit_m = seed % 4 == 0 ? 1e-6 : 1e-7;
      drive.noise_N = std::exp(even(std::log(1e-4), std::log(5e-3)));
      drive.relaxes = even(0, relaxes);
      const double felt_N = std::max(6 * drive.noise_N, even(0.05, 0.6));
      const auto slope = WayBack(drive, felt_N, seed).slope();
      if (!slope) continue;
      ++told;
      if (slope->at_most < 0.99 * drive.stiffness_N_m) ++too_low;
      worst = std::min(worst, slope->at_most / drive.stiffness_N_m);
    }
  }
  static constexpr unsigned kDrives = 5000;
  int told = 0, too_low = 0;
  double worst = 1;
};

TEST_F(SlopesOfDrives, WithoutPlayAreToldForMost) {
  try_drives(0, 0);
  EXPECT_GT(told, 0.6 * kDrives);
  EXPECT_LT(too_low, 0.001 * kDrives);
}

TEST_F(SlopesOfDrives, WithPlayAreSeldomTooLowAndByLittle) {
  try_drives(6e-6, 0.04);
  EXPECT_GT(told, 0.5 * kDrives);
  EXPECT_LT(too_low, 0.01 * kDrives);
  EXPECT_GT(worst, 0.95) << "the forecast allows for half as much again";
}

}  // namespace
}  // namespace lcrig
