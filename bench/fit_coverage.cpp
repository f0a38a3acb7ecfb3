// SPDX-License-Identifier: Apache-2.0
// Measures how often the intervals of `model fit` contain the truth: modulus, contact offset and C0
// of a specimen with free or with bonded faces. The runs are synthetic: four repeats of levels from
// 10 to 100 kPa with noise, an error of C0, and differences between repeats. The truth for the
// bonded specimen is computed on a finer mesh than the fit uses.
//
// `drawn` instead judges whole runs of specimens that creep, have a hysteresis or are not as thick
// as their file says (fit_worlds.hpp), as they go through the analysis.
//
//   fit_coverage_bench [SEEDS=200] [FIRST_SEED=1] [free|bonded|drawn|all]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "analysis/fit_data.hpp"
#include "bench/fit_worlds.hpp"
#include "model/auto_level.hpp"
#include "model/specimen_file.hpp"

namespace {

using namespace lcrig;

constexpr int kRepeats = 4, kLevels = 6, kReadings = 30, kBaseline = 100;
constexpr double kTrueMu_Pa = 45e3, kTrueOffset_Pa = 400;

Specimen specimen_between(const std::string& faces) {
  std::string text(shipped_specimens().front().text);
  const std::string free = "\"free\"";
  text.replace(text.find(free), free.size(), "\"" + faces + "\"");
  return parse_specimen(text, faces).value();
}

Specimen true_specimen(Specimen s) {
  for (Material& m : s.materials) {
    if (m.rigid) continue;
    m.given_shear_modulus_Pa = kTrueMu_Pa;
    m.youngs_modulus_Pa = 2 * kTrueMu_Pa * (1 + m.poisson_ratio);
  }
  return s;
}

double pressure_Pa(int level) {
  return 10e3 + 90e3 * level / (kLevels - 1);
}

// True change of capacitance at each level.
std::vector<double> true_curve(const Specimen& specimen, const LevelSettings& settings) {
  const auto model = make_level_model(true_specimen(specimen), settings).value();
  std::vector<double> out;
  for (int i = 0; i < kLevels; ++i) {
    const auto p = Pressure::from_si(pressure_Pa(i) - kTrueOffset_Pa);
    out.push_back(model->at_pressure(p)->delta_capacitance_F);
  }
  return out;
}

struct World {
  const char* name;
  double noise_F, slope_sd;
};
constexpr World kWorlds[] = {{"noise at 1 kHz, 44 fF", 44e-15, 0},
                             {"noise at 100 kHz, 0.44 fF", 0.44e-15, 0},
                             {"0.44 fF, slope +-1 % per repeat", 0.44e-15, 0.01}};

struct Held {
  int runs = 0, scatter = 0, with_model = 0;
  double error = 0, half = 0;
  void add(const FitValue& v, double truth, double model_error) {
    const double model = model_error * std::abs(v.per_model_error);
    ++runs;
    scatter += v.ci95_low <= truth && truth <= v.ci95_high ? 1 : 0;
    with_model += v.ci95_low - model <= truth && truth <= v.ci95_high + model ? 1 : 0;
    error += v.value - truth;
    half += (v.ci95_high - v.ci95_low) / 2;
  }
  void print(const std::string& world, const char* what, double scale) const {
    fmt::print("{:<42} {:<20} {:>5} {:>7.1f} {:>7.1f} {:>10.4g} {:>10.4g}\n", world, what, runs,
               100.0 * scatter / runs, 100.0 * with_model / runs, error / runs * scale,
               half / runs * scale);
  }
};

void measure(const Specimen& specimen, const LevelChoice& choice, const std::vector<double>& truth,
             const World& world, int seeds, int first) {
  Held mu, offset, c0;
  int refused = 0;  // number of fits
  for (int seed = first; seed < first + seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) * 7919 + 3);
    std::normal_distribution<double> normal;
    const double c0_error_F = world.noise_F / std::sqrt(kBaseline) * normal(random);
    // The readings before contact estimate their own scatter, with this many degrees of freedom.
    constexpr double kFreedom = kBaseline - 1;
    const double told =
        std::sqrt(std::chi_squared_distribution<double>(kFreedom)(random) / kFreedom);
    const C0Error c0_error(told * world.noise_F / std::sqrt(kBaseline), kFreedom);
    std::vector<FitPoint> points;
    for (int repeat = 1; repeat <= kRepeats; ++repeat) {
      const double factor = 1 + world.slope_sd * normal(random);
      for (int i = 0; i < kLevels; ++i) {
        const double noise_F = world.noise_F / std::sqrt(kReadings) * normal(random);
        const double delta_F = truth[static_cast<std::size_t>(i)] * factor - c0_error_F + noise_F;
        points.emplace_back(pressure_Pa(i), delta_F, told * world.noise_F / std::sqrt(kReadings),
                            repeat);
      }
    }
    const auto fit = fit_response(specimen, choice.settings, FitData(points, c0_error));
    if (!fit) {
      ++refused;
      continue;
    }
    mu.add(fit->shear_modulus_Pa, kTrueMu_Pa, choice.error_estimate);
    offset.add(fit->contact_offset_Pa, kTrueOffset_Pa, choice.error_estimate);
    c0.add(fit->c0_shift_F, -c0_error_F, choice.error_estimate);
  }
  const std::string name = specimen.name + ", " + world.name;
  mu.print(name, "modulus, kPa", 1e-3);
  offset.print(name, "offset, kPa", 1e-3);
  c0.print(name, "C0 shift, fF", 1e15);
  if (refused > 0) fmt::print("{}: {} fits found no answer\n", name, refused);
  std::fflush(stdout);
}

