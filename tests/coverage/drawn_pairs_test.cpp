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

// Limits of the papers, relative: ISO 7500-1 class 1; a tip turned to +-0.02 mm; discs by
// ISO 2768-1, class f; basic accuracy of the meter at 100 kHz, 1 V, MED: 0.05 % of the value and
// 1e-9 Z (1 + 70 mV/1000 mV), which for 4 pF (398 kohm) is 1.7 fF.
constexpr double kCell = 0.01, kTip_mm = 0.02, kMeter = 5e-4, kOffset_fF = 1.7;
double probe_limit(const ComparedProtocol& p) {
  return 2 * kTip_mm / p.probe_mm;
}
double disc_limit_mm(const ComparedSpecimen& s) {
  return *s.disc_mm > 6 ? 0.1 : 0.05;
}

struct PairOfWorlds {
  ComparedSpecimen a, b;
  ComparedRig rig_a, rig_b;
  ComparedProtocol p_a, p_b;
  bool same_cell = true, same_probe = true, same_meter = true;
  bool like_settings = true, like_contact = true, like_loading = true, like_peak = true;
  bool like_correction = true, same_run = false;

  // The probe is 8 mm wide and the discs are not of one size.
  bool over_discs() const { return a.disc_mm && *a.disc_mm != *b.disc_mm; }
};

