// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/budget_text.hpp"

// A budget as table, JSON and picture.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "plot/chart.hpp"
#include "tools/lcrig/live_line.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

constexpr std::string_view kPerPressure = "fF/kPa";

json to_json(const Prediction& p, const PressureArea& pressure) {
  json out{{"quantity", p.quantity}, {"unit", p.unit}};
  if (!p.reason.empty()) {
    out["reason"] = p.reason;
    out["value"] = out["standard_error"] = nullptr;
    return out;
  }
  out["value"] = p.value;
  if (const auto on_disc = pressure.on_disc(); on_disc && p.unit == kPerPressure) {
    out["value_on_disc"] = p.value / *on_disc;
  }
  out["standard_error"] = p.standard_error;
  out["relative_percent"] = p.relative() * 100;
  out["half_width"] = p.half_width;
  out["half_width_percent"] = p.relative_half_width() * 100;
  out["combined_uncertainty"] = p.uncertainty.combined;
  out["expanded_uncertainty"] = p.uncertainty.expanded;
  out["dominating"] = p.uncertainty.dominating() ? p.uncertainty.dominating()->name : "";
  json parts = json::array();
  for (const UncertaintyPart& part : p.uncertainty.parts) {
    parts.push_back(
        {{"part", part.name},
         {"included", !part.is_gap},
         {"standard_uncertainty", part.is_gap ? json(nullptr) : json(part.standard_uncertainty)},
         {"kind", to_string(part.kind)},
         {"shrinks", part.shrinks},
         {"basis", part.basis}});
  }
  out["parts"] = std::move(parts);
  out["not_included"] = p.uncertainty.gaps();
  return out;
}

json to_json(const BudgetPoint& p, bool with_results, const PressureArea& pressure = {}) {
  json out{{"aperture", to_string(p.aperture)},
           {"frequency_Hz", p.frequency_Hz},
           {"parameters", p.parameters},
           {"possible", p.possible()}};
  if (!p.possible()) {
    out["reason"] = p.refused;
    return out;
  }
  out["note"] = p.note;
  out["noise_guessed"] = p.noise_guessed;
  out["duration_s"] = p.duration_s;
  out["readings"] = p.readings;
  out["worst_percent"] = p.worst * 100;
  out["worst_half_width_percent"] = p.worst_half_width * 100;
  out["worst_expanded_percent"] = p.worst_expanded * 100;
  out["not_predicted"] = p.not_predicted;
  out["front"] = p.front;
  if (!with_results) return out;
  json results = json::array();
  for (const Prediction& r : p.predictions) results.push_back(to_json(r, pressure));
  out["results"] = std::move(results);
  return out;
}

std::string frequency_text(double Hz) {
  return Hz >= 1000 ? fmt::format("{:g} kHz", Hz / 1000) : fmt::format("{:g} Hz", Hz);
}

std::string setting_text(const BudgetPoint& p) {
  return fmt::format("{}, {}", to_string(p.aperture), frequency_text(p.frequency_Hz));
}

std::string parameter_text(const BudgetPoint& p) {
  std::string out;
  for (const auto& [name, value] : p.parameters) {
    out += fmt::format("{}-p {}={:g}", out.empty() ? "" : " ", name, value);
  }
  return out.empty() ? "as the protocol says" : out;
}

void append_row(const BudgetPoint& p, std::string& out) {
  const std::string head =
      fmt::format("{:8} {:>9}", to_string(p.aperture), frequency_text(p.frequency_Hz));
  if (!p.possible()) {
    out += head + "  cannot be done: " + p.refused + "\n";
    return;
  }
  std::string lead = fmt::format("{} {:>9} {:>9}", head, format_time(p.duration_s), p.readings);
  for (const Prediction& r : p.predictions) {
    out += fmt::format("{:38}  {:24}", lead, r.quantity);
    lead.clear();
    if (!r.reason.empty()) {
      out += " " + r.reason + "\n";
      continue;
    }
    const auto* most = r.uncertainty.dominating();
    const auto gaps = r.uncertainty.gaps();
    const auto expanded =
        fmt::format("{}{:.2g}", gaps.empty() ? "" : ">= ", r.uncertainty.expanded);
    out +=
        fmt::format(" {:>10.4g} {:>10.2g} +-{:>6.3g}% {:>10}  {}{}\n", r.value, r.standard_error,
                    r.relative_half_width() * 100, expanded, most ? most->name : "",
                    gaps.empty() ? "" : fmt::format("; not included: {}", fmt::join(gaps, ", ")));
  }
  if (!p.note.empty()) out += fmt::format("{:38}  {}\n", "", p.note);
  if (p.noise_guessed) {
    out += fmt::format("{:38}  the noise of this aperture is a guess: --noise-from RUN\n", "");
  }
}

// Says why a target is not met. A result without a prediction counts as unmet.
std::string unmet_text(const BudgetSetting& s) {
  if (s.planned.not_predicted.empty()) return "not within the protocol's parameters\n";
  return fmt::format("cannot be told: nothing predicts {}\n",
                     fmt::join(s.planned.not_predicted, ", "));
}

