// SPDX-License-Identifier: Apache-2.0
// The walk behind make_plan: the state that each step meets, its duration, and the first refusal.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "protocols/plan.hpp"

namespace lcrig {

struct ApertureChoice {
  Aperture aperture = Aperture::medium;
  std::string note;
};
// The file's aperture, or for "auto" the slowest one that every `measure` and the loaded part of a
// continuous recording allow.
ApertureChoice choose_aperture(const Protocol& protocol, const Environment& environment,
                               const Rig& rig);

// Seconds that a move to `force_N` at `speed` spends between contact and target; nullopt without an
// estimate of the compression.
std::optional<double> loaded_time_s(double force_N, double speed_m_s, const Rig& rig);

class Planner {
 public:
  struct Refused {
    std::string pointer, id, why;
  };

  Planner(const Protocol& protocol, Environment environment, const Rig& rig,
          const BoundLimits& limits, const ApertureChoice& choice);
  void walk();
  const std::optional<Refused>& refused() const { return refused_; }
  Plan take() { return std::move(plan_); }

 private:
  // What one step adds; `why` refuses it.
  struct Outcome {
    double seconds = 0;
    std::string note;
    Refusal why;
  };

  void check_start();
  bool walk_steps(const Steps& steps, bool in_finally);
  void account(const Step& step, const Outcome& outcome, bool in_finally);
  void refuse(const std::string& pointer, const std::string& id, std::string why);
  void assume(const std::string& text);
  Outcome visit(const Step& step);

  Outcome on(const ZeroStep& s);
  Outcome on(const FindContactStep& s);
  Outcome on(const RampStep& s);
  Outcome on(const MoveUntilStep& s);
  Outcome on(const HoldStep& s);
  Outcome on(const MeasureStep& s);
  Outcome on(const PlaceWeightStep& s);
  Outcome on(const RecordStep& s);
  Outcome on(const SetLcrStep& s);
  Outcome on(const RepeatStep&) { return {}; }  // the cursor yields leaves only
  Outcome on(const SweepStep&) { return {}; }
  Outcome on(const MarkStep&) { return {}; }

  // Position and force after a motion; checked against travel and force limits.
  void go_to_travel(double travel, Outcome& out);
  void go_to_force(double force, Outcome& out);
  void check_overshoot(double force, double speed, std::optional<double> allowed, Outcome& out);
  void travel_move(const Target& to, double speed, Outcome& out);
  void force_move(double force, double speed, Outcome& out);
  void check_timeout(const Number& timeout, Outcome& out);
  double travel_at(double force) const;
  double force_at(double travel) const;
  double stiffness_at(double force) const;

  const Protocol& protocol_;
  Environment env_;
  const Rig& rig_;
  BoundLimits limits_;
  Plan plan_;
  LcrSettings lcr_;
  std::optional<Refused> refused_;
  std::map<std::string, std::size_t> row_of_;  // step id -> index in plan_.steps
  double contact_ = 0;  // machine travel of first contact, m
  double travel_ = 0;  // present, m
  double force_ = 0;  // present, N
  bool gap_known_ = false;
  bool moved_ = false;
  std::int64_t visits_ = 0;
};

}  // namespace lcrig
