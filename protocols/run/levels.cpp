// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/levels.hpp"

#include <utility>

namespace lcrig {

double LevelLabels::force_of(const Target& target) const {
  // The plan has refused a pressure without an area.
  const double area_m2 = target.kind == TargetKind::pressure ? pressure_.area_m2().value() : 0;
  return target_force_N(target, environment_, LoadFactors(area_m2, gravity_m_s2_));
}

void LevelLabels::aim(const StepFacts& facts) {
  if (facts.aim == nullptr && !facts.moves) return;
  target_force_N_.reset();
  target_pressure_Pa_.reset();
  if (facts.aim == nullptr || !is_force(*facts.aim)) return;
  target_force_N_ = force_of(*facts.aim);
  // A stored pressure is over the probe, whatever the protocol states (docs/database.md).
  const auto probe_m2 = pressure_.probe_area_m2();
  if (probe_m2) target_pressure_Pa_ = *target_force_N_ / *probe_m2;
}

LoadLevel LevelLabels::next(std::string step_id, std::int64_t readings, MonoTime begin) {
  in_repeat_ = repeat_ == of_repeat_ ? in_repeat_ + 1 : 1;
  of_repeat_ = repeat_;
  LoadLevel level;
  level.level = ++levels_;
  level.step_id = std::move(step_id);
  level.repeat = repeat_;
  level.index = in_repeat_;
  level.target_force_N = target_force_N_;
  level.target_pressure_Pa = target_pressure_Pa_;
  level.planned_readings = readings;
  level.begin = begin;
  return level;
}

void LevelLabels::write_to(RunPoint& point) const {
  point.levels = levels_;
  point.level_in_repeat = in_repeat_;
  point.level_repeat = of_repeat_;
}

void LevelLabels::take_from(const RunPoint& point) {
  levels_ = point.levels;
  in_repeat_ = point.level_in_repeat;
  of_repeat_ = point.level_repeat;
}

}  // namespace lcrig
