// SPDX-License-Identifier: Apache-2.0
#include "model/auto_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/fringe.hpp"

namespace lcrig {
namespace {

// Fringe field of the capacitor with the widest gap, relative to its C0.
double fringe_size(const Specimen& s) {
  double worst = 0;
  for (const auto& capacitor : s.capacitors) {
    double d = 0;
    for (const auto& layer : capacitor.layers) d += layer.thickness_m;
    const double permittivity = d / s.dielectric_gap_m(capacitor);
    worst = std::max(worst, fringe_in_air(d / (s.disc_diameter_m / 2), permittivity));
  }
  return worst;
}

// Relative gain of delta C if rigid layers were as soft as polyimide (2.5 GPa, nu 0.34).
double film_strain_size(const Specimen& s, Pressure pressure, double delta_F) {
  constexpr double kFilmModulus_Pa = 2.5e9 * (1 - 0.34) / ((1 + 0.34) * (1 - 2 * 0.34));
  double gain = 0;
  for (const auto& capacitor : s.capacitors) {
    double closing = 0;
    for (const auto& layer : capacitor.layers) {
      const auto& m = s.material(layer);
      closing += m.rigid ? layer.thickness_m / m.relative_permittivity : 0;
    }
    closing *= pressure.si() / kFilmModulus_Pa;
    gain += s.c0_F(capacitor) * closing / s.dielectric_gap_m(capacitor);
  }
  return delta_F > 0 ? gain / delta_F : 0;
}

Result<double> delta_at(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  auto model = make_level_model(s, settings);
  if (!model) return fail(model.error());
  auto state = (*model)->at_pressure(pressure);
  if (!state) return fail(state.error());
  return state->delta_capacitance_F;
}

std::vector<Omission> list_omissions(const Specimen& s, Pressure pressure, double delta_F) {
  LevelSettings held;
  held.lateral = Lateral::confined;
  const auto confined = s.faces == Faces::free ? delta_at(s, held, pressure) : Result<double>(0);
  std::vector<Omission> list;
  list.push_back({"fringe field", fringe_size(s),
                  "of C0, Kirchhoff's formula with the dielectric ending at the rim; nearly "
                  "constant under load"});
  list.push_back({"strain of rigid films", film_strain_size(s, pressure, delta_F),
                  "of delta C, if they were polyimide of 2.5 GPa"});
  if (s.faces == Faces::free && confined && delta_F > 0) {
    list.push_back({"lateral friction", 1 - *confined / delta_F,
                    "of delta C, at most: if the faces did not slide at all"});
  }
  list.push_back({"viscosity", 0.04, "of delta C over 10 s; assumed, no source for this material"});
  list.push_back({"electrode stiffness", 0, "printed electrodes have no thickness in the model"});
  return list;
}

constexpr double kHarder = 8;  // cells of half the size take about this many times longer

// Lists the levels, the cheapest first. A level that cannot describe the faces is eliminated later,
// by its error estimate.
std::vector<LevelSettings> candidates(const Specimen& s) {
  std::vector<LevelSettings> list;
  const auto add = [&](Level level, int refinement) {
    LevelSettings settings;
    settings.level = level;
    settings.mesh.refinement = refinement;
    list.push_back(settings);
  };
  if (s.faces == Faces::free) {
    add(Level::linear, 1);
    add(Level::hyperelastic, 1);
    return list;
  }
  if (s.faces == Faces::bonded_laminate) add(Level::bonded, 1);
  for (const Level level : {Level::fem_linear, Level::fem_finite}) {
    for (int refinement = 0;
         refinement <= (level == Level::fem_finite ? kFinestFiniteMesh : kFinestMesh);
         ++refinement) {
      add(level, refinement);
    }
  }
  return list;
}

std::string name_of(const LevelSettings& settings) {
  std::string name(to_string(settings.level));
  if (settings.level >= Level::fem_linear) {
    name += fmt::format(" (mesh {})", settings.mesh.refinement);
  }
  return name;
}

std::string beyond(const std::optional<Pressure>& lost) {
  return lost ? fmt::format(
                    "; finite strain has no solution beyond {:.4g} kPa, what lies there is "
                    "extrapolated",
                    lost->si() / 1e3)
              : "";
}

// One search for the cheapest level that is good enough.
class LevelSearch {
 public:
  LevelSearch(ErrorEstimator& estimator, double tolerance, Pressure pressure,
              const std::optional<SearchTime>& patience)
      : estimator_(estimator),
        tolerance_(tolerance),
        pressure_(pressure),
        patience_(patience),
        start_s_(patience ? patience->seconds_now() : 0) {}

