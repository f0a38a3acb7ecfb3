// SPDX-License-Identifier: Apache-2.0
// Pairs of runs with drawn differences. The truth is that of the worlds, the errors of the rigs are
// drawn here, and whether a pair is comparable is judged by rules of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "analysis/comparison.hpp"
#include "tests/unit/analysis/compared_world.hpp"

namespace lcrig::drawn_pairs {
namespace {

constexpr int kPairs = 500;

// Limits of the papers, relative: ISO 7500-1 class 1; a tip of 4 mm turned to +-0.02 mm; basic
// accuracy of the meter at 100 kHz, 1 V, MED: 0.05 % of the value and 1e-9 Z (1 + 70 mV/1000 mV),
// which for 4 pF (398 kohm) is 1.7 fF.
constexpr double kCell = 0.01, kProbe = 2 * 0.02 / 4, kMeter = 5e-4, kOffset_fF = 1.7;

struct PairOfWorlds {
  ComparedSpecimen a, b;
  ComparedRig rig_a, rig_b;
  ComparedProtocol p_a, p_b;
  bool same_cell = true, same_probe = true, same_meter = true;
  bool like_settings = true, like_contact = true, like_loading = true, like_peak = true;
  bool like_correction = true;
};

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  PairOfWorlds pair() {
    PairOfWorlds d;
    draw_specimens(d);
    draw_rigs(d);
    draw_protocols(d);
    if (chance(0.3)) draw_unlike(d);
    return d;
  }

 private:
  bool chance(double p) { return std::uniform_real_distribution<double>()(random_) < p; }
  double within(double limit) { return between(-limit, limit); }
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  void draw_specimens(PairOfWorlds& d) {
    d.a = {between(3000, 5000), between(300, 900), between(40, 120), 0};
    d.b = chance(0.3)
              ? d.a
              : ComparedSpecimen{between(3000, 5000), between(300, 1800), between(40, 120), 0};
    if (chance(0.4)) {
      d.a.creep_per_decade = between(0, 0.08);
      d.b.creep_per_decade = between(0, 0.08);
    }
  }

  void draw_rig(ComparedRig& rig) {
    rig.cell_gain = within(kCell);
    rig.probe_area = within(kProbe);
    rig.meter_gain = within(kMeter);
    rig.meter_offset_fF = within(kOffset_fF);
  }

  // Another instrument has another name, or none is stated. Then its errors are drawn anew.
  bool draw_same(std::string& name) {
    if (!chance(0.4)) return true;
    name = chance(0.5) ? "" : name + "x";
    return false;
  }

  void draw_rigs(PairOfWorlds& d) {
    draw_rig(d.rig_a);
    draw_rig(d.rig_b);
    d.same_cell = draw_same(d.rig_b.cell);
    d.same_probe = draw_same(d.rig_b.probe);
    d.same_meter = draw_same(d.rig_b.meter);
    if (d.same_meter && chance(0.2)) {  // the same meter, but another correction, or one unknown
      d.same_meter = false;
      if (chance(0.5)) {
        d.p_b.corrected_unix_ns = 2;
      } else {
        d.p_a.corrected_unix_ns = d.p_b.corrected_unix_ns = {};
      }
    }
    if (d.same_cell) d.rig_b.cell_gain = d.rig_a.cell_gain;
    if (d.same_probe) d.rig_b.probe_area = d.rig_a.probe_area;
    if (!d.same_meter) return;
    d.rig_b.meter_gain = d.rig_a.meter_gain;
    d.rig_b.meter_offset_fF = d.rig_a.meter_offset_fF;
  }

  void draw_protocols(PairOfWorlds& d) {
    d.p_a.ramps = d.p_b.ramps = chance(0.25);
    static const std::vector<std::vector<double>> kLevels{
        {10, 20, 30, 40, 50, 60}, {5, 10, 20, 30, 45, 60}, {10, 20, 30, 60}, {7.5, 15, 30, 60}};
    d.p_a.kPa = kLevels[random_() % kLevels.size()];
    d.p_b.kPa = kLevels[random_() % kLevels.size()];
    d.p_a.repeats = 3 + static_cast<int>(random_() % 3);
    d.p_b.repeats = 3 + static_cast<int>(random_() % 3);
    if (d.p_a.ramps) return;
    if (chance(0.4)) d.p_b.settle = 10 + static_cast<int>(random_() % 60);
  }

  void draw_unlike(PairOfWorlds& d) {
    switch (random_() % 8) {
      case 0:
        d.p_b.frequency_Hz = 50e3;
        d.like_settings = false;
        break;
      case 1:
        d.p_b.level_V = 0.5;
        d.like_settings = false;
        break;
      case 2:
        d.p_b.bias_V = 1;
        d.like_settings = false;
        break;
      case 3:
        d.p_b.function = "Cs-D";
        d.like_settings = false;
        break;
      case 4:
        d.p_b.probe_mm = chance(0.5) ? 8 : 4.2;
        d.like_contact = false;
        break;
      case 5:
        d.p_b.ramps = !d.p_b.ramps;
        d.like_loading = false;
        break;
      case 6:
        d.p_b.kPa.back() = 75;
        d.like_peak = false;
        break;
      default:
        d.p_b.open_on = false;
        d.like_correction = d.same_meter = false;
        break;
    }
  }

