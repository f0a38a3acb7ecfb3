// SPDX-License-Identifier: Apache-2.0
// model ladder and model compare.
#include <fmt/ostream.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/compare.hpp"
#include "model/ladder.hpp"
#include "plot/chart.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/output_file.hpp"

namespace lcrig::cli {

namespace {

// A picture with one marker for each level; each row is tagged with its setting.
std::string picture(const Ladder& ladder) {
  plot::Panel panel;
  panel.title = "Time against error of the model's levels";
  panel.x.label = "seconds";
  panel.y.label = fmt::format("relative error of delta C at {:.4g} kPa on the disc",
                              ladder.pressure.si() / 1e3);
  panel.x.log = panel.y.log = true;
  panel.height = 340;
  for (const LadderRow& row : ladder.rows) {
    if (!row.failure.empty() || row.reference || row.relative_error <= 0) continue;
    const std::string level(to_string(row.settings.level));
    auto series = std::ranges::find(panel.series, level, &plot::Series::label);
    if (series == panel.series.end()) {
      plot::Series added;
      added.label = level;
      added.style = plot::mark_style(panel.series.size());
      series = panel.series.insert(series, std::move(added));
    }
    series->add(row.seconds, row.relative_error);
    plot::Tag tag;
    tag.x = row.seconds;
    tag.y = row.relative_error;
    tag.text = row.setting;
    panel.tags.push_back(std::move(tag));
  }
  plot::Figure figure;
  figure.description = panel.title;
  figure.panels.push_back(std::move(panel));
  return plot::to_svg(figure);
}

class LadderCommand final : public Command {
 public:
  LadderCommand()
      : Command("model ladder", "Time against error of every level and mesh",
                "lcrig model ladder --specimen paper-1 --faces bonded_laminate --svg ladder.svg") {}
  void declare(ArgumentList& list) override {
    options_.declare_specimen(list);
    list.number("--pressure-kPa", pressure_kPa_, "P", "Where errors are compared (100)");
    list.option("--svg", svg_, kFileWord, "Write the picture");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (auto fits = require_replaceable(svg_, kPictureMark); !fits) return fits.error();
    auto specimen = options_.specimen(context);
    if (!specimen) return specimen.error();
    const auto area = options_.pressure(*specimen);
    if (!area) return area.error();
    const double on_disc_kPa = pressure_kPa_ * area->on_disc().value_or(1);
    const auto now = [&] { return to_seconds(context.clock.now().time_since_epoch()); };
    auto ladder = climb_ladder(*specimen, Pressure::from_si(on_disc_kPa * 1e3), now);
    if (!ladder) return Failure(ladder.error(), "lcrig model ladder --help");
    if (!svg_.empty()) {
      auto written = write_file(svg_, kPictureMark, picture(*ladder));
      if (!written) return written.error();
    }
    auto all = to_json(*ladder);
    all["pressure"] = to_json(*area);
    all["pressure_kPa"] = pressure_kPa_;
    all["pressure_on_disc_kPa"] = on_disc_kPa;
    return show(context, all, [&](std::ostream& out) {
      fmt::print(out, "{}\n{}", pressure_line(*area), to_table(*ladder));
    });
  }

 private:
  ModelOptions options_;
  double pressure_kPa_ = 100;
  std::string svg_;
};

Outcome<ExitCode> model_compare(Context& context, const std::string&) {
  auto rows = compare_with_paper();
  if (!rows) return Failure(rows.error());
  return show(context, to_json(*rows), [&](std::ostream& out) {
    fmt::print(out,
               "pressure is force over the paper's disc of 4 mm; its probe has the same area\n\n");
    fmt::print(out, "{}\nErrors and ambiguities of the paper:\n", to_table(*rows));
    int number = 0;
    for (const auto& text : paper_errata()) fmt::print(out, "{:>3}. {}\n", ++number, text);
  });
}

constexpr OneWord kModelCompare{"model compare", "The paper's numbers beside the model's",
                                "lcrig model compare", model_compare};

}  // namespace

const CommandFactory kModelLadderCommand = make_command<LadderCommand>;
const CommandFactory kModelCompareCommand = make_command<OneWordCommand, kModelCompare>;

}  // namespace lcrig::cli
