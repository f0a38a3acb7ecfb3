// SPDX-License-Identifier: Apache-2.0
// model fit: shear modulus and contact offset of a recorded run.
#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "analysis/fit_data.hpp"
#include "analysis/pressure_of_run.hpp"
#include "model/auto_level.hpp"
#include "model/fit.hpp"
#include "model/specimen_file.hpp"
#include "storage/frame_capabilities.hpp"
#include "storage/proof.hpp"
#include "storage/run_summary.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

constexpr double kTolerances[] = {1e-3, 1e-2,
                                  0.1};  // relative, of the model; the first that is met

struct LevelMean {
  double force_N = 0, capacitance_F = 0;
};

// The counted and proven readings of a `measure` level.
struct LevelSum {
  std::int64_t begin_ns = 0, end_ns = 0, count = 0;
  double capacitance_F = 0;
};

Result<std::map<std::int64_t, LevelSum>> level_sums(const Database& db, std::int64_t run) {
  auto proof = Proof::load(db, run);
  if (!proof) return fail(proof.error());
  ProofWalk walk(*proof);
  std::map<std::int64_t, LevelSum> out;
  const auto take = [&](const Statement& row) {
    if (!walk.is_proven(row.integer(1))) return;
    LevelSum& sum = out[row.integer(0)];
    if (sum.count++ == 0) sum.begin_ns = row.integer(1);
    sum.end_ns = row.integer(2);
    sum.capacitance_F += row.real(3);
  };
  auto all = db.each(
      "SELECT level, asked_mono_ns, last_byte_mono_ns, capacitance_F FROM lcr_reading WHERE"
      " run_id = ? AND reading_index IS NOT NULL AND capacitance_F IS NOT NULL ORDER BY seq",
      take, run);
  if (!all) return fail(all.error());
  return out;
}

// Means over these readings, and the mean force during them (or the target, where the frame does
// not report a force).
Outcome<std::vector<LevelMean>> level_means(const Database& db, std::int64_t run) {
  auto sums = level_sums(db, run);
  if (!sums) return Failure(sums.error());
  std::vector<LevelMean> means;
  for (const auto& [level, sum] : *sums) {
    auto force_N = db.first<double>(
        "SELECT coalesce((SELECT avg(force_N) FROM frame_sample WHERE run_id = ?1 AND"
        " received_mono_ns BETWEEN ?2 AND ?3), (SELECT target_force_N FROM level WHERE"
        " run_id = ?1 AND level = ?4))",
        run, sum.begin_ns, sum.end_ns, level);
    if (!force_N) return Failure(force_N.error());
    if (!*force_N || !(**force_N > 0)) continue;
    means.push_back({**force_N, sum.capacitance_F / static_cast<double>(sum.count)});
  }
  return means;
}

// The levels and rests as the analysis reads them.
Result<FitData> fit_data_of_levels(const Database& db, std::int64_t run, const Specimen& specimen) {
  const auto data = load_run_data(db, run);
  if (!data) return fail(data.error());
  const auto analysis = analyse(*data);
  if (!analysis) return fail(analysis.error());
  return fit_data_of(*data, *analysis, specimen.area_m2());
}

Outcome<FitData> fit_data(const Context& context, const Database& db, std::int64_t run,
                          const Specimen& specimen) {
  if (auto of_levels = fit_data_of_levels(db, run, specimen)) return std::move(*of_levels);
  auto summary = summarise_run(db, run);
  if (!summary) return Failure(summary.error());
  if (!summary->c0_F) {
    return Failure(kFailed, fmt::format("run {} has no reading before contact", run),
                   next_command(context.global, {"runs"}));
  }
  auto means = level_means(db, run);
  if (!means) return means.error();
  FitData out;
  for (const auto& m : *means) {
    out.points.emplace_back(m.force_N / specimen.area_m2(), m.capacitance_F - *summary->c0_F);
  }
  return out;
}

// Chooses the cheapest level whose estimated error is small enough, or the best one if none is.
Result<LevelChoice> choose(const Specimen& specimen, const std::vector<FitPoint>& points) {
  double highest = 1;
  for (const FitPoint& p : points) highest = std::max(highest, p.pressure_Pa);
  Result<LevelChoice> choice = fail(Errc::bug, "no tolerance");
  for (const double tolerance : kTolerances) {
    choice = choose_level(specimen, tolerance, Pressure::from_si(highest));
    if (choice) break;
  }
  return choice;
}

// The rig's relative error of pressure. Modulus and offset have the same relative error.
struct RigError {
  double force_percent = 0, diameter_mm = 0;  // limits
  double relative = 0;  // standard uncertainty of a pressure
};

