// SPDX-License-Identifier: Apache-2.0
// Parses the step list of a protocol file: ids, kinds, loops. The keys of each kind of step are
// read in protocols/steps. Used by parse.cpp.
#pragma once

#include <set>
#include <string>

#include "protocols/file/step_reader.hpp"
#include "protocols/steps/step.hpp"

namespace lcrig {

inline constexpr int kLoopDepthMax = 8;

// A protocol's name, or the id of a step.
std::string read_name(const JsonReader& name);

class StepsParser {
 public:
  explicit StepsParser(Scope scope) : scope_(std::move(scope)) {}
  // One parser reads both `steps` and `finally`, because ids are unique in the file.
  Steps parse(const JsonReader& array, std::size_t min_steps);
  // Parses the steps inside a loop.
  Steps inner_steps(const JsonReader& loop);

 private:
  Step parse_step(const JsonReader& step);
  std::string parse_id(const JsonReader& step);

  Scope scope_;
  std::set<std::string> ids_;
  int depth_ = 0;
};

}  // namespace lcrig
