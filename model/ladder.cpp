// SPDX-License-Identifier: Apache-2.0
#include "model/ladder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/error_estimate.hpp"

namespace lcrig {
namespace {

std::vector<LadderRow> rungs(const Specimen& s) {
  std::vector<LadderRow> rows;
  const auto add = [&](Level level, std::string setting, auto&& change) {
    LadderRow row;
    row.settings.level = level;
    change(row.settings);
    row.setting = std::move(setting);
    rows.push_back(std::move(row));
  };
  const auto nothing = [](LevelSettings&) {};
  add(Level::linear, "spring law", nothing);
  add(Level::hyperelastic, "free", nothing);
  add(Level::hyperelastic, "confined", [](auto& x) { x.lateral = Lateral::confined; });
  if (s.faces == Faces::bonded_laminate) {
    add(Level::bonded, "linear", [](auto& x) { x.nonlinear = false; });
    add(Level::bonded, "nonlinear", nothing);
  }
  for (const Level level : {Level::fem_linear, Level::fem_finite}) {
    const int finest = level == Level::fem_linear ? kFinestMesh : kFinestFiniteMesh;
    for (int mesh = 0; mesh <= finest; ++mesh) {
      add(level, fmt::format("mesh {}", mesh), [&](auto& x) { x.mesh.refinement = mesh; });
    }
  }
  return rows;
}

// Fills `seconds`. `relative_error` first holds delta C itself.
void run(ErrorEstimator& estimator, const Specimen& s, Pressure pressure,
         const std::function<double()>& now, LadderRow& row) {
  constexpr double kQuick = 0.2;  // seconds; longer ones are timed only once
  row.seconds = 1e300;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const double start = now();
    auto model = make_level_model(s, row.settings);
    auto state = model ? (*model)->at_pressure(pressure) : Result<StackState>(fail(model.error()));
    const double seconds = now() - start;
    if (!state) {
      row.failure = state.error().what;
      row.seconds = seconds;
      return;
    }
    row.seconds = std::min(row.seconds, seconds);
    row.relative_error = state->delta_capacitance_F;
    if (seconds > kQuick) break;
  }
  if (const auto estimate = estimator.estimate(row.settings, pressure)) {
    row.error_estimate = estimate->relative;
    row.lost_beyond = estimate->lost_beyond;
  }
}

// The exact one-dimensional solution, which exists with free faces.
LadderRow* find_exact(const Specimen& s, std::vector<LadderRow>& rows) {
  for (auto& row : rows) {
    if (s.faces == Faces::free && row.failure.empty() &&
        row.settings.level == Level::hyperelastic && row.settings.lateral == Lateral::free) {
      return &row;
    }
  }
  return nullptr;
}

// Finds the finest meshes that have a limit at this pressure, and their limit.
bool find_limit(ErrorEstimator& estimator, Ladder& ladder) {
  LevelSettings settings;
  for (const Level level : {Level::fem_finite, Level::fem_linear}) {
    settings.level = level;
    for (int mesh = level == Level::fem_finite ? kFinestFiniteMesh : kFinestMesh; mesh >= 0;
         --mesh) {
      settings.mesh.refinement = mesh;
      const auto limit = estimator.mesh_limit(settings, ladder.pressure);
      if (limit && limit->value > 0) {
        ladder.delta_capacitance_F = limit->value;
        ladder.reference_doubt = limit->doubt / limit->value;
        ladder.reference =
            fmt::format("the limit of {}, meshes up to {}{}", to_string(level), mesh,
                        level == Level::fem_linear ? ": finite strain has no solution here" : "");
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Result<Ladder> climb_ladder(const Specimen& specimen, Pressure pressure,
                            const std::function<double()>& seconds_now) {
  if (auto ok = check_specimen(specimen); !ok) return fail(ok.error());
  Ladder ladder;
  ladder.pressure = pressure;
  ladder.rows = rungs(specimen);
  ErrorEstimator estimator(specimen);
  for (auto& row : ladder.rows) {
    // without contact gaps: they are not strain, and the errors are those of the stack
    run(estimator, estimator.specimen(), pressure, seconds_now, row);
  }
  if (LadderRow* exact = find_exact(specimen, ladder.rows)) {
    exact->reference = true;
    ladder.delta_capacitance_F = exact->relative_error;
    ladder.reference = "exact";
  } else if (!find_limit(estimator, ladder)) {
    return fail(Errc::invalid_request, "specimen {}: no level answers at {} kPa: {}", specimen.name,
                pressure.si() / 1e3, ladder.rows.back().failure);
  }
  for (auto& row : ladder.rows) {
    row.relative_error = std::abs(row.relative_error / ladder.delta_capacitance_F - 1);
  }
  std::sort(ladder.rows.begin(), ladder.rows.end(), [](const auto& a, const auto& b) {
    return a.failure.empty() != b.failure.empty() ? a.failure.empty() : a.seconds < b.seconds;
  });
  return ladder;
}

nlohmann::json to_json(const Ladder& ladder) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : ladder.rows) {
    nlohmann::json item{{"level", to_string(row.settings.level)},
                        {"setting", row.setting},
                        {"seconds", row.seconds},
                        {"reference", row.reference}};
    if (row.failure.empty()) {
      item["relative_error"] = row.relative_error;
      item["error_estimate"] = row.error_estimate ? nlohmann::json(*row.error_estimate) : nullptr;
      if (row.lost_beyond) item["estimate_at_kPa"] = row.lost_beyond->si() / 1e3;
    } else {
      item["relative_error"] = nullptr;
      item["failure"] = row.failure;
    }
    rows.push_back(std::move(item));
  }
  return {{"pressure_kPa", ladder.pressure.si() / 1e3},
          {"delta_C_fF", ladder.delta_capacitance_F * 1e15},
          {"reference", ladder.reference},
          {"reference_doubt", ladder.reference_doubt},
          {"rows", rows}};
}

std::string to_table(const Ladder& ladder) {
  std::string text = fmt::format("{:<13} {:<10} {:>10} {:>10} {:>10}\n", "level", "setting",
                                 "seconds", "error", "estimate");
  for (const auto& row : ladder.rows) {
    text += fmt::format("{:<13} {:<10} {:>10.2g} ", to_string(row.settings.level), row.setting,
                        row.seconds);
    const std::string estimate =
        row.error_estimate ? fmt::format("{:.2g}", *row.error_estimate) : "unknown";
    if (!row.failure.empty()) {
      text += "no answer: " + row.failure + "\n";
    } else if (row.reference) {
      text += fmt::format("{:>10} {:>10}\n", "reference", estimate);
    } else {
      text += fmt::format("{:>10.2g} {:>10}{}\n", row.relative_error, estimate,
                          row.lost_beyond ? fmt::format(" at {:.4g} kPa, beyond: extrapolated",
                                                        row.lost_beyond->si() / 1e3)
                                          : "");
    }
  }
  text += fmt::format("errors are against {:.7g} fF: {}", ladder.delta_capacitance_F * 1e15,
                      ladder.reference);
  text += ladder.reference_doubt > 0
              ? fmt::format(", itself in doubt by {:.2g}\n", ladder.reference_doubt)
              : "\n";
  return text;
}

}  // namespace lcrig