void measure(const std::string& faces, int seeds, int first) {
  Specimen specimen = specimen_between(faces);
  specimen.name = faces;
  const auto choice = choose_level(specimen, 1e-3, Pressure::from_si(100e3)).value();
  LevelSettings finer = choice.settings;
  if (faces != "free") ++finer.mesh.refinement;
  fmt::print("{}: {}, estimated error {:.2g}\n", faces, to_string(choice.settings.level),
             choice.error_estimate);
  const auto truth = true_curve(specimen, finer);
  for (const World& world : kWorlds) measure(specimen, choice, truth, world, seeds, first);
}

void measure_drawn(const fit_worlds::FitWorld& world, int seeds, int first) {
  int refused = 0, held = 0, answered = 0, misfits = 0;
  double half = 0, square = 0;  // relative
  for (int seed = first; seed < first + seeds; ++seed) {
    const auto d = fit_worlds::draw(world, static_cast<std::uint64_t>(seed));
    const auto data = fit_data_of(d.data, analyse(d.data).value(), d.specimen.area_m2()).value();
    const auto fit = fit_response(d.specimen, d.settings, data);
    if (!fit) {
      ++refused;
      continue;
    }
    const FitValue& mu = fit->shear_modulus_Pa;
    ++answered;
    held += mu.ci95_low <= d.mu_Pa && d.mu_Pa <= mu.ci95_high ? 1 : 0;
    misfits += fit->misfit.found() ? 1 : 0;
    half += (mu.ci95_high - mu.ci95_low) / 2 / d.mu_Pa;
    square += std::pow(mu.value / d.mu_Pa - 1, 2);
  }
  const double n = std::max(1, answered);
  fmt::print("{:<36} {:>5} {:>8} {:>7.1f} {:>8} {:>8.2g} {:>8.2g}\n", world.name, answered, refused,
             100 * held / n, misfits, 100 * std::sqrt(square / n), 100 * half / n);
  std::fflush(stdout);
}

void measure_drawn(int seeds, int first) {
  fmt::print("{:<36} {:>5} {:>8} {:>7} {:>8} {:>8} {:>8}\n", "world", "fits", "refused", "held_%",
             "misfits", "error_%", "half_%");
  for (const auto& world : fit_worlds::fit_worlds())
    measure_drawn(world, seeds, first += 1'000'000);
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 200;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  const std::string what = argc > 3 ? argv[3] : "all";
  if (what == "drawn" || what == "all") measure_drawn(seeds, first);
  if (what == "drawn") return 0;
  fmt::print("{:<42} {:<20} {:>5} {:>7} {:>7} {:>10} {:>10}\n", "faces, world", "result", "runs",
             "ci95_%", "+model%", "bias", "half");
  if (what != "bonded") measure("free", seeds, first);
  if (what != "free") measure("bonded_laminate", seeds, first);
}
