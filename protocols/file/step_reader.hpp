// SPDX-License-Identifier: Apache-2.0
// Reads the keys of one step object of a protocol file, with the names that are known there. Used
// by the kinds of steps in protocols/steps.
#pragma once

#include <optional>
#include <string_view>

#include "base/time.hpp"
#include "protocols/file/scope.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

inline constexpr Range kTimes{0, kLongestTime_s, true};  // s
inline constexpr Range kSpeeds{0, 1, true};  // m/s
inline constexpr Range kForces{-1e6, 1e6};  // N
inline constexpr Range kPositiveForces{0, 1e6, true};
inline constexpr Range kPressures{0, 1e9};  // Pa
inline constexpr std::int64_t kCountMax = 10'000'000;
// Settings in `sample.lcr` and `set_lcr`: ranges that any meter could have. The plan checks the
// limits of the actual instrument.
inline constexpr Range kFrequencyRange{1, 1e8};
inline constexpr Range kLevelRange{0, 20, true};
inline constexpr Range kBiasRange{-100, 100};
inline constexpr std::int64_t kAverageMax = 256;

class StepsParser;

struct StepReader {
  StepReader(const JsonReader& object, Scope& names, StepsParser& parser)
      : json(object), scope(names), file(parser) {}

  Number required(std::string_view stem, Dimension d, const Range& si) const {
    return scope.required(json, stem, d, si);
  }
  std::optional<Number> optional(std::string_view stem, Dimension d, const Range& si) const {
    return scope.optional(json, stem, d, si);
  }
  Number count(std::string_view key, std::int64_t min, std::int64_t max) const {
    return scope.read_count(json.at(key), min, max);
  }
  Number timeout() const { return required("timeout", Dimension::time, kTimes); }
  // Reads the object under `key`, which has exactly one of travel, gap, force and pressure.
  Target target(std::string_view key) const;
  // Reads a force or a pressure among the keys of the step itself; `given` counts how many there
  // are.
  std::optional<Target> load(const Range& forces, int& given) const;
  // Parses the steps inside a loop.
  Steps steps() const;

  const JsonReader& json;
  Scope& scope;
  StepsParser& file;
};

}  // namespace lcrig
