// SPDX-License-Identifier: Apache-2.0
#include "bench/fit_worlds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace lcrig::fit_worlds {

namespace {

constexpr double kDiameter_mm = 4, kVacuum_F_m = 8.8541878128e-12;
constexpr double kArea_m2 = std::numbers::pi / 4 * kDiameter_mm * kDiameter_mm * 1e-6;
constexpr double kSoft_m = 25e-6, kFilm_m = 75e-6, kSoftEps = 2.75, kFilmEps = 3.5;
constexpr int kCapacitors = 3;

// The force as a line of straight pieces, and what the specimen answers to it.
struct Knot {
  double t_s, kPa;
};

// Everything that is drawn for one specimen and run.
struct Drawn {
  double mu_Pa = 0, thickness = 0, creep = 0, creep_s = 0, hysteresis = 0, gain = 0;
  double offset_kPa = 0;  // of the cell's zero, or needed for the faces to touch
  bool truth_in_middle = false;
  double top_kPa = 0;
};

double stretch_under(Law law, double pressure_Pa, double mu_Pa) {
  if (law == Law::spring) return 1 - pressure_Pa / (3 * mu_Pa);
  double low = 1e-3, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (mu_Pa * (1 / (middle * middle) - middle) > pressure_Pa ? low : high) = middle;
  }
  return (low + high) / 2;
}

double capacitance_fF(Law law, const Drawn& d, double pressure_Pa) {
  const double soft_m =
      kSoft_m * (1 + d.thickness) * stretch_under(law, std::max(pressure_Pa, 0.0), d.mu_Pa);
  return kCapacitors * kVacuum_F_m * kArea_m2 / (soft_m / kSoftEps + kFilm_m / kFilmEps) * 1e15;
}

// Integral of log10(1 + u) from 0 to u.
double log_integral(double u) {
  return ((1 + u) * std::log1p(u) - u) / std::numbers::ln10;
}

// The pressure that would act at once as the history does at t_s, by superposition of its ramps.
double answered_kPa(const std::vector<Knot>& knots, CreepKind kind, const Drawn& d, double t_s) {
  double kPa = 0, memory = 0;
  for (std::size_t i = 1; i < knots.size() && knots[i - 1].t_s < t_s; ++i) {
    const double length = knots[i].t_s - knots[i - 1].t_s;
    const double rate = (knots[i].kPa - knots[i - 1].kPa) / length;
    const double end_s = std::min(t_s, knots[i].t_s);
    kPa = knots[i - 1].kPa + rate * (end_s - knots[i - 1].t_s);
    const double since_begin = t_s - knots[i - 1].t_s, since_end = t_s - end_s;
    if (kind == CreepKind::logarithmic) {
      memory += rate * (log_integral(since_begin) - log_integral(since_end));
    } else if (kind == CreepKind::exponential) {
      const double decayed = std::exp(-since_end / d.creep_s) - std::exp(-since_begin / d.creep_s);
      memory += rate * (since_begin - since_end - d.creep_s * decayed);
    }
  }
  return kPa + d.creep * memory;
}

class Recorder {
 public:
  Recorder(RunData& out, double reading_s) : out_(out), reading_s_(reading_s) {
    out_.run = 1;
    out_.row.protocol_name = "fit world";
    out_.listing.exit_status = ExitStatus::success;
    out_.area_m2 = kArea_m2;
    out_.probe_diameter_m = kDiameter_mm * 1e-3;
    out_.function = "Cp-D";
    MeterSetting meter;
    meter.frequency_Hz = 100e3;
    out_.settings.push_back({-1e9, meter});
    out_.steps = {"s"};
    knots.push_back({0, 0});
  }
  void stay(double seconds) { go(kPa_, seconds); }
  void go(double kPa, double seconds) {
    const int n = std::max(1, static_cast<int>(std::lround(seconds / reading_s_)));
    const double from = kPa_;
    for (int i = 0; i < n; ++i) {
      reading(from + (kPa - from) * i / n, from + (kPa - from) * (i + 1) / n, 0, 0);
    }
    kPa_ = kPa;
    knots.push_back({t_s, kPa});
  }
  void level(int number_in_repeat, int readings) {
    LevelRow row;
    row.level = static_cast<std::int32_t>(out_.levels.size()) + 1;
    row.repeat = repeat;
    row.index = number_in_repeat;
    row.target_pressure_Pa = kPa_ * 1e3;
    row.target_force_N = kPa_ * 1e3 * kArea_m2;
    row.planned_readings = readings;
    row.begin_s = t_s;
    for (int k = 1; k <= readings; ++k) reading(kPa_, kPa_, row.level, k);
    out_.levels.push_back(row);
    knots.push_back({t_s, kPa_});
  }
  void contact() {
    out_.contact_s = t_s - 1;
    out_.rest_force_N = 0;
  }
  double t_s = 0;
  std::int32_t repeat = 0;
  std::vector<Knot> knots;

