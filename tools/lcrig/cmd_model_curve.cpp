// SPDX-License-Identifier: Apache-2.0
// model curve: capacitance against pressure.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "model/curve.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

namespace {

class CurveCommand final : public Command {
 public:
  const char* name() const override { return "model curve"; }
  const char* summary() const override { return "Capacitance against pressure, from the model"; }
  const char* example() const override {
    return "lcrig model curve --specimen paper-1 --pressure-kPa 0:100:10";
  }
  void declare(ArgumentList& list) override {
    options_.declare_specimen(list);
    options_.declare_level(list);
    list.option("--pressure-kPa", pressures_, "FROM:TO:STEP", "Or a list P1,P2,... (0:100:10)");
    list.option("--tolerance", tolerance_, "X", "Relative error allowed to `auto` (0.01)");
    list.option("--budget-s", budget_s_, "T", "Seconds that `auto` may search (no limit)");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<WorkBudget> work_budget(const Context& context) const;

  ModelOptions options_;
  std::string pressures_ = "0:100:10", tolerance_ = "0.01", budget_s_;
};

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

Outcome<WorkBudget> CurveCommand::work_budget(const Context& context) const {
  WorkBudget budget;
  budget.seconds_now = [&] { return to_seconds(context.clock.now().time_since_epoch()); };
  if (budget_s_.empty()) return budget;
  auto seconds = parse_number("--budget-s", budget_s_);
  if (!seconds) return tl::unexpected(seconds.error());
  if (!(*seconds > 0)) {
    return tl::unexpected(Failure(kUsage, "--budget-s must be positive", "--budget-s 10"));
  }
  budget.seconds = *seconds;
  return budget;
}

Outcome<ExitCode> CurveCommand::run(Context& context) {
  auto specimen = options_.specimen(context);
  if (!specimen) return tl::unexpected(specimen.error());
  auto settings = options_.settings();
  if (!settings) return tl::unexpected(settings.error());
  auto tolerance = parse_number("--tolerance", tolerance_);
  if (!tolerance) return tl::unexpected(tolerance.error());
  auto pressures = parse_pressures_kPa(pressures_);
  if (!pressures) {
    return tl::unexpected(Failure(kUsage, pressures.error().what, "--pressure-kPa 0:100:10"));
  }
  auto budget = work_budget(context);
  if (!budget) return tl::unexpected(budget.error());
  auto curve = calc_curve(*specimen, *settings, *tolerance, *pressures, *budget);
  if (!curve) return tl::unexpected(Failure(curve.error(), "lcrig model ladder --help"));
  if (context.global.json) {
    print_json(context.console.out, to_json(*curve));
  } else {
    print_text(context.console.out, *curve);
  }
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_model_curve_command() {
  return std::make_unique<CurveCommand>();
}

}  // namespace lcrig::cli
