// SPDX-License-Identifier: Apache-2.0
// Compares speed and error of every level of the model with the figures in docs/model.md. Prints a
// table and one JSON object; "meets" is false where a figure is missed. Uses one thread. Usage:
// model_bench
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "model/error_estimate.hpp"
#include "model/fringe.hpp"
#include "model/response.hpp"
#include "model/specimen_file.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using namespace literals;

// Processor time, so that other programs do not matter.
double now() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// The shortest of `repeats` times of `work`, s.
template <class F>
double best_of(int repeats, F&& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const double start = now();
    work();
    best = std::min(best, now() - start);
  }
  return best;
}

// Seconds per call, for quick functions.
template <class F>
double per_call(int calls, F&& work) {
  return best_of(5,
                 [&] {
                   for (int i = 0; i < calls; ++i) work(i);
                 }) /
         calls;
}

Specimen paper(std::size_t n) {
  auto s = parse_specimen(shipped_specimens().front().text, "paper-1").value();
  s.capacitors.assign(n, s.capacitors.front());
  return s;
}

// PDMS (mu 42 kPa, with a matching E) below kapton (2.5 GPa, nu 0.34), all bonded to a fixed base.
Specimen laminate(std::size_t n) {
  Specimen s = paper(n);
  s.faces = Faces::bonded_laminate;
  for (Material& m : s.materials) {
    m.youngs_modulus_Pa = m.rigid ? 2.5e9 : 2 * 42e3 * 1.49;
    m.poisson_ratio = m.rigid ? 0.34 : 0.49;
    m.rigid = false;
  }
  return s;
}

LevelSettings at_level(Level level) {
  LevelSettings settings;
  settings.level = level;
  return settings;
}

json row(const std::string& name, double seconds, double seconds_at_most, double error,
         double error_at_most) {
  return {{"case", name},
          {"seconds", seconds},
          {"seconds_at_most", seconds_at_most},
          {"relative_error", error},
          {"error_at_most", error_at_most},
          {"meets", seconds <= seconds_at_most && error <= error_at_most}};
}

