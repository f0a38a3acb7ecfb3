// SPDX-License-Identifier: Apache-2.0
// The walk behind make_plan: the state that each step meets, its duration, and the first refusal.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "protocols/plan/plan.hpp"
#include "protocols/plan/rig_forecast.hpp"

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
  Planner(const Protocol& protocol, Environment environment, const Rig& rig,
          const BoundLimits& limits, const ApertureChoice& choice);
  void walk();
  const std::optional<PlanRefused>& refused() const { return refused_; }
  Plan take() { return std::move(plan_); }

 private:
  static constexpr double kSearchStop_s = 4;  // to measure the stiffness at contact, standing

  // What one step adds; `why` refuses it.
  struct Outcome {
    double seconds = 0;
    std::string note;
    MaybeRefusal why;
    void refuse(Refusal refusal) {
      if (!why) why = std::move(refusal);
    }
  };
  // Whether it is known where the specimen is.
  enum class Contact { unknown, stated, found };

  void check_start();
  void check_limits();
  void check_channels();
  bool walk_steps(const Steps& steps, bool in_finally);
  void account(const Step& step, const Outcome& outcome, bool in_finally);
  void refuse(const std::string& pointer, const std::string& id, Refusal refusal);
  void assume(const std::string& text);
  Outcome visit(const Step& step);
  void finish_figures();
  void foresee_lies();

  Outcome on(const ZeroStep& s);
  Outcome on(const FindContactStep& s);
  Outcome on(const RampStep& s);
  Outcome on(const MoveUntilStep& s);
  Outcome on(const HoldStep& s);
  Outcome on(const MeasureStep& s);
  Outcome on(const PlaceWeightStep& s);
  Outcome on(const RecordStep& s);
  Outcome on(const SetLcrStep& s);
  Outcome on(const SetGapStep& s);
  Outcome on(const RepeatStep&) { return {}; }  // the cursor yields leaves only
  Outcome on(const SweepStep&) { return {}; }
  Outcome on(const MarkStep&) { return {}; }

  // planner_motion.cpp, planner_contact.cpp, planner_loop.cpp: position and force after a motion,
  // checked against limits and forecast.
  void go_to_travel(double travel, const Target* to, Outcome& out);
  void go_to_force(double force, const Number* given, Outcome& out);
  void use_speed(const Number& speed, Outcome& out);
  void travel_move(const Target& to, const Number& speed, Outcome& out);
  void force_move(const Target& to, const Number& speed, Outcome& out);
  void check_stop(double felt, const Number& speed, const std::optional<Number>& allowed,
                  const Number& timeout, Outcome& out);
  void check_expected(double force, const Number& speed, const std::optional<Number>& allowed,
                      const Number& timeout, Outcome& out);
  void check_pressing(double depth, double expected_N, const Number& speed, Outcome& out);
  void check_blind(const Number& speed, Outcome& out);
  void check_ramp(double force, const Target& to, const Number& rate, Outcome& out);
  void check_loop(double force, Outcome& out);
  void check_timeout(const Number& timeout, Outcome& out);
  Refusal too_fast(const std::string& why, const Number& speed, double fastest,
                   const Number* timeout);
  double slowed_down(const FindContactStep& s);
  void check_threshold(const FindContactStep& s, Outcome& out);
  void foresee(double worst_N, double speed);
  bool can_be_measured() const { return contact_state_ == Contact::found; }
  double travel_at(double force) const;
  double force_at(double travel) const;
  double window_end(double travel) const;

  const Protocol& protocol_;
  Environment env_;
  Rig rig_;  // its travel moves with the zero
  BoundLimits limits_;
  Forecast forecast_;
  Plan plan_;
  LcrSettings lcr_;
  std::optional<PlanRefused> refused_;
  std::map<std::string, std::size_t> row_of_;  // step id -> index in plan_.steps
  std::map<std::pair<double, double>, double> stops_;  // of (force, speed), reckoned already
  double way_ = 0;  // of the motion that is looked at, m
  double contact_ = 0;  // machine travel of first contact, m: an estimate until it is placed
  double travel_ = 0;  // present, m
  double force_ = 0;  // present, N
  double below_N_ = 0;  // what the unloaded cell shows below zero: the specimen feels so much more
  double fastest_m_s_ = 0, pressed_m_s_ = 0;  // of all motions; of those that may press
  double contact_N_ = 0;  // the largest force that gap zero may be pressed with
  Contact contact_state_ = Contact::unknown;
  bool placed_ = false;  // travel of the machine and place of contact are known together
  bool moved_ = false;
  std::int64_t visits_ = 0;
};

}  // namespace lcrig