plot::Series series_of(const std::vector<BudgetPoint>& points) {
  plot::Series out;
  for (const BudgetPoint& p : points) {
    out.add(p.duration_s, p.worst_half_width * 100);
  }
  return out;
}

void add_front(const Budget& budget, plot::Panel& panel) {
  std::vector<BudgetPoint> front;
  for (const BudgetSetting& s : budget.settings) {
    if (s.planned.possible() && s.planned.front) front.push_back(s.planned);
    for (const BudgetPoint& p : s.curve) {
      if (p.front) front.push_back(p);
    }
  }
  std::ranges::sort(front, {}, &BudgetPoint::duration_s);
  plot::Series line = series_of(front);
  line.label = "best for its time (Pareto front)";
  line.style.color = "#b5b5b5";
  line.style.width = 7;
  panel.series.insert(panel.series.begin(), std::move(line));
}

void add_settings(const Budget& budget, plot::Panel& panel) {
  plot::Series planned;
  planned.label = "as the protocol says";
  planned.style = plot::mark_style(3);
  planned.style.color = "#000000";
  planned.style.filled = true;
  std::size_t n = 0;
  for (const BudgetSetting& s : budget.settings) {
    plot::Series line = series_of(s.curve);
    line.label = setting_text(s.planned);
    line.style = plot::mark_style(n);
    line.style.dash = plot::line_style(n).dash;
    line.style.line = true;
    ++n;
    if (!line.x.empty()) panel.series.push_back(std::move(line));
    if (!s.planned.possible()) continue;
    planned.add(s.planned.duration_s, s.planned.worst_half_width * 100);
  }
  panel.series.push_back(std::move(planned));
}

}  // namespace

json to_json(const Budget& budget) {
  json rows = json::array();
  for (const BudgetSetting& s : budget.settings) {
    json row = to_json(s.planned, true, budget.pressure);
    json curve = json::array();
    for (const BudgetPoint& p : s.curve) curve.push_back(to_json(p, false));
    row["curve"] = std::move(curve);
    if (budget.target) row["to_target"] = s.to_target ? to_json(*s.to_target, false) : json();
    rows.push_back(std::move(row));
  }
  json out{{"model_level", budget.model_level},
           {"pressure", lcrig::to_json(budget.pressure)},
           {"rows", std::move(rows)}};
  out["target_percent"] = budget.target ? json(*budget.target * 100) : json();
  out["cheapest"] = budget.cheapest ? to_json(*budget.cheapest, true, budget.pressure) : json();
  return out;
}

std::string to_table(const Budget& budget) {
  std::string out = budget.pressure.words();
  if (!out.empty()) out += '\n';
  out += fmt::format("{:8} {:>9} {:>9} {:>9}  {:24} {:>10} {:>10} {:>9} {:>10}  {}\n", "aperture",
                     "frequency", "time", "readings", "result", "expected", "std error", "interval",
                     "all, +-", "largest part");
  for (const BudgetSetting& s : budget.settings) append_row(s.planned, out);
  if (!budget.target) return out;
  out += fmt::format(
      "\nfor an interval of +-{:g} % of every result (half of what analyze is expected to print; "
      "in brackets with what the rig may err by, which no measuring makes smaller):\n",
      *budget.target * 100);
  for (const BudgetSetting& s : budget.settings) {
    out += fmt::format("{:8} {:>9}  ", to_string(s.planned.aperture),
                       frequency_text(s.planned.frequency_Hz));
    out += s.to_target
               ? fmt::format("{:>9} {:>7.2g}% ({:.2g}%) {}\n", format_time(s.to_target->duration_s),
                             s.to_target->worst_half_width * 100, s.to_target->worst_expanded * 100,
                             parameter_text(*s.to_target))
               : unmet_text(s);
  }
  out +=
      budget.cheapest
          ? fmt::format("\ncheapest: aperture {}, {}: {}\n", setting_text(*budget.cheapest),
                        format_time(budget.cheapest->duration_s), parameter_text(*budget.cheapest))
          : "\nno setting meets the target: give --frequency-Hz a list with higher ones\n";
  return out;
}

std::string to_svg(const Budget& budget, const std::string& title) {
  plot::Panel panel;
  panel.title = title;
  panel.x.label = "run time, s";
  panel.y.label = "half of the worst interval, % of its value";
  panel.x.log = panel.y.log = true;
  panel.height = 380;
  add_settings(budget, panel);
  add_front(budget, panel);
  if (budget.target) {
    plot::Rule rule;
    rule.at = *budget.target * 100;
    rule.dash = plot::Dash::dashed;
    panel.rules.push_back(rule);
  }
  plot::Figure figure;
  figure.description = title;
  figure.panels.push_back(std::move(panel));
  return plot::to_svg(figure);
}

}  // namespace lcrig::cli