json bench_points() {
  double sum = 0;
  const double stretch = per_call(20'000, [&](int i) {
    sum += solve_stretch(42.0_kPa, 0.49, EnergyForm::a, Lateral::free, PressureKind::dead,
                         Pressure::from_si(5.0 * (i + 1)))
               ->strain;
  });
  const double exact = 1 - 0.1;  // closed form at a stretch of 0.1
  const double found = solve_stretch(42.0_kPa, 0.5, EnergyForm::a, Lateral::free,
                                     PressureKind::dead, 42.0_kPa * (1 / 0.01 - 0.1))
                           ->strain;
  json rows = json::array();
  rows.push_back(row("hyperelastic point", stretch, 1e-6, std::abs(found / exact - 1), 1e-13));
  const auto table = make_response(paper(3), LevelSettings{}, 2.0_N, 1e-4).value();
  const double eval = per_call(100'000, [&](int i) { sum += table->capacitance_F(2e-5 * i); });
  rows.push_back(row("specimen evaluation", eval, 200e-9, table->relative_error(), 1e-5));
  const Plant plant(*table, PlantConfig{});
  const double inverse =
      per_call(100'000, [&](int i) { sum += plant.force_at_travel_N(3e-10 * i); });
  rows.push_back(row("force at travel", inverse, 1e-6, 0, 1));
  const double love = best_of(3, [&] { sum += love_factor(0.0125); });
  rows.push_back(row("fringe, Love, gap 25 um", love, 1e-2,
                     std::abs(love_factor(0.0125) / 1.0293083926 - 1), 1e-8));
  if (!std::isfinite(sum)) std::abort();  // keeps the calls above from being optimized away
  return rows;
}

struct LaminateReference {
  std::size_t n;
  double slope_fF_kPa, delta10_fF, delta100_fF;
};
// Delta C is the limit of our meshes -1 to 2, and at 100 kPa its doubt is 5e-5 to 1e-4. FEniCSx
// rises towards it from below (N = 3: 152.979, 152.997 and 153.008 with degrees 4, 5 and 6, 153.027
// on a mesh finer at the corners) and loses the solution on finer meshes.
constexpr LaminateReference kLaminates[] = {{1, 0.5409208, 5.378, 51.179},
                                            {2, 1.0794701, 10.7327, 102.156},
                                            {3, 1.6170103, 16.0775, 153.043},
                                            {5, 2.6905007, 26.7514, 254.676},
                                            {10, 5.3696862, 53.3913, 508.35}};

json bench_linear(const LaminateReference& r) {
  const Specimen s = laminate(r.n);
  double slope = 0;
  const double seconds = best_of(3, [&] {
    auto model = make_level_model(s, at_level(Level::fem_linear)).value();
    slope = model->at_pressure(Pressure::from_si(1e-3))->delta_capacitance_F * 1e21;
  });
  return row("fem_linear, laminate N = " + std::to_string(r.n), seconds, r.n <= 3 ? 0.1 : 0.5,
             std::abs(slope / r.slope_fF_kPa - 1), 5e-5);
}

json bench_finite(const LaminateReference& r) {
  const Specimen s = laminate(r.n);
  double delta10 = 0, delta100 = 0;
  const double seconds = best_of(2, [&] {
    auto model = make_level_model(s, at_level(Level::fem_finite)).value();
    delta10 = model->at_pressure(10.0_kPa)->delta_capacitance_F * 1e15;
    delta100 = model->at_pressure(100.0_kPa)->delta_capacitance_F * 1e15;
  });
  const double error =
      std::max(std::abs(delta10 / r.delta10_fF - 1), std::abs(delta100 / r.delta100_fF - 1));
  return row("fem_finite, laminate N = " + std::to_string(r.n) + " to 100 kPa", seconds,
             r.n <= 3 ? 1 : 6, error, 3e-4);
}

// The same with the error estimate of `curve` and `auto`: at small strains that of the mesh, at
// finite strains the complete one. It uses the coarsest mesh whose error is below 1e-4.
json bench_estimated(const LaminateReference& r, Level level) {
  const Specimen s = laminate(r.n);
  const bool finite = level == Level::fem_finite;
  const Pressure pressure = finite ? 100.0_kPa : Pressure::from_si(1e-3);
  LevelSettings settings = at_level(level);
  settings.mesh.refinement = finite ? 2 : 0;
  const double reference_F = finite ? r.delta100_fF * 1e-15 : r.slope_fF_kPa * 1e-21;
  double value_F = 0, estimate = 0;
  const double seconds = best_of(2, [&] {
    ErrorEstimator estimator(s);
    value_F = estimator.delta_F(settings, pressure).value();
    if (finite) {
      estimate = estimator.estimate(settings, pressure)->relative;
    } else {
      const auto limit = estimator.mesh_limit(settings, pressure).value();
      estimate = (std::abs(value_F - limit.value) + kDoubtFactor * limit.doubt) / limit.value;
    }
  });
  json result = row(std::string(to_string(level)) + " and its estimate, N = " + std::to_string(r.n),
                    seconds, finite ? 0.5 : 0.05, std::abs(value_F / reference_F - 1), 1e-4);
  result["error_estimate"] = estimate;
  return result;
}

json bench_disc(double shape_factor, double nu, double exact) {
  Specimen s;
  s.name = "disc";
  s.disc_diameter_m = 2;
  s.faces = Faces::bonded_base;
  s.top = Top::bonded_plate;
  s.materials = {Material{"m", 1, false, 1.0, nu, {}}};
  s.capacitors = {{{{0, 1 / (2 * shape_factor)}}}};
  double modulus = 0;
  const double seconds = best_of(3, [&] {
    auto model = make_level_model(s, at_level(Level::fem_linear)).value();
    modulus = 1e-3 / (model->at_pressure(Pressure::from_si(1e-3))->shortening_m * 2 * shape_factor);
  });
  char name[80];
  std::snprintf(name, sizeof name, "bonded disc, S = %g, nu = %g", shape_factor, nu);
  return row(name, seconds, 0.5, std::abs(modulus / exact - 1), 1e-4);
}

int run() {
  json rows = bench_points();
  for (const auto& r : kLaminates) rows.push_back(bench_linear(r));
  for (const auto& r : kLaminates) rows.push_back(bench_finite(r));
  rows.push_back(bench_estimated(kLaminates[2], Level::fem_linear));
  rows.push_back(bench_estimated(kLaminates[2], Level::fem_finite));
  rows.push_back(bench_disc(0.5, 0.5, 1.54466971));
  rows.push_back(bench_disc(2, 0.4999, 8.70688));
  rows.push_back(bench_disc(80, 0.5, 12784.891));
  bool all = true;
  for (const auto& r : rows) {
    std::printf("%-42s %10.3g s (<= %.3g)  error %8.2g (<= %.2g)  %s\n",
                r["case"].get<std::string>().c_str(), r["seconds"].get<double>(),
                r["seconds_at_most"].get<double>(), r["relative_error"].get<double>(),
                r["error_at_most"].get<double>(), r["meets"].get<bool>() ? "ok" : "MISSED");
    all = all && r["meets"].get<bool>();
  }
  std::printf("%s\n", json{{"rows", rows}, {"meets", all}}.dump().c_str());
  return all ? 0 : 1;
}

}  // namespace
}  // namespace lcrig

int main() {
  return lcrig::run();
}
