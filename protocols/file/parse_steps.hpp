// SPDX-License-Identifier: Apache-2.0
// The step list of a protocol file: ids, kinds, loops. What a kind of step reads is in
// protocols/steps. Used by parse.cpp.
#pragma once

#include <set>
#include <string>

#include "protocols/file/step_reader.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

inline constexpr int kLoopDepthMax = 8;

class StepsParser {
 public:
  explicit StepsParser(Scope scope) : scope_(std::move(scope)) {}
  // `steps` and `finally` share one parser: ids are unique in the file.
  Steps parse(const JsonReader& array, std::size_t min_steps);
  // The steps inside of a loop.
  Steps inner_steps(const JsonReader& loop);

 private:
  Step parse_step(const JsonReader& step);
  std::string parse_id(const JsonReader& step);

  Scope scope_;
  std::set<std::string> ids_;
  int depth_ = 0;
};

}  // namespace lcrig