 private:
  void reading(double from_kPa, double to_kPa, std::int32_t level, std::int32_t index) {
    const auto newton = [](double kPa) { return kPa * 1e3 * kArea_m2; };
    RunReading r;
    r.t_s = t_s + reading_s_ / 2;
    r.force_N = static_cast<float>(newton((from_kPa + to_kPa) / 2));
    r.travel_m = static_cast<float>(3e-3 + 1e-5 * r.force_N);
    r.alignment_s = static_cast<float>(reading_s_ / std::sqrt(12.0));
    r.force_rate_N_s = static_cast<float>(newton(to_kPa - from_kPa) / reading_s_);
    r.level = level;
    r.index = index;
    r.repeat = repeat;
    r.present = 3;
    out_.readings.push_back(r);
    ++out_.fresh_readings;
    for (const double part : {0.0, 0.5}) {
      FramePoint p;
      p.t_s = t_s + part * reading_s_;
      p.force_N = static_cast<float>(newton(from_kPa + part * (to_kPa - from_kPa)));
      p.travel_m = static_cast<float>(3e-3 + 1e-5 * p.force_N);
      out_.frame.push_back(p);
      ++out_.frame_samples;
    }
    t_s += reading_s_;
    out_.duration_s = t_s;
  }
  RunData& out_;
  double reading_s_, kPa_ = 0;
};

struct Dice {
  std::mt19937_64 random;
  double even(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
  double normal() { return std::normal_distribution<double>()(random); }
};

// A run of a size and pace that are drawn.
std::vector<Knot> record(const FitWorld& world, Dice& dice, Drawn& d, RunData& out) {
  Recorder run(out, dice.even(0.08, 0.15));
  const int levels = dice.whole(6, 14), repeats = dice.whole(2, 5), readings = dice.whole(10, 30);
  const double settle_s = dice.even(0.5, 3), rate_kPa_s = dice.even(5, 30);
  const double rest_s = dice.even(4, 12), low = dice.even(5, 12);
  const bool between = !world.both_ways && dice.even(0, 1) < 0.3;  // unloads between its levels
  d.top_kPa = dice.even(60, 110);
  run.stay(dice.even(10, 20));
  run.contact();
  for (run.repeat = 1; run.repeat <= repeats; ++run.repeat) {
    double at = 0;
    int index = 0;
    const auto visit = [&](int i) {
      const double kPa = low + (d.top_kPa - low) * i / (levels - 1);
      run.go(kPa, std::max(0.5, std::abs(kPa - at) / rate_kPa_s));
      at = kPa;
      run.stay(settle_s);
      run.level(++index, readings);
      if (!between || i == levels - 1) return;
      run.go(0, std::max(0.5, at / rate_kPa_s));
      run.stay(1);
      at = 0;
    };
    for (int i = 0; i < levels; ++i) visit(i);
    for (int i = levels - 2; world.both_ways && i >= 0; --i) visit(i);
    run.go(0, std::max(0.5, at / rate_kPa_s));
    run.stay(rest_s);
  }
  return run.knots;
}

// Above the loading branch while the force falls; the branches meet at the top and without a load.
double gap_fF(const FitWorld& world, const Drawn& d, double kPa) {
  const double span =
      capacitance_fF(world.law, d, d.top_kPa * 1e3) - capacitance_fF(world.law, d, 0);
  const double u = std::clamp(kPa / d.top_kPa, 0.0, 1.0);
  return 4 * d.hysteresis * span * u * (1 - u);
}

void fill(const FitWorld& world, Dice& dice, const Drawn& d, const std::vector<Knot>& knots,
          RunData& out) {
  std::vector<double> factor(10);
  for (double& f : factor) f = 1 + world.slope_sd * dice.normal();
  bool falling = false;
  for (RunReading& r : out.readings) {
    if (std::abs(r.force_rate_N_s) > 1e-6) falling = r.force_rate_N_s < 0;
    const double kPa = answered_kPa(knots, world.creep, d, r.t_s);
    const double pressed_kPa = r.force_N / kArea_m2 * 1e-3;
    const double c0 = capacitance_fF(world.law, d, 0);
    const double offset_kPa = pressed_kPa > 0 ? d.offset_kPa : 0;
    double delta = capacitance_fF(world.law, d, (kPa - offset_kPa) * 1e3) - c0;
    const double branch = (falling ? 1 : 0) - (d.truth_in_middle ? 0.5 : 0);
    delta += branch * gap_fF(world, d, pressed_kPa);
    delta *= factor[static_cast<std::size_t>(r.repeat)];
    r.capacitance_F = ((c0 + delta) * (1 + d.gain) + world.drift_fF_h * r.t_s / 3600 +
                       world.noise_fF * dice.normal()) *
                      1e-15;
  }
}

Specimen specimen_of_file(double start_mu_Pa) {
  Specimen s;
  s.name = "drawn";
  s.disc_diameter_m = kDiameter_mm * 1e-3;
  s.materials.resize(2);
  s.materials[0].name = "soft";
  s.materials[0].relative_permittivity = kSoftEps;
  s.materials[0].poisson_ratio = 0.5;
  s.materials[0].youngs_modulus_Pa = 3 * start_mu_Pa;
  s.materials[0].given_shear_modulus_Pa = start_mu_Pa;
  s.materials[1].name = "film";
  s.materials[1].relative_permittivity = kFilmEps;
  s.materials[1].rigid = true;
  for (int i = 0; i < kCapacitors; ++i) {
    s.capacitors.push_back({{Layer{0, kSoft_m}, Layer{1, kFilm_m}}});
  }
  return s;
}

}  // namespace

