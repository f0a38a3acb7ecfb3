// SPDX-License-Identifier: Apache-2.0
// The change that makes a refused protocol acceptable: a place, and the value to write there. Plan
// and steps give it with a refusal; `lcrig` prints it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "protocols/protocol.hpp"

namespace lcrig {

struct Change {
  Change() = default;
  Change(std::string p, double v, bool is_parameter)
      : place(std::move(p)), value(v), parameter(is_parameter) {}
  std::string place;  // JSON pointer of a literal, or the name of a parameter
  double value = 0;  // in the unit of that place
  bool parameter = false;
};
// "/steps/2/speed_mm_s: 0.0159", "-p speed_mm_s=0.0159"
std::string to_string(const Change& change);

// Why a plan is refused. Without a change, `why` says in words what to do, or that no change of the
// protocol can help.
struct Refusal {
  Refusal() = default;
  explicit Refusal(std::string w) : why(std::move(w)) {}
  Refusal(std::string w, std::vector<Change> c) : why(std::move(w)), changes(std::move(c)) {}
  std::string why;
  std::vector<Change> changes;  // all of them together
  std::string text() const;  // why, and what to change
};
using MaybeRefusal = std::optional<Refusal>;

// A protocol with the values that its names have in this plan.
struct Asked {
  const Protocol& protocol;
  const Environment& environment;
};
// The change that makes `number` at most, or at least, `si`: rounded to three digits, towards the
// values that are good. For a sweep's variable it changes the end that goes furthest. None when the
// value is out of the parameter's range, or when `number` stands nowhere in the file.
std::vector<Change> at_most(const Number& number, double si, const Asked& asked);
std::vector<Change> at_least(const Number& number, double si, const Asked& asked);

}  // namespace lcrig
