// SPDX-License-Identifier: Apache-2.0
// The step list of a protocol file. Used by parse.cpp only.
#pragma once

#include <set>
#include <string>

#include "protocols/file/scope.hpp"

namespace lcrig {

inline constexpr int kLoopDepthMax = 8;

class StepsParser {
 public:
  explicit StepsParser(Scope scope) : scope_(std::move(scope)) {}
  // `steps` and `finally` share one parser: ids are unique in the file.
  Steps parse(const JsonReader& array, std::size_t min_steps);
  bool has_motion() const { return has_motion_; }

 private:
  Steps parse_list(const JsonReader& array, std::size_t min_steps);
  Step parse_step(const JsonReader& step);
  std::string parse_id(const JsonReader& step);
  Action parse_action(const JsonReader& step);
  Target parse_target(const JsonReader& object, bool forces_only);
  Number timeout(const JsonReader& step) const;

  ZeroStep zero(const JsonReader& r) const;
  FindContactStep find_contact(const JsonReader& r);
  RampStep ramp(const JsonReader& r);
  MoveUntilStep move_until(const JsonReader& r);
  HoldStep hold(const JsonReader& r);
  MeasureStep measure(const JsonReader& r) const;
  PlaceWeightStep place_weight(const JsonReader& r);
  RecordStep record(const JsonReader& r) const;
  SetLcrStep set_lcr(const JsonReader& r) const;
  RepeatStep repeat(const JsonReader& r);
  SweepStep sweep(const JsonReader& r);
  ScopeEntry sweep_values(const JsonReader& r, const KeyParts& key, SweepStep& out) const;
  Steps inner_steps(const JsonReader& r);

  Scope scope_;
  std::set<std::string> ids_;
  int depth_ = 0;
  bool has_motion_ = false;
};

}  // namespace lcrig
