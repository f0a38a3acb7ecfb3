// SPDX-License-Identifier: Apache-2.0
// Cycles of specimens that creep and recover, beside a true drift. Both move the capacitance at
// rest, and only the drift may be subtracted from the dynamic range. The truth is that of the
// world, which knows its drift; its creep is of other shapes than the analysis assumes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "analysis/analysis.hpp"

namespace lcrig::recovery_worlds {
namespace {

constexpr double kReading_s = 0.14, kC0_fF = 3600, kElastic_fF = 500, kNoise_fF = 0.4;
constexpr int kWorlds = 300;

class CreepingCycles {
 public:
  explicit CreepingCycles(std::uint64_t seed) : random_(seed) {
    draw();
    data.run = 1;
    data.row.protocol_name = "cycles";
    data.listing.exit_status = ExitStatus::success;
    data.probe_diameter_m = 4e-3;
    data.area_m2 = std::numbers::pi / 4 * 16e-6;
    data.function = "Cp-D";
    data.steps = {"s"};
    RunData::Settings settings;
    settings.since_s = -1;
    settings.meter.frequency_Hz = 100e3;
    data.settings.push_back(settings);
    data.rest_force_N = 0;
    stay(0, baseline_s_);
    const double before_first = mean_from(0);
    data.contact_s = t_s_ - 0.5;
    double rest = before_first;
    for (int k = 0; k < cycles_; ++k) {
      for (int i = 0; i < ramp_; ++i) read((i + 0.5) / ramp_);
      const std::size_t peak = steady_.size();
      stay(1, hold_s_);
      truth_percent += (mean_from(peak) - rest) / kC0_fF * 100 / cycles_;
      for (int i = 0; i < ramp_; ++i) read(1 - (i + 0.5) / ramp_);
      const std::size_t rest_from = steady_.size();
      stay(0, rest_s_);
      rest = mean_from((rest_from + steady_.size()) / 2);  // of its later half, by definition
    }
    data.duration_s = t_s_;
  }
  RunData data;
  double truth_percent = 0;
  std::string world;

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool chance(double p) { return between(0, 1) < p; }

  void draw() {
    cycles_ = 2 + static_cast<int>(random_() % 4);
    baseline_s_ = between(8, 30);
    hold_s_ = between(3, 60);
    rest_s_ = between(6, 40);
    ramp_ = 6 + static_cast<int>(random_() % 25);
    drift_fF_s_ = chance(0.25) ? 0 : between(-300, 300) / 3600;
    if (chance(0.2)) return describe("no creep");
    if (chance(0.5)) {  // logarithmic: elements far faster and slower than the run
      const double per_decade = between(0.005, 0.06);
      for (double tau = 0.1; tau < 5000; tau *= std::sqrt(10)) {
        elements_.push_back({tau, per_decade / 2, 0});
      }
      return describe(fmt::format("{:.3f} per decade", per_decade));
    }
    std::string words = "exponential";
    for (int n = 1 + static_cast<int>(random_() % 2); n > 0; --n) {
      const double tau = std::pow(10, between(0.3, 2.3));
      elements_.push_back({tau, between(0.005, 0.05), 0});
      words += fmt::format(", {:.3f} in {:.3g} s", elements_.back().share, tau);
    }
    describe(words);
  }
  void describe(const std::string& creep) {
    world = fmt::format("{} cycles, held {:.0f} s, rests {:.0f} s, drift {:.0f} fF/h, creep {}",
                        cycles_, hold_s_, rest_s_, drift_fF_s_ * 3600, creep);
  }

  double mean_from(std::size_t first) const {
    return std::accumulate(steady_.begin() + static_cast<std::ptrdiff_t>(first), steady_.end(),
                           0.0) /
           static_cast<double>(steady_.size() - first);
  }
  void stay(double load, double seconds) {
    for (double until = t_s_ + seconds; t_s_ < until;) read(load);
  }
  void read(double load) {
    RunReading r;
    r.t_s = t_s_ + kReading_s / 2;
    t_s_ += kReading_s;
    double fF = kElastic_fF * load;
    for (Element& e : elements_) {
      e.state += (load - e.state) * (1 - std::exp(-kReading_s / e.tau_s));
      fF += kElastic_fF * e.share * e.state;
    }
    steady_.push_back(fF);
    r.force_N = static_cast<float>(load * 1.25);
    r.present = 1;
    r.capacitance_F = (kC0_fF + fF + drift_fF_s_ * r.t_s + kNoise_fF * normal_(random_)) * 1e-15;
    data.frame.push_back({r.t_s, r.force_N, 0, false});
    ++data.frame_samples;
    ++data.fresh_readings;
    data.readings.push_back(r);
  }

  struct Element {
    double tau_s, share, state;
  };
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<Element> elements_;
  std::vector<double> steady_;  // the specimen without drift and noise, less C0
  int cycles_ = 0, ramp_ = 0;
  double baseline_s_ = 0, hold_s_ = 0, rest_s_ = 0, drift_fF_s_ = 0, t_s_ = 0;
};

TEST(Recovery, IsNotSubtractedFromTheDynamicRangeAsDrift) {
  int held = 0, expanded = 0;
  double widths = 0, squares = 0;
  for (std::uint64_t seed = 0; seed < kWorlds; ++seed) {
    const CreepingCycles run(8100 + seed);
    const RunAnalysis a = analyse(run.data).value();
    ASSERT_TRUE(a.dynamic_range) << run.world << a.dynamic_range.reason;
    const Estimate& e = *a.dynamic_range.estimate;
    const double error = e.value - run.truth_percent;
    const bool holds = std::abs(error) <= ((*e.interval)[1] - (*e.interval)[0]) / 2;
    held += holds;
    const Uncertainty* u = a.uncertainty_of(a.dynamic_range);
    ASSERT_TRUE(u != nullptr);
    expanded += std::abs(error) <= u->expanded;
    widths += ((*e.interval)[1] - (*e.interval)[0]) / 2 / kWorlds;
    squares += error * error / kWorlds;
    if (std::getenv("LCRIG_SHOW") != nullptr) {
      fmt::print("{:+.4f} +-{:.4f} {} {}\n", error, ((*e.interval)[1] - (*e.interval)[0]) / 2,
                 holds ? "" : "MISSED", run.world);
    }
  }
  fmt::print("interval holds in {:.1f} %, expanded in {:.1f} %, half-width {:.4f}, error {:.4f}\n",
             100.0 * held / kWorlds, 100.0 * expanded / kWorlds, widths, std::sqrt(squares));
  EXPECT_GE(held, 0.93 * kWorlds);
  EXPECT_GE(expanded, 0.93 * kWorlds);
}

}  // namespace
}  // namespace lcrig::recovery_worlds
