// SPDX-License-Identifier: Apache-2.0
// The change that makes a refused protocol acceptable: a place in the file, and the value to write
// there. Plan and steps attach it to a refusal; `lcrig` prints it.
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

// Why a plan is refused. Without a change, `why` itself says what to do, or that no change of the
// protocol can help.
struct Refusal {
  Refusal() = default;
  explicit Refusal(std::string w) : why(std::move(w)) {}
  Refusal(std::string w, std::vector<Change> c) : why(std::move(w)), changes(std::move(c)) {}
  std::string why;
  std::vector<Change> changes;  // to be made together
  std::string text() const;  // reason and changes in words
};
using MaybeRefusal = std::optional<Refusal>;

// A protocol with the values of its names in this plan.
struct Asked {
  const Protocol& protocol;
  const Environment& environment;
};
// The change that brings `number` to at most, or at least, `si`, rounded to three digits towards
// the allowed values. For the variable of a sweep it changes the end that reaches furthest. Empty
// when the value is out of the parameter's range, or when `number` is not in the file.
std::vector<Change> at_most(const Number& number, double si, const Asked& asked);
std::vector<Change> at_least(const Number& number, double si, const Asked& asked);

}  // namespace lcrig