  std::mt19937_64 random_;
};

// The time under load at a pressure, in a run with this protocol.
double time_of(const ComparedProtocol& p, double kPa) {
  if (p.ramps) return ComparedRun::kReading_s * p.ramp_readings * kPa / p.kPa.back();
  return ComparedRun::kReading_s * p.readings / std::numbers::e;  // mean of its logarithm
}

double slope(const ComparedSpecimen& s, const ComparedProtocol& at,
             const std::vector<double>& kPa) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(kPa.size());
  for (const double p : kPa) x += p / n, y += s.delta_fF(p, time_of(at, p)) / n;
  for (const double p : kPa) {
    xx += (p - x) * (p - x);
    xy += (p - x) * (s.delta_fF(p, time_of(at, p)) - y);
  }
  return xy / xx;
}

// The pressures of a range that both runs have; of ramps a fine grid over what both cover.
std::vector<double> common_pressures(const PairOfWorlds& d, double from, double to) {
  std::vector<double> out;
  if (d.p_a.ramps) {
    const double peak = std::min(d.p_a.kPa.back(), d.p_b.kPa.back());
    const double edge = 0.05 * std::max(d.p_a.kPa.back(), d.p_b.kPa.back());
    from = std::max(from, edge);
    to = std::min(to, peak);
    for (int i = 0; i <= 100; ++i) out.push_back(from + (to - from) * i / 100);
    return out;
  }
  for (const double p : d.p_a.kPa) {
    if (p < from || p > to) continue;
    if (std::ranges::find(d.p_b.kPa, p) != d.p_b.kPa.end()) out.push_back(p);
  }
  return out;
}

// The truth at the times of run A. Nullopt: the two cannot be compared.
std::optional<double> true_ratio(const PairOfWorlds& d, const std::string& quantity) {
  if (!d.like_settings) return std::nullopt;
  if (quantity == "C0") {
    return d.like_correction ? std::optional(d.b.c0_fF / d.a.c0_fF) : std::nullopt;
  }
  if (!d.like_contact || !d.like_loading) return std::nullopt;
  if (quantity == "dynamic range") {
    if (!d.like_peak || !d.like_correction) return std::nullopt;
    const double kPa = d.p_a.kPa.back(), t = time_of(d.p_a, kPa);
    return d.b.delta_fF(kPa, t) / d.b.c0_fF / (d.a.delta_fF(kPa, t) / d.a.c0_fF);
  }
  const bool low = quantity == "sensitivity 0-30 kPa";
  const auto kPa = low ? common_pressures(d, 0, 30) : common_pressures(d, 35, 100);
  if (kPa.size() < 2) return std::nullopt;
  return slope(d.b, d.p_a, kPa) / slope(d.a, d.p_a, kPa);
}

struct Count {
  int answered = 0, held = 0, refused = 0;
  int needless = 0;  // refused although they are comparable
};

// Smallest relative standard error that the errors which the pair does not share leave.
double least_error(const PairOfWorlds& d, const std::string& quantity) {
  if (quantity == "dynamic range") return 0;  // depends on the bend of the curves
  if (quantity == "C0") return d.same_meter ? 0 : std::sqrt(2.0 / 3) * kMeter;
  const double cell = d.same_cell ? 0 : kCell, probe = d.same_probe ? 0 : kProbe;
  const double meter = d.same_meter ? 0 : kMeter;
  return std::sqrt(2.0 / 3 * (cell * cell + probe * probe + meter * meter));
}

void judge(const PairOfWorlds& d, const Comparison& c, std::map<std::string, Count>& counts) {
  const auto truth = true_ratio(d, c.quantity);
  Count& count = counts[c.quantity];
  if (!truth) {
    EXPECT_FALSE(c.is_answered()) << c.quantity << ": " << c.verdict;
    EXPECT_FALSE(c.remedy.empty());
  }
  if (!c.is_answered()) {
    EXPECT_FALSE(c.interval_percent || c.ratio || c.increase_percent);
    ++count.refused;
    if (truth) ++count.needless;
    return;
  }
  if (!truth) return;
  ++count.answered;
  const bool holds = (*c.ratio)[0] <= *truth && *truth <= (*c.ratio)[1];
  if (holds) ++count.held;
  const double ratio = *c.to_value / *c.from_value;
  EXPECT_GE(*c.standard_error_percent / 100 / ratio, 0.999 * least_error(d, c.quantity))
      << c.quantity << ": " << c.verdict;
}

TEST(DrawnPairs, IntervalsHoldTheTruthAndUnlikePairsAreRefused) {
  std::map<std::string, Count> counts;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    SCOPED_TRACE(seed);
    const PairOfWorlds d = Draw(7700 + seed).pair();
    const ComparedRun one(1, "a", d.a, d.rig_a, d.p_a, 2 * seed);
    const ComparedRun two(2, "b", d.b, d.rig_b, d.p_b, 2 * seed + 1);
    const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
    for (const Comparison& c : compare(runs, slopes_of({&one.data, &two.data}))) {
      judge(d, c, counts);
    }
  }
  Count all;
  for (const auto& [quantity, c] : counts) {
    fmt::print("{}: {} compared, {} refused, {} of them needlessly, {:.1f} % hold\n", quantity,
               c.answered, c.refused, c.needless, 100.0 * c.held / c.answered);
    EXPECT_LE(c.needless, 0.1 * (c.answered + c.needless)) << quantity;
    EXPECT_GE(c.held, 0.93 * c.answered) << quantity;
    EXPECT_GT(c.answered, kPairs / 4) << quantity;
    all.answered += c.answered;
    all.held += c.held;
    all.refused += c.refused;
  }
  fmt::print("all: {} compared, {} refused, {:.1f} % hold\n", all.answered, all.refused,
             100.0 * all.held / all.answered);
  EXPECT_GT(all.refused, kPairs / 4);
}

}  // namespace
}  // namespace lcrig::drawn_pairs
