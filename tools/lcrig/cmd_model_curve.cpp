// SPDX-License-Identifier: Apache-2.0
// model curve: capacitance against pressure.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "model/curve.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"

namespace lcrig::cli {

namespace {

void print_text(std::ostream& out, const Curve& curve) {
  if (curve.choice) {
    fmt::print(out, "{}", to_text(*curve.choice));
  } else {
    const std::string estimate =
        curve.error_estimate ? fmt::format("{:.2g}", *curve.error_estimate) : "unknown";
    fmt::print(out, "level {}, estimated error {}\n", to_string(curve.settings.level), estimate);
    if (curve.lost_beyond) {
      fmt::print(out, "finite strain has no solution beyond {:.4g} kPa\n",
                 curve.lost_beyond->si() / 1e3);
    }
  }
  fmt::print(out, "\n{:>12} {:>14} {:>14} {:>14}\n", "pressure_kPa", "capacitance_pF", "delta_C_fF",
             "shortening_um");
  for (const auto& p : curve.points) {
    fmt::print(out, "{:>12.6g} {:>14.8g} {:>14.8g} {:>14.6g}{}\n", p.pressure_Pa / 1e3,
               p.capacitance_F * 1e12, p.delta_capacitance_F * 1e15, p.shortening_m * 1e6,
               p.extrapolated ? "  extrapolated" : "");
  }
}

class CurveCommand final : public Command {
 public:
  CurveCommand()
      : Command("model curve", "Capacitance against pressure, from the model",
                "lcrig model curve --specimen paper-1 --pressure-kPa 0:100:10") {}
  void declare(ArgumentList& list) override {
    options_.declare_specimen(list);
    options_.declare_level(list);
    list.option("--pressure-kPa", pressures_, "FROM:TO:STEP", "Or a list P1,P2,... (0:100:10)");
    list.number("--tolerance", tolerance_, "X", "Relative error allowed to `auto` (0.01)");
    list.number("--time-limit-s", patience_.seconds, "T",
                "Seconds that `auto` may search (no limit)");
  }

  Outcome<ExitCode> run(Context& context) override {
    auto specimen = options_.specimen(context);
    if (!specimen) return specimen.error();
    auto settings = options_.settings();
    if (!settings) return settings.error();
    auto pressures = parse_pressures_kPa(pressures_);
    if (!pressures) {
      return Failure(kUsage, pressures.error().what, "give them such as 0:100:10, or 10,20,50");
    }
    if (!(tolerance_ > 0)) {
      return Failure(kUsage, "--tolerance must be positive",
                     "give the relative error that is allowed, such as 0.01");
    }
    if (!(patience_.seconds > 0)) {
      return Failure(kUsage, "--time-limit-s must be positive",
                     "give the seconds that it may take");
    }
    patience_.seconds_now = [&] { return to_seconds(context.clock.now().time_since_epoch()); };
    auto curve = calc_curve(*specimen, *settings, tolerance_, *pressures, patience_);
    if (!curve) return Failure(curve.error(), options_.ladder_command(context, pressures->back()));
    return show(context, to_json(*curve), [&](std::ostream& out) { print_text(out, *curve); });
  }

 private:
  ModelOptions options_;
  double tolerance_ = 0.01;
  SearchTime patience_;
  std::string pressures_ = "0:100:10";
};

}  // namespace

const CommandFactory kModelCurveCommand = make_command<CurveCommand>;

}  // namespace lcrig::cli
