// SPDX-License-Identifier: Apache-2.0
#include "model/compare.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/curve.hpp"
#include "model/fem_levels.hpp"
#include "model/specimen_file.hpp"

namespace lcrig {
namespace {

constexpr double kScatter = 0.08;

Result<Specimen> paper_stack(std::size_t n) {
  for (const auto& shipped : shipped_specimens()) {
    if (shipped.name == "paper-1") {
      auto s = parse_specimen(shipped.text, "paper-1");
      if (s) s->capacitors.assign(n, s->capacitors.front());
      return s;
    }
  }
  return fail(Errc::bug, "no shipped specimen paper-1");
}

// The stack as the paper built it: layers bonded to films of elastic kapton (2.5 GPa, nu 0.34).
Specimen bonded(Specimen s) {
  s.faces = Faces::bonded_laminate;
  for (auto& m : s.materials) {
    m.youngs_modulus_Pa = m.rigid ? 2.5e9 : m.youngs_modulus_Pa;
    m.poisson_ratio = m.rigid ? 0.34 : m.poisson_ratio;
    m.rigid = false;
  }
  return s;
}

class Rows {
 public:
  // Adds the sensitivity of N capacitors in fF/kPa: a straight line from 0 to `to_kPa`, 1 kPa
  // steps.

  void sensitivity(const char* target, std::size_t n, double paper, const LevelSettings& settings,
                   double to_kPa, const std::string& assumption, bool laminate = false) {
    auto s = paper_stack(n);
    if (!s) return note(s.error());
    const auto range = parse_pressures_kPa(fmt::format("0:{}:1", to_kPa));
    const auto curve = calc_curve(laminate ? bonded(*s) : *s, settings, 1, range.value());
    if (!curve) return note(curve.error());
    add(target, fmt::format("sensitivity, N = {}, 0 to {} kPa", n, to_kPa), "fF/kPa", paper,
        fit_slope(curve->points) * 1e18, assumption);
  }

  void add(const char* target, std::string quantity, const char* unit, double paper, double model,
           std::string assumption) {
    const bool reproduced = std::abs(model / paper - 1) <= kScatter;
    rows_.push_back(
        {target, std::move(quantity), unit, paper, model, std::move(assumption), reproduced});
  }
  void note(Error error) { error_ = std::move(error); }
  Result<std::vector<PaperComparison>> take() {
    return error_.what.empty() ? Result<std::vector<PaperComparison>>(std::move(rows_))
                               : fail(error_);
  }