  Result<LevelChoice> run();

 private:
  bool hopeless(const LevelSettings& settings) const;
  std::optional<double> too_long(const LevelSettings& settings) const;
  double elapsed_s() const;  // 0 without a clock
  Result<ErrorEstimate> rate(const LevelSettings& settings);
  LevelChoice choice(const LevelSettings& settings, const ErrorEstimate& estimate);
  tl::unexpected<Error> refuse(const std::string& limit) const;
  void reject(const LevelSettings& settings, const std::string& why) {
    rejected_ += fmt::format("{}{} {}", rejected_.empty() ? "" : ", ", name_of(settings), why);
  }

  ErrorEstimator& estimator_;
  double tolerance_;
  Pressure pressure_;
  const std::optional<SearchTime>& patience_;
  double start_s_;
  double slowest_s_ = 0;  // seconds of the slowest rating
  LevelSettings slowest_;  // the setting that took them
  std::optional<std::pair<LevelSettings, ErrorEstimate>> last_;  // the coarser mesh, if it answered
  std::optional<Level> without_answer_;  // last level that has no answer at this pressure
  std::string rejected_;
  double least_ = std::numeric_limits<double>::infinity();  // smallest error among the levels tried
  std::string least_by_;  // the level with this error, and the seconds it took
};

// True if a coarser mesh has shown that a finer one of the same level cannot help.
bool LevelSearch::hopeless(const LevelSettings& settings) const {
  if (settings.level == without_answer_) return true;
  if (!last_ || last_->first.level != settings.level || settings.level < Level::fem_linear) {
    return false;
  }
  const ErrorEstimate& e = last_->second;
  if (settings.level == Level::fem_linear) return e.left_out > tolerance_;
  return e.lost_beyond || (!e.settled && last_->first.mesh.refinement > 0);
}

// The seconds that this mesh would take, if they exceed the time that is left. The first rating
// solves mesh 0 of both families, whatever it rates. It is always tried, because nothing tells in
// advance how long it takes.
std::optional<double> LevelSearch::too_long(const LevelSettings& settings) const {
  if (!patience_ || rejected_.empty() || settings.level < Level::fem_linear) return std::nullopt;
  const int mesh = settings.mesh.refinement;
  const int solved = slowest_.level == settings.level ? slowest_.mesh.refinement : 0;
  if (mesh <= solved) return std::nullopt;
  const double finer_by = halvings(solved, mesh, settings.level == Level::fem_finite);
  const double next = std::pow(kHarder, finer_by) * slowest_s_;
  return elapsed_s() + next > patience_->seconds ? std::optional(next) : std::nullopt;
}

double LevelSearch::elapsed_s() const {
  return patience_ ? patience_->seconds_now() - start_s_ : 0;
}

Result<ErrorEstimate> LevelSearch::rate(const LevelSettings& settings) {
  const double before = elapsed_s();
  auto estimate = estimator_.estimate(settings, pressure_);
  if (const double seconds = elapsed_s() - before; seconds > slowest_s_) {
    slowest_s_ = seconds;
    slowest_ = settings;
  }
  last_.reset();
  if (estimate) last_.emplace(settings, *estimate);
  return estimate;
}

LevelChoice LevelSearch::choice(const LevelSettings& settings, const ErrorEstimate& estimate) {
  const Specimen& s = estimator_.specimen();
  LevelChoice choice;
  choice.settings = settings;
  choice.error_estimate = estimate.relative;
  choice.lost_beyond = estimate.lost_beyond;
  choice.reason =
      fmt::format("faces `{}`, up to {:.4g} kPa: {} errs by {:.2g} of the {:.2g} allowed{}{}{}",
                  to_string(s.faces), estimate.lost_beyond.value_or(pressure_).si() / 1e3,
                  name_of(settings), estimate.relative, tolerance_, beyond(estimate.lost_beyond),
                  rejected_.empty() ? "" : "; cheaper: ", rejected_);
  const Pressure at = estimate.lost_beyond.value_or(pressure_);
  choice.left_out = list_omissions(s, at, estimator_.delta_F(settings, at).value_or(0));
  return choice;
}

tl::unexpected<Error> LevelSearch::refuse(const std::string& limit) const {
  const std::string best = std::isfinite(least_)
                               ? fmt::format("{:.2g} can be met by {}", least_ * 1.01, least_by_)
                               : "no level covers this stack at this pressure";
  return fail(Errc::invalid_request,
              "specimen {}: no level meets a tolerance of {:.2g} at {:.4g} kPa; {}{} (estimated "
              "errors: {})",
              estimator_.specimen().name, tolerance_, pressure_.si() / 1e3, best, limit, rejected_);
}

Result<LevelChoice> LevelSearch::run() {
  for (const LevelSettings& settings : candidates(estimator_.specimen())) {
    if (hopeless(settings)) continue;
    if (const auto seconds = too_long(settings)) {
      return refuse(fmt::format("; {} would take about {:.2g} s more, over the limit of {:.4g} s",
                                name_of(settings), *seconds, patience_->seconds));
    }
    const auto estimate = rate(settings);
    if (!estimate) {
      without_answer_ = settings.level;
      reject(settings, "not applicable");
      continue;
    }
    if (estimate->lost_beyond && !estimator_.delta_F(settings, pressure_)) {
      last_.reset();  // a finer mesh may have an answer there
      reject(settings,
             fmt::format("has no solution beyond {:.4g} kPa", estimate->lost_beyond->si() / 1e3));
      continue;
    }
    if (estimate->relative <= tolerance_) return choice(settings, *estimate);
    if (estimate->relative < least_) {
      least_ = estimate->relative;
      least_by_ = name_of(settings) +
                  (patience_ ? fmt::format(" in {:.2g} s", elapsed_s()) : std::string());
    }
    reject(settings, fmt::format("{:.2g}{}", estimate->relative,
                                 estimate->settled ? "" : " (its meshes do not converge)"));
  }
  return refuse("");
}

}  // namespace

Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance, Pressure max_pressure,
                                 const std::optional<SearchTime>& patience) {
  ErrorEstimator estimator(specimen);
  return choose_level(estimator, tolerance, max_pressure, patience);
}