RigError error_of_rig(const StoredCapabilities& frame, double area_m2) {
  const RigAccuracy rig;
  RigError out;
  out.force_percent = force_limit_percent(rig, frame.force_class_percent, frame.weights);
  out.diameter_mm = rig.diameter_limit_mm();
  const double diameter_mm = std::sqrt(4 * area_m2 / std::numbers::pi) * 1e3;
  out.relative = std::hypot(rectangular(out.force_percent / 100),
                            2 * rectangular(out.diameter_mm) / diameter_mm);
  return out;
}

json to_json(const FitValue& v, double scale, double model_error) {
  return json{{"value", v.value * scale},
              {"standard_error", v.standard_error * scale},
              {"ci95", json::array({v.ci95_low * scale, v.ci95_high * scale})},
              {"model_uncertainty", model_error * std::abs(v.per_model_error) * scale}};
}

struct FittedRun {
  std::int64_t number;
  bool simulated, intact;
};

json of_pressure(const FitValue& v, double model_error, const RigError& rig) {
  json out = to_json(v, 1e-3, model_error);
  out["rig_uncertainty"] = rig.relative * std::abs(v.value) * 1e-3;
  return out;
}

json to_json(const FitMisfit& m) {
  json patterns = json::array(), pulls = json::array();
  for (const FitPattern& p : m.patterns) {
    patterns.push_back(
        {{"kind", to_string(p.kind)}, {"size_percent", p.size_percent}, {"text", p.text}});
  }
  for (const FitPull& p : m.pulls) {
    pulls.push_back({{"pressure_kPa", p.pressure_Pa * 1e-3},
                     {"time_s", p.time_s},
                     {"residual_fF", p.residual_F * 1e15},
                     {"pull", p.pull}});
  }
  return json{{"chi2", m.chi2},
              {"degrees_of_freedom", m.degrees_of_freedom},
              {"p", m.p},
              {"law_fF", m.law_F * 1e15},
              {"patterns", std::move(patterns)},
              {"c0_pull", m.c0_pull},
              {"pulls", std::move(pulls)}};
}

json to_json(const FitParts& p) {
  return json{{"repeats", p.repeats * 100},      {"c0", p.c0 * 100},
              {"drift", p.drift * 100},          {"creep", p.creep * 100},
              {"misfit", p.misfit * 100},        {"geometry", p.geometry * 100},
              {"hysteresis", p.hysteresis * 100}};
}

json to_json(const FittedRun& run, const LevelSettings& level, double model_error,
             const RigError& rig, const Fit& fit) {
  return json{{"run", run.number},
              {"simulated", run.simulated},
              {"intact", run.intact},
              {"level", to_string(level.level)},
              {"model_error", model_error},
              {"verdict", fit.misfit.found() ? "misfit" : "fits"},
              {"misfit", to_json(fit.misfit)},
              {"parts_percent", to_json(fit.parts)},
              {"shear_modulus_kPa", of_pressure(fit.shear_modulus_Pa, model_error, rig)},
              {"contact_offset_kPa", of_pressure(fit.contact_offset_Pa, model_error, rig)},
              {"c0_shift_fF", to_json(fit.c0_shift_F, 1e15, model_error)},
              {"residual_fF", fit.residual_F * 1e15},
              {"repeats", fit.repeats},
              {"points", fit.points}};
}

std::string line_of(const char* name, const FitValue& v, double scale, const char* unit,
                    double model_error) {
  std::string out = fmt::format("{:<15} {:.4g} {}, 95 % {:.4g} to {:.4g}", name, v.value * scale,
                                unit, v.ci95_low * scale, v.ci95_high * scale);
  if (model_error > 0) {
    out += fmt::format("; the model may move it by {:.2g}",
                       model_error * std::abs(v.per_model_error) * scale);
  }
  return out + "\n";
}

std::string verdict_of(const FitMisfit& m) {
  std::string out = fmt::format("{:<15} ", "verdict");
  if (m.found()) {
    out += "misfit; the intervals include it";
  } else {
    out += "the law describes the levels";
  }
  out +=
      fmt::format(" (without creep and misfit: chi2 {:.3g} for {:g} degrees of freedom, p {:.2g}",
                  m.chi2, m.degrees_of_freedom, m.p);
  if (m.c0_pull != 0) out += fmt::format("; C0 pulled by {:+.2g} standard errors", m.c0_pull);
  out += ")\n";
  for (const FitPattern& p : m.patterns) out += fmt::format("  {}\n", p.text);
  const auto worst =
      std::ranges::max_element(m.pulls, {}, [](const FitPull& p) { return std::abs(p.pull); });
  if (m.found() && worst != m.pulls.end()) {
    out += fmt::format("  largest pull of a level: {:+.2g}, {:+.3g} fF at {:.4g} kPa\n",
                       worst->pull, worst->residual_F * 1e15, worst->pressure_Pa * 1e-3);
  }
  return out;
}