 private:
  std::vector<PaperComparison> rows_;
  Error error_;
};

LevelSettings level(Level l, PressureKind kind = PressureKind::dead) {
  LevelSettings settings;
  settings.level = l;
  settings.pressure_kind = kind;
  return settings;
}

void add_t1(Rows& rows) {
  constexpr double kPaper[] = {3.65, 7.29, 10.9};
  for (std::size_t n = 1; n <= 3; ++n) {
    const auto s = paper_stack(n);
    if (!s) return rows.note(s.error());
    rows.add("T1", fmt::format("C0, N = {}", n), "pF", kPaper[n - 1], s->c0_F() * 1e12,
             "ideal parallel plates, 75 um kapton in series with 25 um PDMS, no fringe");
  }
}

void add_t2(Rows& rows) {
  constexpr double kPaper[] = {8.9, 16.9, 25};
  for (std::size_t n = 1; n <= 3; ++n) {
    rows.sensitivity("T2", n, kPaper[n - 1], level(Level::hyperelastic, PressureKind::true_area),
                     100, "free faces, mu 42 kPa, pressure per current area");
    rows.sensitivity("T2", n, kPaper[n - 1], level(Level::hyperelastic), 10,
                     "free faces, mu 42 kPa, dead load");
    rows.sensitivity("T2", n, kPaper[n - 1], level(Level::bonded), 100,
                     "bonded to the kapton, as built: does not reproduce it", true);
  }
}

// Adds the gains of T3, which all come from one field of the 1 mm block.
void add_t3(Rows& rows, const char* how, Top top, ElectrodeArea area) {
  auto paper = paper_stack(1);
  if (!paper) return rows.note(paper.error());
  Specimen block = *paper;
  block.faces = Faces::bonded_base;
  block.top = top;
  std::erase_if(block.materials, [](const Material& m) { return m.rigid; });
  block.capacitors = {{{{0, 1e-3}}}};
  LevelSettings settings = level(Level::fem_linear);
  settings.electrode_area = area;
  auto model = FemLinear::make(block, settings);
  if (!model) return rows.note(model.error());
  const auto slope = [&](const std::vector<double>& cut) {
    std::vector<ModelPoint> points;
    for (int i = 0; i <= 10; ++i) {
      const auto state = (*model)->at_pressure(Pressure::from_si(i * 1e4), cut);
      points.push_back({i * 1e4, 0, state ? state->delta_capacitance_F : NAN, 0});
    }
    return fit_slope(points);
  };
  const double equal4 = slope(std::vector<double>(4, 0.25e-3));
  const double optimal4 = slope({0.1e-3, 0.1e-3, 0.1e-3, 0.7e-3});
  const double optimal6 = slope({0.1e-3, 0.1e-3, 0.1e-3, 0.1e-3, 0.1e-3, 0.5e-3});
  const double equal6 = slope(std::vector<double>(6, 1e-3 / 6));
  rows.add("T3", "4 optimal against 4 equal", "%", 7, 100 * (optimal4 / equal4 - 1), how);
  rows.add("T3", "6 optimal against 4 optimal", "%", 130, 100 * (optimal6 / optimal4 - 1), how);
  rows.add("T3", "6 equal against 4 equal", "%", 120, 100 * (equal6 / equal4 - 1), how);
}

void add_t4(Rows& rows) {
  constexpr double kPaper[] = {5.75, 19.3, 23.7};
  constexpr double kRange[] = {4.7, 10.4, 32.4};
  for (std::size_t n = 1; n <= 3; ++n) {
    rows.sensitivity("T4", n, kPaper[n - 1], level(Level::linear), 30,
                     n == 1 ? "linear, free faces, E 200 kPa"
                            : "linear, free faces, E 200 kPa: no model proportional to N gives it");
  }
  auto s = paper_stack(1);
  auto model = s ? make_level_model(*s, level(Level::hyperelastic, PressureKind::true_area))
                 : fail(s.error());
  if (!model) return rows.note(model.error());
  const auto state = (*model)->at_pressure(Pressure::from_si(1 / s->area_m2()));
  for (std::size_t n = 1; n <= 3 && state; ++n) {
    rows.add(
        "T4", fmt::format("dC/C0 at 1 N, N = {}", n), "%", kRange[n - 1],
        100 * state->delta_capacitance_F / s->c0_F(),
        "free faces, pressure per current area; no model makes it depend on N: not reproducible");
  }
}

void add_t5(Rows& rows) {
  for (const std::size_t n : {std::size_t{5}, std::size_t{10}}) {
    rows.sensitivity("T5", n, n == 5 ? 41.3 : 82.6,
                     level(Level::hyperelastic, PressureKind::true_area), 100,
                     "free faces, pressure per current area (our own prediction)");
  }
}

}  // namespace

Result<std::vector<PaperComparison>> compare_with_paper() {
  Rows rows;
  add_t1(rows);
  add_t2(rows);
  add_t3(rows, "linear, base bonded, thin layers at the base, reference area", Top::pressure,
         ElectrodeArea::reference);
  add_t3(rows, "same, area of the deformed electrode", Top::pressure, ElectrodeArea::deformed);
  add_t3(rows, "same, under a rigid frictionless plate", Top::plate, ElectrodeArea::deformed);
  add_t4(rows);
  add_t5(rows);
  return rows.take();
}

nlohmann::json to_json(const std::vector<PaperComparison>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& r : rows) {
    list.push_back({{"target", r.target},
                    {"quantity", r.quantity},
                    {"unit", r.unit},
                    {"paper", r.paper},
                    {"model", r.model},
                    {"difference_percent", 100 * (r.model / r.paper - 1)},
                    {"assumption", r.assumption},
                    {"reproduced", r.reproduced}});
  }
  return {{"rows", list}, {"errata", paper_errata()}};
}

std::string to_table(const std::vector<PaperComparison>& rows) {
  std::string text = fmt::format("{:<3} {:<36} {:>8} {:>9} {:<7} {:<3} {}\n", "", "quantity",
                                 "paper", "model", "unit", "", "assumption");
  for (const auto& r : rows) {
    text += fmt::format("{:<3} {:<36} {:>8.4g} {:>9.4g} {:<7} {:<3} {}\n", r.target, r.quantity,
                        r.paper, r.model, r.unit, r.reproduced ? "yes" : "no", r.assumption);
  }
  return text;
}

}  // namespace lcrig
