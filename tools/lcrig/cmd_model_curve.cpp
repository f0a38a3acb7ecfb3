// SPDX-License-Identifier: Apache-2.0
// model curve: capacitance against pressure.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "model/curve.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"

namespace lcrig::cli {

namespace {

// The pressures of a curve are over the disc.
nlohmann::json to_json(const Curve& curve, const PressureArea& pressure) {
  nlohmann::json out = lcrig::to_json(curve);
  out["pressure"] = lcrig::to_json(pressure);
  for (auto& point : out["points"]) {
    const double on_disc_kPa = point["pressure_kPa"].get<double>();
    point["pressure_on_disc_kPa"] = on_disc_kPa;
    point["pressure_kPa"] = on_disc_kPa / pressure.on_disc().value_or(1);
  }
  return out;
}

void print_text(std::ostream& out, const Curve& curve, const PressureArea& pressure) {
  const double on_disc = pressure.on_disc().value_or(1);
  fmt::print(out, "{}\n", pressure_line(pressure));
  if (curve.choice) {
    fmt::print(out, "{}", to_text(*curve.choice));
  } else {
    const std::string estimate =
        curve.error_estimate ? fmt::format("{:.2g}", *curve.error_estimate) : "unknown";
    fmt::print(out, "level {}, estimated error {}\n", to_string(curve.settings.level), estimate);
    if (curve.lost_beyond) {
      fmt::print(out, "finite strain has no solution beyond {:.4g} kPa on the disc\n",
                 curve.lost_beyond->si() / 1e3);
    }
  }
  fmt::print(out, "\n{:>12} {:>14} {:>14} {:>14}\n", "pressure_kPa", "capacitance_pF", "delta_C_fF",
             "shortening_um");
  for (const auto& p : curve.points) {
    fmt::print(out, "{:>12.6g} {:>14.8g} {:>14.8g} {:>14.6g}{}\n", p.pressure_Pa / 1e3 / on_disc,
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
    auto area = options_.pressure(*specimen);
    if (!area) return area.error();
    std::vector<Pressure> on_disc;
    for (const Pressure p : *pressures) {
      on_disc.push_back(Pressure::from_si(p.si() * area->on_disc().value_or(1)));
    }
    patience_.seconds_now = [&] { return to_seconds(context.clock.now().time_since_epoch()); };
    auto curve = calc_curve(*specimen, *settings, tolerance_, on_disc, patience_);
    if (!curve) return Failure(curve.error(), options_.ladder_command(context, pressures->back()));
    return show(context, to_json(*curve, *area),
                [&](std::ostream& out) { print_text(out, *curve, *area); });
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
