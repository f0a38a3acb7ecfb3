// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
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

// The end of the loop over variable `n` that reaches furthest, because it meets a limit first.
// nullptr: `n` is not the variable of a loop.
const Number* end_of_loop(const Steps& steps, const Number& n, Rounding to,
                          const Environment& environment) {
  for (const Step& step : steps) {
    const StepFacts facts = facts_of(step);
    if (!facts.loop || !n.pointer.starts_with(step.pointer + "/")) continue;
    if (const Number* found = end_of_loop(facts.loop->steps, n, to, environment)) return found;
    const std::string* variable = facts.loop->variable();
    if (variable == nullptr || *variable != n.name) continue;
    const auto is_nearer = [&](const Number* a, const Number* b) {
      const double one = environment.get(*a), other = environment.get(*b);
      return to == Rounding::down ? one < other : one > other;
    };
    const std::vector<const Number*> ends = facts.loop->ends();
    return ends.empty() ? nullptr : *std::ranges::max_element(ends, is_nearer);
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
    const Number* end = end_of_loop(asked.protocol.steps, n, to, asked.environment);
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