Result<LevelChoice> choose_level(ErrorEstimator& estimator, double tolerance, Pressure max_pressure,
                                 const std::optional<SearchTime>& patience) {
  if (!(tolerance > 0) || !(max_pressure.si() > 0) || !std::isfinite(max_pressure.si())) {
    return fail(Errc::invalid_request, "tolerance {} and largest pressure {} kPa must be positive",
                tolerance, max_pressure.si() / 1e3);
  }
  if (auto ok = check_specimen(estimator.specimen()); !ok) return fail(ok.error());
  return LevelSearch(estimator, tolerance, max_pressure, patience).run();
}

nlohmann::json to_json(const LevelChoice& choice) {
  nlohmann::json left_out = nlohmann::json::array();
  for (const auto& o : choice.left_out) {
    left_out.push_back(
        {{"effect", o.effect}, {"relative_size", o.relative_size}, {"note", o.note}});
  }
  const auto lost =
      choice.lost_beyond ? nlohmann::json(choice.lost_beyond->si() / 1e3) : nlohmann::json(nullptr);
  return {{"level", to_string(choice.settings.level)},
          {"lost_beyond_kPa", lost},
          {"mesh", choice.settings.mesh.refinement},
          {"form", to_string(choice.settings.form)},
          {"pressure_kind", to_string(choice.settings.pressure_kind)},
          {"error_estimate", choice.error_estimate},
          {"reason", choice.reason},
          {"left_out", left_out}};
}

std::string to_text(const LevelChoice& choice) {
  std::string text =
      fmt::format("level {}: {}\n  estimated error {:.2g}; left out:\n",
                  to_string(choice.settings.level), choice.reason, choice.error_estimate);
  for (const auto& o : choice.left_out) {
    text += fmt::format("  {:24} {:8.2g}  {}\n", o.effect, o.relative_size, o.note);
  }
  return text;
}

}  // namespace lcrig