// Pressure on the disc for one of the probe.
double on_disc(const ComparedSpecimen& s, const ComparedProtocol& p) {
  return s.disc_mm ? p.probe_mm * p.probe_mm / (*s.disc_mm * *s.disc_mm) : 1;
}

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  PairOfWorlds pair() {
    PairOfWorlds d;
    draw_specimens(d);
    if (chance(0.35)) draw_discs(d);
    draw_rigs(d);
    draw_protocols(d);
    if (chance(0.3)) draw_unlike(d);
    const double a = on_disc(d.a, d.p_a), b = on_disc(d.b, d.p_b);
    if (std::abs(d.p_a.kPa.back() * a / (d.p_b.kPa.back() * b) - 1) > 0.02) d.like_peak = false;
    d.same_run = chance(0.05);
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

  void draw_discs(PairOfWorlds& d) {
    d.p_a.probe_mm = d.p_b.probe_mm = 8;
    d.a.disc_mm = chance(0.5) ? 4 : 8;
    d.b.disc_mm = chance(0.5) ? 4 : 8;
    if (!d.over_discs()) return;  // the errors belong to the pressure only where it is over them
    d.a.disc_error_mm = within(disc_limit_mm(d.a));
    d.b.disc_error_mm = within(disc_limit_mm(d.b));
  }

  void draw_rig(ComparedRig& rig, const ComparedProtocol& p) {
    rig.cell_gain = within(kCell);
    rig.probe_area = within(probe_limit(p));
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
    draw_rig(d.rig_a, d.p_a);
    draw_rig(d.rig_b, d.p_b);
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
    if (d.over_discs() && chance(0.8)) {  // the same pressures on the discs
      for (double& kPa : d.p_b.kPa) kPa *= on_disc(d.a, d.p_a) / on_disc(d.b, d.p_b);
    }
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
        // Smaller than its disc, or another pressure on what is under it.
        d.p_b.probe_mm = d.a.disc_mm ? 3 : chance(0.5) ? 8 : 4.2;
        d.like_contact = false;
        break;
      case 5:
        d.p_b.ramps = !d.p_b.ramps;
        d.like_loading = false;
        break;
      case 6:
        d.p_b.kPa.back() *= 1.25;
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

// The time under load at a share of the peak, in a run with this protocol.
double time_of(const ComparedProtocol& p, double share) {
  if (p.ramps) return ComparedRun::kReading_s * p.ramp_readings * share;
  return ComparedRun::kReading_s * p.readings / std::numbers::e;  // mean of its logarithm
}

// One run of the pair as its pressures are compared: on the disc, or as they are printed.
struct Side {
  Side(const PairOfWorlds& d, const ComparedSpecimen& s, const ComparedProtocol& p)
      : specimen(s), kPa(p.kPa), to_disc(on_disc(s, p)) {
    if (!d.over_discs()) return;
    for (double& v : kPa) v *= to_disc;
    to_disc = 1;
  }
  double delta_fF(double at_kPa, double t_s) const {
    return specimen.delta_fF(at_kPa * to_disc, t_s);
  }
  const ComparedSpecimen& specimen;
  std::vector<double> kPa;
  double to_disc;
};

// At the times of run `at`, whose peak is `peak_kPa`.
double slope(const Side& s, const ComparedProtocol& at, double peak_kPa,
             const std::vector<double>& kPa) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(kPa.size());
  const auto delta = [&](double p) { return s.delta_fF(p, time_of(at, p / peak_kPa)); };
  for (const double p : kPa) x += p / n, y += delta(p) / n;
  for (const double p : kPa) {
    xx += (p - x) * (p - x);
    xy += (p - x) * (delta(p) - y);
  }
  return xy / xx;
}

// The pressures of a range that both runs have; of ramps a fine grid over what both cover.
std::vector<double> common_pressures(bool ramps, const Side& a, const Side& b, double from,
                                     double to) {
  std::vector<double> out;
  if (ramps) {
    const double peak = std::min(a.kPa.back(), b.kPa.back());
    const double edge = 0.05 * std::max(a.kPa.back(), b.kPa.back());
    from = std::max(from, edge);
    to = std::min(to, peak);
    for (int i = 0; from < to && i <= 100; ++i) out.push_back(from + (to - from) * i / 100);
    return out;
  }
  for (const double p : a.kPa) {
    if (p < from || p > to) continue;
    const auto is_p = [p](double q) { return std::abs(p - q) < 1e-9; };
    if (std::ranges::any_of(b.kPa, is_p)) out.push_back(p);
  }
  return out;
}

// The truth at the times of run A. Nullopt: the two cannot be compared.
std::optional<double> true_ratio(const PairOfWorlds& d, const std::string& quantity) {
  if (!d.like_settings || d.same_run) return std::nullopt;
  if (quantity == "C0") {
    return d.like_correction ? std::optional(d.b.c0_fF / d.a.c0_fF) : std::nullopt;
  }
  if (!d.like_contact || !d.like_loading) return std::nullopt;
  const Side a(d, d.a, d.p_a), b(d, d.b, d.p_b);
  if (quantity == "dynamic range") {
    if (!d.like_peak || !d.like_correction) return std::nullopt;
    const double kPa = a.kPa.back(), t = time_of(d.p_a, 1);
    return b.delta_fF(kPa, t) / d.b.c0_fF / (a.delta_fF(kPa, t) / d.a.c0_fF);
  }
  const bool low = quantity == "sensitivity 0-30 kPa";
  const auto kPa = common_pressures(d.p_a.ramps, a, b, low ? 0 : 35, low ? 30 : 100);
  if (kPa.size() < 2) return std::nullopt;
  return slope(b, d.p_a, a.kPa.back(), kPa) / slope(a, d.p_a, a.kPa.back(), kPa);
}

struct Count {
  int answered = 0, held = 0, refused = 0;
  int needless = 0;  // refused although they are comparable
};

// Smallest relative standard error that the errors which the pair does not share leave.
double least_error(const PairOfWorlds& d, const std::string& quantity) {
  if (quantity == "dynamic range") return 0;  // depends on the bend of the curves
  if (quantity == "C0") return d.same_meter ? 0 : std::sqrt(2.0 / 3) * kMeter;
  const double cell = d.same_cell ? 0 : kCell, meter = d.same_meter ? 0 : kMeter;
  double areas = 0;
  if (d.over_discs()) {
    const double a = 2 * disc_limit_mm(d.a) / *d.a.disc_mm;
    const double b = 2 * disc_limit_mm(d.b) / *d.b.disc_mm;
    areas = (a * a + b * b) / 2;
  } else if (!d.same_probe) {
    areas = probe_limit(d.p_a) * probe_limit(d.p_a);
  }
  return std::sqrt(2.0 / 3 * (cell * cell + areas + meter * meter));
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
  const bool converts = d.over_discs() && c.quantity != "C0";
  EXPECT_EQ(c.converted.starts_with("pressure on the disc"), converts) << c.verdict;
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
    const ComparedRun two(d.same_run ? 1 : 2, "b", d.b, d.rig_b, d.p_b, 2 * seed + 1);
    const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
    for (const Comparison& c : compare(runs, analyses_of({&one.data, &two.data}))) {
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
