// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/parse_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "base/text.hpp"
#include "protocols/file/step_kinds.hpp"

namespace lcrig {

namespace {

using Parse = std::shared_ptr<const Action> (*)(const StepReader&);
template <class... Kind>
constexpr auto parsers_of(const std::tuple<Kind...>* /*kinds*/) {
  return std::array{std::pair<std::string_view, Parse>(
      Kind::kWord, [](const StepReader& r) -> std::shared_ptr<const Action> {
        return std::make_shared<Kind>(Kind::parse(r));
      })...};
}
constexpr auto kStepKinds = parsers_of(static_cast<const StepKinds*>(nullptr));

struct TargetRow {
  TargetKind kind;
  std::string_view stem;
  Dimension dimension;
  Range range;
};
// Reads "safe_point". A loop cannot be one, because each of its passes has an end of its own.
void read_safe_point(const JsonReader& r, Step& step) {
  const auto given = r.find("safe_point");
  if (!given) return;
  step.safe_point = given->boolean();
  if (facts_of(step).loop) {
    given->refuse("a safe point behind a loop, expected one at a step inside it, or behind it");
  }
}

constexpr Range kLengths{-10, 10};  // m
constexpr TargetRow kTargets[] = {
    {TargetKind::travel, "travel", Dimension::length, kLengths},
    {TargetKind::gap, "gap", Dimension::length, kLengths},
    {TargetKind::force, "force", Dimension::force, kForces},
    {TargetKind::pressure, "pressure", Dimension::pressure, kPressures},
};

}  // namespace

Target StepReader::target(std::string_view key) const {
  const JsonReader object = json.object(key);
  Target out;
  int found = 0;
  for (const TargetRow& row : kTargets) {
    const auto n = scope.optional(object, row.stem, row.dimension, row.range);
    if (!n) continue;
    ++found;
    out.kind = row.kind;
    out.value = *n;
  }
  object.no_other_keys();
  if (found != 1) {
    object.refuse(
        fmt::format("{} targets, expected exactly one of travel_mm, gap_mm, force_N, "
                    "pressure_kPa (or another unit)",
                    found));
  }
  return out;
}

std::optional<Target> StepReader::load(const Range& forces, int& given) const {
  std::optional<Target> out;
  const auto add = [&](TargetKind kind, const std::optional<Number>& value) {
    if (!value) return;
    ++given;
    out.emplace();
    out->kind = kind;
    out->value = *value;
  };
  add(TargetKind::force, optional("force", Dimension::force, forces));
  add(TargetKind::pressure, optional("pressure", Dimension::pressure, kPressures));
  return out;
}

Steps StepReader::steps() const {
  return file.inner_steps(json);
}

Steps StepsParser::parse(const JsonReader& array, std::size_t min_steps) {
  Steps out;
  for (const JsonReader& step : array.items(min_steps, 1000)) {
    out.push_back(parse_step(step));
  }
  return out;
}

Step StepsParser::parse_step(const JsonReader& r) {
  Step step;
  step.id = parse_id(r);
  step.pointer = r.pointer();
  const JsonReader kind = r.at("do");
  const auto make = kind.word<Parse>(kStepKinds);
  if (!kind.sound()) return step;  // the keys of an unknown kind are unknown, too
  step.action = make(StepReader(r, scope_, *this));
  read_safe_point(r, step);
  r.no_other_keys();
  return step;
}

std::string read_name(const JsonReader& name) {
  std::string text = name.nonempty_string(64);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (!std::ranges::all_of(text, good)) {
    name.refuse(fmt::format("\"{}\", expected letters, digits, _ and - only", printable(text)));
  }
  return text;
}

std::string StepsParser::parse_id(const JsonReader& r) {
  const JsonReader id = r.at("id");
  std::string text = read_name(id);
  if (!ids_.insert(text).second) {
    id.refuse(
        fmt::format("\"{}\" for the second time, expected an id that is unique in the file", text));
  }
  return text;
}

Steps StepsParser::inner_steps(const JsonReader& r) {
  if (++depth_ > kLoopDepthMax) {
    r.refuse(fmt::format("more than {} loops inside each other", kLoopDepthMax));
    --depth_;
    return {};
  }
  Steps steps = parse(r.at("steps"), 1);
  --depth_;
  return steps;
}

}  // namespace lcrig
