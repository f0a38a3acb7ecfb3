// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/levels.hpp"

#include <utility>

namespace lcrig {

double LevelLabels::force_of(const Target& target) const {
  const double value = environment_.get(target.value);
  // The plan refused a pressure without a probe area.
  return target.kind == TargetKind::pressure ? value * probe_area_m2_.value() : value;
}

void LevelLabels::aim_at(const std::optional<Target>& target) {
  target_force_N_.reset();
  target_pressure_Pa_.reset();
  const bool is_load =
      target && (target->kind == TargetKind::force || target->kind == TargetKind::pressure);
  if (is_load) aim_at_force(force_of(*target));
}

void LevelLabels::aim_at_force(double force_N) {
  target_force_N_ = force_N;
  if (probe_area_m2_) target_pressure_Pa_ = force_N / *probe_area_m2_;
}

double LevelLabels::aim_at_mass(const PlaceWeightStep& step) {
  aim_at(step.load);
  if (step.load.kind != TargetKind::mass) return *target_force_N_ / gravity_m_s2_;
  const double mass_kg = environment_.get(step.load.value);
  aim_at_force(mass_kg * gravity_m_s2_);
  return mass_kg;
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
