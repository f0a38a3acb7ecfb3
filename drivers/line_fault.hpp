// SPDX-License-Identifier: Apache-2.0
// Faults of the bytes on their way from a simulated instrument. Used by the simulators and by the
// FaultPlayer.
#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "base/time.hpp"

namespace lcrig {

struct LineFault {
  enum class Kind { none, delay, drop, cut, twice, garble, echo };
  explicit LineFault(Kind k = Kind::none, Duration d = {}) : kind(k), delay(d) {}
  Kind kind;
  Duration delay;  // applies to every kind
};

// Applies `drop`, `cut`, `twice` or `garble` to one transmission; other kinds leave it unchanged.
// Garbling replaces every third character and turns digits into letters.
std::string spoiled(std::string bytes, LineFault::Kind kind);

// Spoils each byte with a probability. A spoiled byte arrives with its top bit set, as after a
// framing error. Errors that turn one digit into another are not simulated, because no program
// could notice them on a line without checksums (docs/faults.md).
class LineNoise {
 public:
  explicit LineNoise(std::uint64_t seed) : random_(seed) {}
  void spoil(std::string& bytes, double byte_probability);

 private:
  std::mt19937_64 random_;
};

}  // namespace lcrig
