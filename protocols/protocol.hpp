// SPDX-License-Identifier: Apache-2.0
// A load protocol as plain data, SI inside. docs/protocol-file.md describes the file.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/quantity.hpp"
#include "base/time.hpp"
#include "drivers/lcr_meter.hpp"

namespace lcrig {

// A number of the file, or a reference "$name" to a parameter or a sweep variable.
struct Number {
  Number() = default;
  explicit Number(double v) : value(v) {}
  double value = 0;  // SI, when `name` is empty
  std::string name;  // parameter or variable, without '$'
  // Where a literal stands, for advice on what to change, and SI per unit there.
  std::string pointer;
  double to_si = 1;
};

// What a load step aims at. `value` is m, N or Pa (pressure becomes force by the probe area).
enum class TargetKind { travel, gap, force, pressure };
struct Target {
  Target() = default;
  TargetKind kind = TargetKind::travel;
  Number value;
};

enum class HoldMode { travel, force };

struct Step;
using Steps = std::vector<Step>;

struct ZeroStep {
  bool force = false, travel = false;
  std::optional<Number> max_offset;  // N; a larger offset means that the probe already touches
};
struct FindContactStep {
  Number speed, force, back_off, timeout;  // m/s, N (rise over the baseline), m, s
  std::optional<Number> within;  // m, longest way of the search; absent: as far as the limits allow
  std::optional<Number> overshoot;  // N allowed beyond the rise; plan and run refuse more
  bool slow_down = false;  // `speed` is at most: slower where this rig stops too late
};
// A person says how far the probe is from the specimen: contact is known without a search.
struct SetGapStep {
  Number gap;  // m, at the present travel
};
struct RampStep {
  Target to;
  std::optional<Number> speed;  // m/s
  std::optional<Number> force_rate;  // N/s, for force and pressure targets
  Number timeout;  // s
};
struct MoveUntilStep {
  Target until;
  Number speed;  // m/s
  std::optional<Number> final_speed;  // m/s, two-speed approach ...
  std::optional<Number> final_from;  // ... from this fraction of the target force on (0..1)
  std::optional<Number> overshoot;  // N allowed beyond the target; plan and run refuse more
  Number timeout;  // s
};
struct HoldStep {
  HoldMode mode = HoldMode::travel;
  std::optional<Target> at;  // force or pressure to hold; absent: where it stands
  Number duration;  // s; the mode stays in force until the next motion
};
struct MeasureStep {
  Number count;  // fresh readings
  Number within;  // s
};
struct PlaceWeightStep {
  std::optional<Number> mass;  // kg, or ...
  std::optional<Target> load;  // ... the load that it shall produce
};
struct RecordStep {
  std::optional<Number> duration;  // s
  bool until_confirmed = false;
  Number timeout;  // s, with until_confirmed
};
struct SetLcrStep {
  // Only what is given changes.
  std::optional<Number> frequency, level, bias, average;  // Hz, V, V, 1
  bool bias_off = false;
  std::optional<Aperture> aperture;
  std::optional<LcrFunction> function;
  std::optional<LcrTrigger> trigger;
};
struct RepeatStep {
  Number count;
  Steps steps;
};
struct SweepStep {
  std::string name;  // variable; its unit suffix says what the values are
  std::vector<Number> values;  // or from/to/count, expanded by the parser when they are literals
  std::optional<Number> from, to, count;
  Steps steps;
};
struct MarkStep {
  std::string text;
};

using Action = std::variant<ZeroStep, FindContactStep, RampStep, MoveUntilStep, HoldStep,
                            MeasureStep, PlaceWeightStep, RecordStep, SetLcrStep, RepeatStep,
                            SweepStep, MarkStep, SetGapStep>;

struct Step {
  std::string id;  // unique in the file
  std::string pointer;  // JSON pointer, for messages
  Action action;
};

// The word after "do": "find_contact".
std::string_view kind_of(const Step& step);

struct Parameter {
  double default_value = 0, min = 0, max = 0;  // in the unit of the name's suffix
  double to_si = 1;  // factor of that suffix
  bool integer = false;
  std::string description;
};

// A window that no sample may leave while the run lives.
struct Limits {
  // N; absent (only where nothing is commanded): the range of the load cell
  std::optional<Number> force_min, force_max;
  std::optional<Number> travel_min, travel_max;  // m, of the machine
  std::optional<Number> gap_min, gap_max;  // m, from contact on; both windows hold
  std::optional<Number> speed_max;  // m/s
};

struct Sampling {
  LcrSettings lcr;
  bool aperture_auto = false;  // "auto": the plan chooses and says why; lcr.aperture is not meant
  bool lcr_continuous = true;  // record between `measure` steps too
  double frame_rate_Hz = 50;
};

enum class OnLoss { abort, wait, repeat_step };

struct Protocol {
  std::string name, title, description;
  std::string text;  // the file as it was
  std::map<std::string, Parameter> parameters;
  Limits limits;
  Sampling sample;
  OnLoss on_loss = OnLoss::abort;
  Duration on_loss_timeout = std::chrono::minutes(10);  // longest absence of an instrument
  Duration finally_timeout = std::chrono::minutes(5);
  Steps steps, finally_steps;
};

// Values of parameters and sweep variables, SI.
class Environment {
 public:
  void set(const std::string& name, double si) { values_[name] = si; }
  void unset(const std::string& name) { values_.erase(name); }
  double get(const Number& n) const { return n.name.empty() ? n.value : values_.at(n.name); }
  const std::map<std::string, double>& values() const { return values_; }

 private:
  std::map<std::string, double> values_;
};

}  // namespace lcrig
