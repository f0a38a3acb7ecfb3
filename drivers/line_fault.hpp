// SPDX-License-Identifier: Apache-2.0
// What can happen to bytes on their way from a simulated instrument.
#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "base/clock.hpp"

namespace lcrig {

struct LineFault {
  enum class Kind { none, delay, drop, cut, twice, garble, echo };
  explicit LineFault(Kind k = Kind::none, Duration d = {}) : kind(k), delay(d) {}
  Kind kind;
  Duration delay;  // with any kind: so much later
};

// `drop`, `cut`, `twice`, `garble` done to one transmission; the others leave it as it is. Garbled:
// every third character becomes another one, digits become letters.
std::string spoiled(std::string bytes, LineFault::Kind kind);

// Hits each byte with a probability. What is hit arrives with its top bit set, as after a framing
// error. A bit that makes a digit of a digit is not simulated: no program could see it on a line
// without check sums (docs/faults.md).
class LineNoise {
 public:
  explicit LineNoise(std::uint64_t seed) : random_(seed) {}
  void spoil(std::string& bytes, double byte_probability);

 private:
  std::mt19937_64 random_;
};

}  // namespace lcrig
