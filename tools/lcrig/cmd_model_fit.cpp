// SPDX-License-Identifier: Apache-2.0
// model fit: shear modulus and contact offset of a recorded run.
#include <fmt/ostream.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/fit.hpp"
#include "model/specimen_file.hpp"
#include "storage/run_summary.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class FitCommand final : public Command {
 public:
  const char* name() const override { return "model fit"; }
  const char* summary() const override { return "Shear modulus and contact offset of a run"; }
  const char* example() const override { return "lcrig model fit last"; }
  void declare(ArgumentList& list) override {
    list.positional("RUN", run_, "Number, or `last`");
    options_.declare_level(list);
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  std::string run_;
  ModelOptions options_;
};

struct LevelMean {
  double force_N = 0, capacitance_F = 0;
};

// Means over the counted readings of each `measure` level, and of the force while they were taken
// (the target, where the frame does not report one).
Outcome<std::vector<LevelMean>> level_means(const Database& db, std::int64_t run) {
  auto query = db.prepare(
      "SELECT g.c, coalesce((SELECT avg(f.force_N) FROM frame_sample AS f WHERE f.run_id = ?1"
      " AND f.received_mono_ns BETWEEN g.begin_ns AND g.end_ns), g.target)"
      " FROM (SELECT avg(r.capacitance_F) AS c, min(r.asked_mono_ns) AS begin_ns,"
      " max(r.last_byte_mono_ns) AS end_ns, max(l.target_force_N) AS target"
      " FROM lcr_reading AS r JOIN level AS l ON l.run_id = r.run_id AND l.level = r.level"
      " WHERE r.run_id = ?1 AND r.reading_index IS NOT NULL AND r.capacitance_F IS NOT NULL"
      " GROUP BY r.level ORDER BY r.level) AS g");
  if (!query) return tl::unexpected(Failure(query.error()));
  query->bind(0, run);
  std::vector<LevelMean> means;
  while (true) {
    auto row = query->step();
    if (!row) return tl::unexpected(Failure(row.error()));
    if (!*row) return means;
    const auto force = query->optional_real(1);
    if (force && *force > 0) means.push_back({*force, query->real(0)});
  }
}

Outcome<std::vector<FitPoint>> fit_points(const Database& db, std::int64_t run,
                                          const Specimen& specimen) {
  auto summary = summarise_run(db, run);
  if (!summary) return tl::unexpected(Failure(summary.error()));
  if (!summary->c0_F) {
    return tl::unexpected(Failure(kFailed, fmt::format("run {} has no reading before contact", run),
                                  "lcrig runs list"));
  }
  auto means = level_means(db, run);
  if (!means) return tl::unexpected(means.error());
  std::vector<FitPoint> points;
  for (const auto& m : *means) {
    points.push_back({m.force_N / specimen.area_m2(), m.capacitance_F - *summary->c0_F, 0});
  }
  return points;
}

json to_json(const FitValue& v, double scale) {
  return json{{"value", v.value * scale},
              {"standard_error", v.standard_error * scale},
              {"ci95", json::array({v.ci95_low * scale, v.ci95_high * scale})}};
}

Outcome<ExitCode> FitCommand::run(Context& context) {
  auto db = open_runs(context);
  if (!db) return tl::unexpected(db.error());
  auto id = named_run(*db, run_);
  if (!id) return tl::unexpected(id.error());
  auto row = get_run(*db, *id);
  if (!row) return tl::unexpected(Failure(row.error()));
  auto specimen = parse_specimen(row->specimen_text, row->specimen_name);
  if (!specimen) return tl::unexpected(Failure(specimen.error()));
  auto settings = options_.settings();
  if (!settings) return tl::unexpected(settings.error());
  auto points = fit_points(*db, *id, *specimen);
  if (!points) return tl::unexpected(points.error());
  LevelSettings level;  // the cheapest that knows these faces: the fit solves it many times
  if (specimen->faces == Faces::bonded_laminate) level.level = Level::bonded;
  if (specimen->faces == Faces::bonded_base) level.level = Level::fem_linear;
  auto fit = fit_response(*specimen, settings->value_or(level), *points);
  if (!fit) return tl::unexpected(Failure(fit.error(), "lcrig runs show " + run_));
  const auto& mu = fit->shear_modulus_Pa;
  const auto& offset = fit->contact_offset_Pa;
  if (context.global.json) {
    json out{{"run", *id}, {"level", to_string(settings->value_or(level).level)}};
    out["shear_modulus_kPa"] = to_json(mu, 1e-3);
    out["contact_offset_kPa"] = to_json(offset, 1e-3);
    out["residual_fF"] = fit->residual_F * 1e15;
    out["points"] = fit->points;
    print_json(context.console.out, out);
    return kOk;
  }
  fmt::print(context.console.out,
             "run {}: {} levels\nshear modulus   {:.4g} kPa, 95 % {:.4g} to {:.4g}\n"
             "contact offset  {:.4g} kPa, 95 % {:.4g} to {:.4g}\nresidual        {:.3g} fF rms\n",
             *id, fit->points, mu.value / 1e3, mu.ci95_low / 1e3, mu.ci95_high / 1e3,
             offset.value / 1e3, offset.ci95_low / 1e3, offset.ci95_high / 1e3,
             fit->residual_F * 1e15);
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_model_fit_command() {
  return std::make_unique<FitCommand>();
}

}  // namespace lcrig::cli
