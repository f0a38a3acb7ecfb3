// SPDX-License-Identifier: Apache-2.0
// model design: the best partition of a soft block into capacitors.
#include <fmt/ostream.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "model/design.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"

namespace lcrig::cli {

namespace {

// Small loads are proportional, so the initial slope can be stated over either area.
void print_text(std::ostream& out, const Design& design, const PressureArea& pressure) {
  const bool over_probe = pressure.on == PressureOn::probe;
  const double on_disc = pressure.on_disc().value_or(1);
  fmt::print(out, "{}\n", pressure_line(pressure));
  if (over_probe) fmt::print(out, "\"fF/kPa at 0\" is over the probe, 0-100 kPa is on the disc\n");
  fmt::print(out, "{}\n", design.method);
  if (design.search_grid_m > 0) {
    fmt::print(out, "searched all partitions in steps of {:.3g} um and refined the best\n",
               design.search_grid_m * 1e6);
  }
  fmt::print(out, "\n{:>8} {:>10} {:>12} {:>9}  {}\n", "C0_pF", "fF/kPa at 0", "0-100 kPa",
             "gain_%", "layers, base to top (um)");
  for (const auto& o : design.options) {
    std::string layers;
    for (const double t : o.thickness_m) layers += fmt::format(" {:.4g}", t * 1e6);
    const std::string fitted =
        o.fitted_F_Pa > 0 ? fmt::format("{:.4g}", o.fitted_F_Pa * 1e18) : std::string("-");
    fmt::print(out, "{:>8.4g} {:>10.4g} {:>12} {:>9.1f}  {}:{}\n", o.c0_F * 1e12,
               o.initial_F_Pa * 1e18 * on_disc, fitted, o.gain * 100, o.placement, layers);
  }
}

class DesignCommand final : public Command {
 public:
  DesignCommand()
      : Command(
            "model design", "Where thin layers belong, and what they gain",
            "lcrig model design --capacitors 4 --total-mm 1 --least-mm 0.1 --faces bonded_base") {}
  void declare(ArgumentList& list) override {
    const auto mm = [](Length& out) {
      return [&out](double value) { out = Length::from_si(value * 1e-3); };
    };
    const auto modulus = [this](double kPa) { wanted_.material.youngs_modulus_Pa = kPa * 1e3; };
    list.number("--capacitors", count_, "N", "Capacitors in the stack (4)");
    list.number("--total-mm", mm(wanted_.total), "T", "Thickness of the whole stack (1)");
    list.number("--least-mm", mm(wanted_.least_layer), "T",
                "Thinnest layer that can be made (0.1)");
    list.number("--diameter-mm", mm(wanted_.disc_diameter), "D", "Of the disc (4)");
    list.number("--probe-diameter-mm", probe_mm_, "D", kProbeHelp);
    list.one_of("--faces", faces_, all_words<Faces>(),
                "How layers are held sideways (bonded_base)");
    list.one_of("--top", top_, all_words<Top>(), "What presses (pressure)");
    list.number("--youngs-modulus-kPa", modulus, "E", "Of the layers (200)");
    list.number("--poisson-ratio", wanted_.material.poisson_ratio, "NU", "Of the layers (0.49)");
    list.number("--permittivity", wanted_.material.relative_permittivity, "EPS",
                "Relative, of the layers (2.75)");
  }

  Outcome<ExitCode> run(Context& context) override {
    if (count_ != std::floor(count_) || count_ < 1 || count_ > 100) {
      return Failure(kUsage, "--capacitors: expected a whole number, 1 to 100", "");
    }
    wanted_.capacitors = static_cast<int>(count_);
    wanted_.faces = parse_word<Faces>(faces_).value_or(wanted_.faces);
    wanted_.top = parse_word<Top>(top_).value_or(wanted_.top);
    auto design = design_partition(wanted_);
    if (!design) return Failure(design.error(), "lcrig model design --help");
    Specimen disc;
    disc.disc_diameter_m = wanted_.disc_diameter.si();
    disc.top = wanted_.top;
    auto area = over_probe(probe_mm_, disc);
    if (!area) return area.error();
    auto all = to_json(*design);
    all["pressure"] = to_json(*area);  // its other members are over the disc
    return show(context, all, [&](std::ostream& out) { print_text(out, *design, *area); });
  }

 private:
  DesignRequest wanted_;
  double count_ = 4;
  std::optional<double> probe_mm_;
  std::string faces_ = "bonded_base", top_ = "pressure";
};
}  // namespace

const CommandFactory kModelDesignCommand = make_command<DesignCommand>;

}  // namespace lcrig::cli
