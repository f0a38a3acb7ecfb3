// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/parse_steps.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/text.hpp"
#include "protocols/file/lcr_words.hpp"

namespace lcrig {

namespace {

constexpr Range kTimes{0, 30 * 86400.0, true};  // s
constexpr Range kSpeeds{0, 1, true};  // m/s
constexpr Range kForces{-1e6, 1e6};  // N
constexpr Range kPositiveForces{0, 1e6, true};
constexpr Range kPressures{0, 1e9};  // Pa
constexpr Range kLengths{-10, 10};  // m
constexpr Range kBackOff{0, 1};
constexpr Range kGaps{0, 1};
constexpr Range kWays{0, 10, true};
constexpr Range kMasses{0, 1e5};  // kg
constexpr std::int64_t kCountMax = 10'000'000;
constexpr std::int64_t kSweepValuesMax = 10'000;

enum class Kind {
  zero,
  find_contact,
  ramp,
  move_until,
  hold,
  measure,
  place_weight,
  record,
  set_lcr,
  repeat,
  sweep,
  mark,
  set_gap,
};
constexpr std::array<std::pair<std::string_view, Kind>, 13> kKinds{{
    {"zero", Kind::zero},
    {"find_contact", Kind::find_contact},
    {"ramp", Kind::ramp},
    {"move_until", Kind::move_until},
    {"hold", Kind::hold},
    {"measure", Kind::measure},
    {"place_weight", Kind::place_weight},
    {"record", Kind::record},
    {"set_lcr", Kind::set_lcr},
    {"repeat", Kind::repeat},
    {"sweep", Kind::sweep},
    {"mark", Kind::mark},
    {"set_gap", Kind::set_gap},
}};

struct TargetRow {
  TargetKind kind;
  std::string_view stem;
  Dimension dimension;
  Range range;
  bool is_force;
};
constexpr TargetRow kTargets[] = {
    {TargetKind::travel, "travel", Dimension::length, kLengths, false},
    {TargetKind::gap, "gap", Dimension::length, kLengths, false},
    {TargetKind::force, "force", Dimension::force, kForces, true},
    {TargetKind::pressure, "pressure", Dimension::pressure, kPressures, true},
};

bool is_force(const Target& t) {
  return t.kind == TargetKind::force || t.kind == TargetKind::pressure;
}

}  // namespace

std::string_view kind_of(const Step& step) {
  // The table is in the order of the variant.
  static_assert(std::variant_size_v<Action> == kKinds.size());
  return kKinds[step.action.index()].first;
}

Steps StepsParser::parse(const JsonReader& array, std::size_t min_steps) {
  return parse_list(array, min_steps);
}

Steps StepsParser::parse_list(const JsonReader& array, std::size_t min_steps) {
  Steps out;
  for (const JsonReader& step : array.items(min_steps, 1000)) {
    out.push_back(parse_step(step));
    if (!array.ok()) break;
  }
  return out;
}

Step StepsParser::parse_step(const JsonReader& r) {
  Step step;
  step.id = parse_id(r);
  step.pointer = r.pointer();
  step.action = parse_action(r);
  r.no_other_keys();
  return step;
}

std::string StepsParser::parse_id(const JsonReader& r) {
  const JsonReader id = r.at("id");
  std::string text = id.nonempty_string(64);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (!std::ranges::all_of(text, good)) {
    id.refuse(fmt::format("\"{}\", expected letters, digits, _ and - only", printable(text)));
  }
  if (!ids_.insert(text).second) {
    id.refuse(
        fmt::format("\"{}\" for the second time, expected an id that is unique in the file", text));
  }
  return text;
}

Action StepsParser::parse_action(const JsonReader& r) {
  switch (r.word<Kind>("do", kKinds)) {
    case Kind::zero: return zero(r);
    case Kind::find_contact: return find_contact(r);
    case Kind::ramp: return ramp(r);
    case Kind::move_until: return move_until(r);
    case Kind::hold: return hold(r);
    case Kind::measure: return measure(r);
    case Kind::place_weight: return place_weight(r);
    case Kind::record: return record(r);
    case Kind::set_lcr: return set_lcr(r);
    case Kind::repeat: return repeat(r);
    case Kind::sweep: return sweep(r);
    case Kind::mark: return MarkStep{r.at("text").nonempty_string(1000)};
    case Kind::set_gap: return SetGapStep{scope_.required(r, "gap", Dimension::length, kGaps)};
  }
  return MarkStep{};
}

Target StepsParser::parse_target(const JsonReader& object, bool forces_only) {
  Target out;
  int found = 0;
  for (const TargetRow& row : kTargets) {
    if (forces_only && !row.is_force) continue;
    const auto n = scope_.optional(object, row.stem, row.dimension, row.range);
    if (!n) continue;
    ++found;
    out.kind = row.kind;
    out.value = *n;
  }
  object.no_other_keys();
  if (found != 1) {
    object.refuse(fmt::format("{} targets, expected exactly one of {}", found,
                              forces_only ? "force_N, pressure_kPa (or another unit)"
                                          : "travel_mm, gap_mm, force_N, pressure_kPa (or another "
                                            "unit)"));
  }
  return out;
}

Number StepsParser::timeout(const JsonReader& r) const {
  return scope_.required(r, "timeout", Dimension::time, kTimes);
}

ZeroStep StepsParser::zero(const JsonReader& r) const {
  ZeroStep out;
  out.force = r.optional_boolean("force").value_or(false);
  out.travel = r.optional_boolean("travel").value_or(false);
  out.max_offset = scope_.optional(r, "max_offset", Dimension::force, kPositiveForces);
  if (!out.force && !out.travel) {
    r.refuse("nothing to zero, expected \"force\": true or \"travel\": true or both");
  }
  if (out.max_offset && !out.force) {
    r.refuse("max_offset without \"force\": true, expected both or none");
  }
  return out;
}

FindContactStep StepsParser::find_contact(const JsonReader& r) {
  has_motion_ = true;
  FindContactStep out;
  out.speed = scope_.required(r, "speed", Dimension::speed, kSpeeds);
  out.force = scope_.required(r, "force", Dimension::force, kPositiveForces);
  out.back_off = scope_.required(r, "back_off", Dimension::length, kBackOff);
  out.timeout = timeout(r);
  out.within = scope_.optional(r, "within", Dimension::length, kWays);
  out.overshoot = scope_.optional(r, "overshoot", Dimension::force, kPositiveForces);
  out.slow_down = r.optional_boolean("slow_down").value_or(false);
  return out;
}

RampStep StepsParser::ramp(const JsonReader& r) {
  has_motion_ = true;
  RampStep out;
  out.to = parse_target(r.object("to"), false);
  out.speed = scope_.optional(r, "speed", Dimension::speed, kSpeeds);
  out.force_rate = scope_.optional(r, "force_rate", Dimension::force_rate, kPositive);
  out.timeout = timeout(r);
  if (!is_force(out.to) && !out.speed) {
    r.refuse("no speed, expected speed_mm_s (or another unit) for a ramp to a travel or gap");
  }
  if (!is_force(out.to) && out.force_rate) {
    r.refuse("a force rate, expected a force or pressure to ramp to");
  }
  if (out.speed.has_value() == out.force_rate.has_value()) {
    r.refuse("expected exactly one of speed_mm_s and force_rate_N_s (or another unit)");
  }
  return out;
}

MoveUntilStep StepsParser::move_until(const JsonReader& r) {
  has_motion_ = true;
  MoveUntilStep out;
  out.until = parse_target(r.object("until"), false);
  out.speed = scope_.required(r, "speed", Dimension::speed, kSpeeds);
  out.final_speed = scope_.optional(r, "final_speed", Dimension::speed, kSpeeds);
  if (const auto fraction = r.find("final_from")) {
    out.final_from = scope_.read(*fraction, Dimension::none, 1, Range{0, 1, true});
  }
  out.overshoot = scope_.optional(r, "overshoot", Dimension::force, kPositiveForces);
  out.timeout = timeout(r);
  if (out.final_speed.has_value() != out.final_from.has_value()) {
    r.refuse("one of final_speed and final_from, expected both or none");
  }
  if (!is_force(out.until) && (out.final_speed || out.overshoot)) {
    r.refuse("final_speed or overshoot without a force, expected until force or pressure");
  }
  return out;
}

HoldStep StepsParser::hold(const JsonReader& r) {
  static constexpr std::pair<std::string_view, HoldMode> kModes[] = {{"force", HoldMode::force},
                                                                     {"travel", HoldMode::travel}};
  HoldStep out;
  out.mode = r.word<HoldMode>("hold", kModes);
  out.duration = scope_.required(r, "for", Dimension::time, Range{0, kTimes.max});
  const auto force = scope_.optional(r, "force", Dimension::force, kForces);
  const auto pressure = scope_.optional(r, "pressure", Dimension::pressure, kPressures);
  if (force && pressure) r.refuse("a force and a pressure, expected at most one of them");
  if ((force || pressure) && out.mode == HoldMode::travel) {
    r.refuse("a force beside \"hold\": \"travel\", expected \"hold\": \"force\"");
  }
  if (!force && !pressure) return out;
  out.at.emplace();
  out.at->kind = force ? TargetKind::force : TargetKind::pressure;
  out.at->value = force ? *force : *pressure;
  return out;
}

MeasureStep StepsParser::measure(const JsonReader& r) const {
  MeasureStep out;
  out.count = scope_.read_count(r.at("count"), 1, kCountMax);
  out.within = scope_.required(r, "within", Dimension::time, kTimes);
  return out;
}

PlaceWeightStep StepsParser::place_weight(const JsonReader& r) {
  PlaceWeightStep out;
  out.mass = scope_.optional(r, "mass", Dimension::mass, kMasses);
  const auto force = scope_.optional(r, "force", Dimension::force, Range{0, kForces.max});
  const auto pressure = scope_.optional(r, "pressure", Dimension::pressure, kPressures);
  const int given = (out.mass ? 1 : 0) + (force ? 1 : 0) + (pressure ? 1 : 0);
  if (given != 1) {
    r.refuse(
        fmt::format("{} loads, expected exactly one of mass_g, force_N, pressure_kPa (or "
                    "another unit)",
                    given));
  }
  if (!force && !pressure) return out;
  out.load.emplace();
  out.load->kind = force ? TargetKind::force : TargetKind::pressure;
  out.load->value = force ? *force : *pressure;
  return out;
}

RecordStep StepsParser::record(const JsonReader& r) const {
  RecordStep out;
  out.duration = scope_.optional(r, "for", Dimension::time, kTimes);
  if (const auto until = r.find("until")) {
    static constexpr std::pair<std::string_view, bool> kUntil[] = {{"confirmed", true}};
    out.until_confirmed = until->word<bool>(kUntil);
    out.timeout = timeout(r);
  }
  if (out.duration.has_value() == out.until_confirmed) {
    r.refuse("expected exactly one of for_s (or another unit) and \"until\": \"confirmed\"");
  }
  return out;
}

SetLcrStep StepsParser::set_lcr(const JsonReader& r) const {
  SetLcrStep out;
  out.frequency = scope_.optional(r, "frequency", Dimension::frequency, kFrequencyRange);
  out.level = scope_.optional(r, "level", Dimension::voltage, kLevelRange);
  out.bias = scope_.optional(r, "bias", Dimension::voltage, kBiasRange);
  if (const auto off = r.find("bias")) {
    static constexpr std::pair<std::string_view, bool> kOff[] = {{"off", true}};
    out.bias_off = off->word<bool>(kOff);
  }
  if (out.bias && out.bias_off) r.refuse("a bias voltage and \"off\", expected one of them");
  if (const auto n = r.find("average")) out.average = scope_.read_count(*n, 1, kAverageMax);
  if (r.has("aperture")) out.aperture = r.word<Aperture>("aperture", kApertureWords);
  if (r.has("function")) out.function = r.word<LcrFunction>("function", kFunctionWords);
  if (r.has("trigger")) out.trigger = r.word<LcrTrigger>("trigger", kTriggerWords);
  if (r.keys().size() < 3) r.refuse("no setting, expected at least one to change");
  return out;
}

Steps StepsParser::inner_steps(const JsonReader& r) {
  if (++depth_ > kLoopDepthMax) {
    r.refuse(fmt::format("more than {} loops inside each other", kLoopDepthMax));
    --depth_;
    return {};
  }
  Steps steps = parse_list(r.at("steps"), 1);
  --depth_;
  return steps;
}

RepeatStep StepsParser::repeat(const JsonReader& r) {
  RepeatStep out;
  out.count = scope_.read_count(r.at("count"), 1, kCountMax);
  out.steps = inner_steps(r);
  return out;
}

// Fills `values`, or `from`, `to` and `count` when one of them is a reference.
ScopeEntry StepsParser::sweep_values(const JsonReader& r, const KeyParts& key,
                                     SweepStep& out) const {
  ScopeEntry entry;
  entry.dimension = key.dimension();
  const auto read = [&](const JsonReader& v) {
    return scope_.read(v, key.dimension(), key.to_si(), kAnyNumber);
  };
  if (const auto values = r.find("values")) {
    for (const JsonReader& v : values->items(1, kSweepValuesMax)) out.values.push_back(read(v));
    if (r.has("from") || r.has("to") || r.has("count")) {
      r.refuse("values and from/to/count, expected only one way to give them");
    }
  } else {
    out.from = read(r.at("from"));
    out.to = read(r.at("to"));
    out.count = scope_.read_count(r.at("count"), 2, kSweepValuesMax);
  }
  std::vector<Number> all = out.values;
  if (out.from) all.insert(all.end(), {*out.from, *out.to});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ScopeEntry b = scope_.bounds(all[i], key.dimension());
    entry.min = i == 0 ? b.min : std::min(entry.min, b.min);
    entry.max = i == 0 ? b.max : std::max(entry.max, b.max);
  }
  return entry;
}

SweepStep StepsParser::sweep(const JsonReader& r) {
  SweepStep out;
  const JsonReader name = r.at("name");
  out.name = name.nonempty_string(64);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (!std::ranges::all_of(out.name, good)) {
    name.refuse(fmt::format("\"{}\", expected letters, digits and _ only", printable(out.name)));
  }
  if (scope_.has(out.name)) {
    name.refuse(
        fmt::format("\"{}\" is already a parameter or the variable of a sweep around this "
                    "one, expected a new name",
                    out.name));
  }
  const KeyParts key = split_key(out.name);
  ScopeEntry entry = sweep_values(r, key, out);
  const auto whole = [](const Number& n) {
    return n.name.empty() && n.value == std::floor(n.value);
  };
  entry.integer = !key.unit && !out.values.empty() && std::ranges::all_of(out.values, whole);
  if (!r.ok()) return out;
  scope_.add(out.name, entry);
  out.steps = inner_steps(r);
  scope_.remove(out.name);
  return out;
}

}  // namespace lcrig