std::string parts_line(const FitParts& p) {
  return fmt::format(
      "{:<15} of the modulus, %: repeats {:.2g}, C0 {:.2g}, drift {:.2g}, creep {:.2g}, misfit "
      "{:.2g}; shifts: geometry {:.2g}, hysteresis {:.2g}\n",
      "uncertainty", p.repeats * 100, p.c0 * 100, p.drift * 100, p.creep * 100, p.misfit * 100,
      p.geometry * 100, p.hysteresis * 100);
}

std::string to_text(const FittedRun& run, const LevelSettings& level, double model_error,
                    const RigError& rig, const Fit& fit) {
  std::string out = fmt::format("{}run {}: {} points of levels and rests, model {}",
                                run.simulated ? "simulated " : "", run.number, fit.points,
                                to_string(level.level));
  if (model_error > 0) out += fmt::format(" (its estimated error: {:.2g} %)", model_error * 100);
  out += "\n" + line_of("shear modulus", fit.shear_modulus_Pa, 1e-3, "kPa", model_error);
  out += line_of("contact offset", fit.contact_offset_Pa, 1e-3, "kPa", model_error);
  if (fit.c0_shift_F.standard_error > 0) {
    out += line_of("C0 shift", fit.c0_shift_F, 1e15, "fF", model_error);
  }
  out += verdict_of(fit.misfit) + parts_line(fit.parts);
  out += fmt::format(
      "not in these intervals: force (limits of {:g} %) and area (diameter within {:g} mm), "
      "assumed; "
      "they move modulus and offset in proportion, the modulus by {:.2g} kPa (standard "
      "uncertainty)\n",
      rig.force_percent, rig.diameter_mm, rig.relative * fit.shear_modulus_Pa.value * 1e-3);
  return out + fmt::format("residual        {:.3g} fF rms\n", fit.residual_F * 1e15);
}

class FitCommand final : public Command {
 public:
  FitCommand()
      : Command("model fit", "Shear modulus and contact offset of a run", "lcrig model fit last") {}
  void declare(ArgumentList& list) override {
    list.positional(kRunWord, run_, "Number, or `last`");
    options_.declare_level(list);
  }

  Outcome<ExitCode> run(Context& context) override {
    auto run = open_run(context, run_);
    if (!run) return run.error();
    const auto& [db, id] = *run;
    auto row = get_run(db, id);
    if (!row) return Failure(row.error());
    auto specimen = parse_specimen(row->specimen_text, row->specimen_name);
    if (!specimen) return Failure(specimen.error());
    PressureArea pressure = pressure_of_run(*row);
    if (auto whole = require_whole_disc(pressure); !whole) {
      return Failure(whole.error(), next_command(context.global, {"runs", "show", run_}));
    }
    pressure.on = PressureOn::disc;  // of whatever the fit prints
    auto settings = options_.settings();
    if (!settings) return settings.error();
    auto checked = verify_aside(db, id);
    auto data = fit_data(context, db, id, *specimen);
    if (!data) return data.error();
    const auto chain = checked.get();
    if (!chain) return Failure(chain.error(), next_after(chain.error()));
    note_if_changed(context, *chain, id);
    LevelSettings level;
    double model_error = 0;  // relative, of delta C; not estimated for a level that was asked for
    if (*settings) {
      level = **settings;
    } else {
      auto choice = choose(*specimen, data->points);
      if (!choice) return Failure(choice.error(), "lcrig model ladder --help");
      level = choice->settings;
      model_error = choice->error_estimate;
    }
    auto fit = fit_response(*specimen, level, *data);
    if (!fit) return Failure(fit.error(), next_command(context.global, {"runs", "show", run_}));
    const FittedRun of{id, row->simulated, chain->intact};
    const RigError rig =
        error_of_rig(parse_capabilities(row->frame_capabilities_json), specimen->area_m2());
    json all = to_json(of, level, model_error, rig, *fit);
    all["pressure"] = lcrig::to_json(pressure);
    return show(context, all, [&](std::ostream& out) {
      if (pressure.differs()) fmt::print(out, "{}\n", pressure.words());
      out << to_text(of, level, model_error, rig, *fit);
    });
  }

 private:
  std::string run_;
  ModelOptions options_;
};

}  // namespace

const CommandFactory kModelFitCommand = make_command<FitCommand>;

}  // namespace lcrig::cli
