// SPDX-License-Identifier: Apache-2.0
// Options that the `model` commands share: the specimen, and how to model it.
#pragma once

#include <optional>
#include <string>

#include "model/level.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

class ModelOptions {
 public:
  void declare_specimen(ArgumentList& list);  // --specimen, --faces, --top, --probe-diameter-mm
  void declare_level(ArgumentList& list);  // --level and its variations

  // The specimen with --faces and --top applied. Failure: unknown name, bad file.
  Outcome<Specimen> specimen(const Context& context) const;
  // What the pressures of the command are over: the probe that was given, else the disc. Failure:
  // the probe presses only a part of the disc; usage.
  Outcome<PressureArea> pressure(const Specimen& specimen) const;
  // The command that shows each level's error and seconds for the same specimen.
  std::string ladder_command(const Context& context, Pressure pressure) const;
  // Empty when --level was not given or is `auto`. Failure: usage.
  Outcome<std::optional<LevelSettings>> settings() const;

 private:
  std::string specimen_, faces_, top_;
  std::string level_ = "auto", kind_ = "dead", form_ = "A", lateral_ = "free", area_ = "reference",
              mesh_ = "1";
  bool fringe_ = false;
  std::optional<double> probe_mm_;
};

inline constexpr const char* kProbeHelp =
    "State pressures over a probe of this diameter (default: over the disc)";
// Failure: as ModelOptions::pressure.
Outcome<PressureArea> over_probe(const std::optional<double>& probe_mm, const Specimen& specimen);
// The first line of a model command: which pressure is meant.
std::string pressure_line(const PressureArea& pressure);

// A number in an option. Failure: usage, naming the option.
Outcome<double> parse_number(const char* option, const std::string& text);

}  // namespace lcrig::cli
