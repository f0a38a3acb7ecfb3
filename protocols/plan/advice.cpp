// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/advice.hpp"

#include <fmt/format.h>

#include <cmath>

#include "protocols/steps/step.hpp"

namespace lcrig {

namespace {

enum class Rounding { down, up };

double rounded(double value, Rounding to, bool whole) {
  if (value == 0) return 0;
  const double digits = whole ? 0 : 2 - std::floor(std::log10(std::abs(value)));
  const double scale = std::pow(10.0, std::abs(digits));
  const double scaled = digits < 0 ? value / scale : value * scale;
  // A value that is round already, except for its last bits, stays.
  const double nearest = std::round(scaled);
  const bool exact = std::abs(scaled - nearest) < 1e-9 * std::abs(scaled);
  const double cut = exact                  ? nearest
                     : to == Rounding::down ? std::floor(scaled)
                                            : std::ceil(scaled);
  return digits < 0 ? cut * scale : cut / scale;
}

// The end of the sweep of variable `n` that reaches furthest, because it meets a limit first.
// nullptr: `n` is not the variable of a sweep.
const Number* end_of_sweep(const Steps& steps, const Number& n, Rounding to,
                           const Environment& environment) {
  for (const Step& step : steps) {
    const StepFacts facts = facts_of(step);
    if (!facts.loop || !n.pointer.starts_with(step.pointer + "/")) continue;
    if (const Number* found = end_of_sweep(facts.loop->steps(), n, to, environment)) return found;
    const SweepStep* sweep = facts.loop->sweep();
    if (sweep == nullptr || sweep->name != n.name) continue;
    const Number* out = nullptr;
    const auto take = [&](const Number& end) {
      const auto value = [&](const Number& of) { return environment.get(of); };
      const bool further = out == nullptr || (to == Rounding::down ? value(end) > value(*out)
                                                                   : value(end) < value(*out));
      if (further) out = &end;
    };
    for (const Number& value : sweep->values) take(value);
    if (sweep->from) take(*sweep->from);
    if (sweep->to) take(*sweep->to);
    return out;
  }
  return nullptr;
}

std::vector<Change> change_of(const Number& n, double si, Rounding to, const Asked& asked) {
  if (n.name.empty()) {
    if (n.pointer.empty()) return {};  // a computed number, which is not in the file
    const double value = rounded(si / n.to_si, to, false);
    return {Change(n.pointer, value, false)};
  }
  const auto it = asked.protocol.parameters.find(n.name);
  if (it == asked.protocol.parameters.end()) {
    const Number* end = end_of_sweep(asked.protocol.steps, n, to, asked.environment);
    if (end == nullptr) return {};
    return change_of(*end, si, to, asked);
  }
  const Parameter& p = it->second;
  const double value = rounded(si / p.to_si, to, p.integer);
  if (value < p.min || value > p.max) return {};
  return {Change(n.name, value, true)};
}

}  // namespace

std::string to_string(const Change& c) {
  return c.parameter ? fmt::format("-p {}={}", c.place, c.value)
                     : fmt::format("{}: {}", c.place, c.value);
}

std::string Refusal::text() const {
  std::string out = why;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    out += (i == 0 ? " (" : ", ") + to_string(changes[i]);
  }
  return changes.empty() ? out : out + ")";
}

std::vector<Change> at_most(const Number& number, double si, const Asked& asked) {
  return change_of(number, si, Rounding::down, asked);
}

std::vector<Change> at_least(const Number& number, double si, const Asked& asked) {
  return change_of(number, si, Rounding::up, asked);
}

}  // namespace lcrig
