// SPDX-License-Identifier: Apache-2.0
// model design: the best partition of a soft block into capacitors.
#include <fmt/ostream.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/design.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/model_options.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

namespace {

class DesignCommand final : public Command {
 public:
  const char* name() const override { return "model design"; }
  const char* summary() const override { return "Where thin layers belong, and what they gain"; }
  const char* example() const override {
    return "lcrig model design --capacitors 4 --total-mm 1 --least-mm 0.1 --faces bonded_base";
  }
  void declare(ArgumentList& list) override {
    list.option("--capacitors", count_, "N", "Capacitors in the stack (4)");
    list.option("--total-mm", total_, "T", "Thickness of the whole stack (1)");
    list.option("--least-mm", least_, "T", "Thinnest layer that can be made (0.1)");
    list.option("--diameter-mm", diameter_, "D", "Of the disc (4)");
    list.one_of("--faces", faces_, {"free", "bonded_base", "bonded_laminate"},
                "How layers are held sideways (bonded_base)");
    list.one_of("--top", top_, {"pressure", "plate", "bonded_plate"}, "What presses (pressure)");
    list.option("--youngs-modulus-kPa", modulus_, "E", "Of the layers (200)");
    list.option("--poisson-ratio", poisson_, "NU", "Of the layers (0.49)");
    list.option("--permittivity", permittivity_, "EPS", "Relative, of the layers (2.75)");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<DesignRequest> request() const;
  std::string count_ = "4", total_ = "1", least_ = "0.1", diameter_ = "4", faces_ = "bonded_base",
              top_ = "pressure", modulus_ = "200", poisson_ = "0.49", permittivity_ = "2.75";
};

Outcome<DesignRequest> DesignCommand::request() const {
  DesignRequest r;
  double count = 0, total = 0, least = 0, diameter = 0, modulus = 0;
  const auto read = [](const char* option, const std::string& text, double& out) {
    auto value = parse_number(option, text);
    if (value) out = *value;
    return value;
  };
  for (auto& value : {read("--capacitors", count_, count), read("--total-mm", total_, total),
                      read("--least-mm", least_, least), read("--diameter-mm", diameter_, diameter),
                      read("--youngs-modulus-kPa", modulus_, modulus),
                      read("--poisson-ratio", poisson_, r.material.poisson_ratio),
                      read("--permittivity", permittivity_, r.material.relative_permittivity)}) {
    if (!value) return tl::unexpected(value.error());
  }
  if (count != std::floor(count) || count < 1 || count > 100) {
    return tl::unexpected(Failure(kUsage, "--capacitors: expected a whole number, 1 to 100", ""));
  }
  r.capacitors = static_cast<int>(count);
  r.total = Length::from_si(total * 1e-3);
  r.least_layer = Length::from_si(least * 1e-3);
  r.disc_diameter = Length::from_si(diameter * 1e-3);
  r.material.youngs_modulus_Pa = modulus * 1e3;
  r.faces = parse_faces(faces_).value_or(r.faces);
  r.top = parse_top(top_).value_or(r.top);
  return r;
}

Outcome<ExitCode> DesignCommand::run(Context& context) {
  auto wanted = request();
  if (!wanted) return tl::unexpected(wanted.error());
  auto design = design_partition(*wanted);
  if (!design) return tl::unexpected(Failure(design.error(), "lcrig model design --help"));
  if (context.global.json) {
    print_json(context.console.out, to_json(*design));
    return kOk;
  }
  auto& out = context.console.out;
  fmt::print(out, "{}\n", design->method);
  if (design->search_grid_m > 0) {
    fmt::print(out, "searched all partitions in steps of {:.3g} um and refined the best\n",
               design->search_grid_m * 1e6);
  }
  fmt::print(out, "\n{:>8} {:>10} {:>12} {:>9}  {}\n", "C0_pF", "fF/kPa at 0", "0-100 kPa",
             "gain_%", "layers, base to top (um)");
  for (const auto& o : design->options) {
    std::string layers;
    for (const double t : o.thickness_m) layers += fmt::format(" {:.4g}", t * 1e6);
    const std::string fitted =
        o.fitted_F_Pa > 0 ? fmt::format("{:.4g}", o.fitted_F_Pa * 1e18) : std::string("-");
    fmt::print(out, "{:>8.4g} {:>10.4g} {:>12} {:>9.1f}  {}:{}\n", o.c0_F * 1e12,
               o.initial_F_Pa * 1e18, fitted, o.gain * 100, o.placement, layers);
  }
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_model_design_command() {
  return std::make_unique<DesignCommand>();
}

}  // namespace lcrig::cli
