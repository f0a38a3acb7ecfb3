// SPDX-License-Identifier: Apache-2.0
#include "model/ladder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/error_estimate.hpp"
#include "model/fem_levels.hpp"

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
    const int finest = level == Level::fem_linear ? kFinestMesh : 2;
    for (int mesh = 0; mesh <= finest; ++mesh) {
      add(level, fmt::format("mesh {}", mesh), [&](auto& x) { x.mesh.refinement = mesh; });
    }
  }
  return rows;
}

// Fills seconds and, as relative_error for now, delta C itself.
void run(const Specimen& s, Pressure pressure, const std::function<double()>& now, LadderRow& row) {
  constexpr double kQuick = 0.2;  // seconds; longer ones are timed once
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
    if (seconds > kQuick) {
      break;
    }
  }
  if (const auto estimate = estimate_error(s, row.settings, pressure)) {
    row.error_estimate = *estimate;
  }
}

// The best that answered: with free faces the exact one-dimensional solution, else the finest
// finite-strain mesh.
LadderRow* find_reference(const Specimen& s, std::vector<LadderRow>& rows) {
  LadderRow* best = nullptr;
  for (auto& row : rows) {
    const bool exact = s.faces == Faces::free && row.settings.level == Level::hyperelastic &&
                       row.settings.lateral == Lateral::free;
    if (row.failure.empty() && (exact || s.faces != Faces::free)) {
      best = &row;
    }
  }
  return best;
}

constexpr double kWidth = 900, kHeight = 440, kLeft = 70, kBottom = 390, kRight = 690, kTop = 30;

double place(double value, double low, double high, double from, double to) {
  return from + (std::log10(value) - low) / (high - low) * (to - from);
}

std::string_view color_of(Level level) {
  switch (level) {
    case Level::linear: return "#888888";
    case Level::hyperelastic: return "#1b7f5c";
    case Level::bonded: return "#b8860b";
    case Level::fem_linear: return "#2b5fad";
    case Level::fem_finite: return "#b03030";
  }
  return "#000000";
}

std::string numbered_dot(double x, double y, int number, std::string_view color) {
  return fmt::format(
      "<circle cx='{0:.1f}' cy='{1:.1f}' r='8' fill='{2}'/>"
      "<text x='{0:.1f}' y='{3:.1f}' text-anchor='middle' font-size='10' fill='white'>{4}</text>\n",
      x, y, color, y + 3.5, number);
}

std::string grid_lines(double x0, double x1, double y0, double y1) {
  std::string svg;
  for (double x = x0; x <= x1; ++x) {
    const double at = kLeft + (x - x0) / (x1 - x0) * (kRight - kLeft);
    svg += fmt::format(
        "<line x1='{0:.1f}' y1='{1}' x2='{0:.1f}' y2='{2}' stroke='#ddd'/>"
        "<text x='{0:.1f}' y='{3}' text-anchor='middle'>1e{4}</text>\n",
        at, kTop, kBottom, kBottom + 18, static_cast<int>(x));
  }
  for (double y = y0; y <= y1; ++y) {
    const double at = kBottom - (y - y0) / (y1 - y0) * (kBottom - kTop);
    svg += fmt::format(
        "<line x1='{1}' y1='{0:.1f}' x2='{2}' y2='{0:.1f}' stroke='#ddd'/>"
        "<text x='{3}' y='{4:.1f}' text-anchor='end'>1e{5}</text>\n",
        at, kLeft, kRight, kLeft - 6, at + 4, static_cast<int>(y));
  }
  return svg;
}

}  // namespace

Result<Ladder> climb_ladder(const Specimen& specimen, Pressure pressure,
                            const std::function<double()>& seconds_now) {
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error());
  }
  Ladder ladder{pressure, 0, rungs(specimen)};
  for (auto& row : ladder.rows) {
    run(specimen, pressure, seconds_now, row);
  }
  LadderRow* reference = find_reference(specimen, ladder.rows);
  if (!reference) {
    return fail(Errc::invalid_request, "specimen {}: no level answers at {} kPa: {}", specimen.name,
                pressure.si() / 1e3, ladder.rows.back().failure);
  }
  reference->reference = true;
  ladder.delta_capacitance_F = reference->relative_error;
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
    } else {
      item["relative_error"] = nullptr;
      item["failure"] = row.failure;
    }
    rows.push_back(std::move(item));
  }
  return {{"pressure_kPa", ladder.pressure.si() / 1e3},
          {"delta_C_fF", ladder.delta_capacitance_F * 1e15},
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
      text += fmt::format("{:>10.2g} {:>10}\n", row.relative_error, estimate);
    }
  }
  return text;
}

std::string to_svg(const Ladder& ladder) {
  double x0 = 9, x1 = -9, y0 = 0, y1 = 0;
  std::vector<const LadderRow*> shown;
  for (const auto& row : ladder.rows) {
    if (row.failure.empty() && !row.reference && row.relative_error > 0) {
      shown.push_back(&row);
      x0 = std::min(x0, std::floor(std::log10(row.seconds)));
      x1 = std::max(x1, std::ceil(std::log10(row.seconds)));
      y0 = std::min(y0, std::floor(std::log10(row.relative_error)));
      y1 = std::max(y1, std::ceil(std::log10(row.relative_error)));
    }
  }
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {} {}' font-family='sans-serif' "
      "font-size='12'>\n<rect width='100%' height='100%' fill='white'/>\n",
      kWidth, kHeight);
  if (x1 > x0 && y1 > y0) {
    svg += grid_lines(x0, x1, y0, y1);
  }
  int number = 0;
  for (const LadderRow* row : shown) {
    ++number;
    const double x = place(row->seconds, x0, std::max(x1, x0 + 1), kLeft, kRight);
    const double y = place(row->relative_error, y0, std::max(y1, y0 + 1), kBottom, kTop);
    svg += numbered_dot(x, y, number, color_of(row->settings.level));
    const double line = kTop + 22 * number;
    svg += numbered_dot(kRight + 24, line, number, color_of(row->settings.level));
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}'>{}, {}</text>\n", kRight + 40, line + 4,
                       to_string(row->settings.level), row->setting);
  }
  svg += fmt::format(
      "<text x='{}' y='{}' text-anchor='middle'>seconds</text>"
      "<text x='16' y='20'>relative error of delta C at {:.4g} kPa</text>\n</svg>\n",
      (kLeft + kRight) / 2, kBottom + 38, ladder.pressure.si() / 1e3);
  return svg;
}

}  // namespace lcrig
