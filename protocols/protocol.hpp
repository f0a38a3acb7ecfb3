// SPDX-License-Identifier: Apache-2.0
// A load protocol as plain data, SI inside. docs/protocol-file.md describes the file. Parser, plan
// and run use it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/pressure_area.hpp"
#include "base/time.hpp"
#include "drivers/lcr_meter.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

struct Parameter {
  double default_value = 0, min = 0, max = 0;  // in the unit of the name's suffix
  double to_si = 1;  // factor of that suffix
  bool integer = false;
  std::string description;
};

// The window that no sample may leave during the run.
struct Limits {
  // N; absent (only where nothing is commanded): the range of the load cell
  std::optional<Number> force_min, force_max;
  std::optional<Number> travel_min, travel_max;  // m, of the machine
  std::optional<Number> gap_min, gap_max;  // m, from contact; both windows apply
  std::optional<Number> speed_max;  // m/s
};

inline constexpr double kFrameRate_Hz = 50;  // when the protocol states none

inline constexpr std::string_view kAutoAperture = "auto";  // the plan chooses and says why

struct Sampling {
  LcrSettings lcr;
  bool aperture_auto = false;  // lcr.aperture is ignored
  bool lcr_continuous = true;  // also record between `measure` steps
  double frame_rate_Hz = kFrameRate_Hz;
};

enum class OnLoss { abort, wait, repeat_step };
template <>
inline constexpr EnumWords<3> kWordsOf<OnLoss>{"abort", "wait", "repeat_step"};

struct Protocol {
  std::string name, title, description;
  std::string file;  // file name, for messages
  std::string text;  // the file unchanged
  std::map<std::string, Parameter> parameters;
  PressureOn pressure_on = PressureOn::probe;  // the body that its pressures are over
  Limits limits;
  Sampling sample;
  OnLoss on_loss = OnLoss::abort;
  Duration on_loss_timeout = std::chrono::minutes(10);  // longest allowed absence of an instrument
  Duration finally_timeout = std::chrono::minutes(5);
  Steps steps, finally_steps;
};

}  // namespace lcrig