FitDraw draw(const FitWorld& world, std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed * 6364136223846793005ULL + 1442695040888963407ULL)};
  FitDraw out;
  Drawn d;
  // A spring may not shorten to nothing: 110 kPa is a third of the least 3 mu.
  d.mu_Pa = world.law == Law::spring ? dice.even(110e3, 300e3) : dice.even(20e3, 120e3);
  d.thickness = dice.even(-1, 1) * world.thickness_limit;
  d.gain = dice.even(-1, 1) * world.gain_limit;
  d.offset_kPa = dice.even(-0.3, 0.6);
  d.hysteresis = dice.even(0, world.hysteresis_limit);
  d.truth_in_middle = world.hysteresis_limit > 0 && dice.even(0, 1) < 0.5;
  const auto knots = record(world, dice, d, out.data);
  d.creep_s = std::exp(dice.even(std::log(2.0), std::log(100.0)));
  d.creep = dice.even(0, world.creep_limit);
  // The limit is that of a load held for all of the run.
  if (world.creep == CreepKind::logarithmic) d.creep /= std::log10(1 + out.data.duration_s);
  fill(world, dice, d, knots, out.data);
  out.specimen = specimen_of_file(d.mu_Pa * std::exp(dice.even(-0.4, 0.4)));
  out.settings.level = world.law == Law::spring ? Level::linear : Level::hyperelastic;
  out.mu_Pa = d.mu_Pa;
  out.drawn = fmt::format(
      "mu {:.4g} kPa, creep {:.3g}, {:.3g} s, hysteresis {:.3g}{}, thickness {:+.3g}, {} levels",
      d.mu_Pa * 1e-3, d.creep, d.creep_s, d.hysteresis, d.truth_in_middle ? " about" : "",
      d.thickness, out.data.levels.size());
  return out;
}

std::vector<FitWorld> fit_worlds() {
  std::vector<FitWorld> out;
  const auto add = [&out](const char* name, auto change) {
    FitWorld w;
    w.name = name;
    change(w);
    out.push_back(w);
  };
  add("exact, 100 kHz", [](FitWorld& w) { w.exact = true; });
  add("exact, 1 kHz", [](FitWorld& w) { w.exact = true, w.noise_fF = 44; });
  add("exact, slopes +-1 %, gain, drift", [](FitWorld& w) {
    w.exact = true, w.slope_sd = 0.01, w.gain_limit = 5e-4, w.drift_fF_h = 50;
  });
  add("exact, spring", [](FitWorld& w) { w.exact = true, w.law = Law::spring; });
  add("creep, logarithmic",
      [](FitWorld& w) { w.creep = CreepKind::logarithmic, w.creep_limit = 0.1; });
  add("creep, exponential",
      [](FitWorld& w) { w.creep = CreepKind::exponential, w.creep_limit = 0.1; });
  add("creep, exponential, 1 kHz",
      [](FitWorld& w) { w.creep = CreepKind::exponential, w.creep_limit = 0.1, w.noise_fF = 44; });
  add("hysteresis, up only", [](FitWorld& w) { w.hysteresis_limit = 0.1; });
  add("hysteresis, both ways", [](FitWorld& w) { w.hysteresis_limit = 0.1, w.both_ways = true; });
  add("thickness +-5 %", [](FitWorld& w) { w.thickness_limit = 0.05; });
  add("spring, all at once", [](FitWorld& w) {
    w.law = Law::spring, w.creep = CreepKind::logarithmic, w.creep_limit = 0.1;
    w.hysteresis_limit = 0.05, w.thickness_limit = 0.05, w.gain_limit = 5e-4, w.slope_sd = 0.01;
  });
  add("all at once", [](FitWorld& w) {
    w.creep = CreepKind::exponential, w.creep_limit = 0.1;
    w.hysteresis_limit = 0.05, w.thickness_limit = 0.05, w.gain_limit = 5e-4, w.slope_sd = 0.01;
  });
  return out;
}

}  // namespace lcrig::fit_worlds
