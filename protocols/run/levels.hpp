// SPDX-License-Identifier: Apache-2.0
// Labels the load levels of a run: the number of each `measure` step, and its target force. Load
// steps set the target, `measure` takes the next level.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/time.hpp"
#include "protocols/protocol.hpp"
#include "protocols/run/point.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class LevelLabels {
 public:
  // `environment` must outlive it.
  LevelLabels(const Environment& environment, const PressureArea& pressure, double gravity_m_s2)
      : environment_(environment), pressure_(pressure), gravity_m_s2_(gravity_m_s2) {}

  double force_of(const Target& target) const;  // N, for a target that is a force or a pressure
  // Sets the force of the following levels to the target of this step, or to none after a motion to
  // a place. Other steps change nothing.
  void aim(const StepFacts& facts);
  std::int64_t repeat() const { return repeat_; }  // pass of the outermost loop, from 1; 0: none
  void enter_repeat(std::int64_t repeat) { repeat_ = repeat; }
  LoadLevel next(std::string step_id, std::int64_t readings, MonoTime begin);
  // Lets the last level be measured again: it keeps its index in the repeat, under a new number.
  void abandon() { --in_repeat_; }

  // Store and restore the counts, so that a continued run counts on.
  void write_to(RunPoint& point) const;
  void take_from(const RunPoint& point);

 private:
  const Environment& environment_;
  PressureArea pressure_;
  double gravity_m_s2_;
  std::optional<double> target_force_N_, target_pressure_Pa_;
  std::int64_t levels_ = 0;
  std::int64_t in_repeat_ = 0, of_repeat_ = -1;  // levels so far in this repeat, and its number
  std::int64_t repeat_ = 0;
};

}  // namespace lcrig
