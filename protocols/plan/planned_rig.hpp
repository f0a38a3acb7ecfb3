// SPDX-License-Identifier: Apache-2.0
// The rig as a plan sees it while it walks through a protocol: where it stands, the force, what is
// known about the specimen, the settings of the meter. Each step finds it as the previous steps
// left it. protocols/steps changes it; the planner reads the sums.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "protocols/plan/advice.hpp"
#include "protocols/plan/plan.hpp"
#include "protocols/plan/rig_forecast.hpp"

namespace lcrig {

// What one step adds to a plan.
struct StepPlan {
  StepPlan() = default;
  explicit StepPlan(double s) : seconds(s) {}
  double seconds = 0;
  double way_m = 0;  // of its motion
  bool by_hand = false;  // a person is needed
  std::string note;  // what was chosen or assumed, and why
  MaybeRefusal why;  // reason of a refusal; the first one counts

  void refuse(Refusal refusal) {
    if (!why) why = std::move(refusal);
  }
};

class PlannedRig {
 public:
  static constexpr double kAssumedGap_m = 3e-3;  // assumed where nobody stated the distance of the
                                                 // specimen
  // Time that a person is assumed to need for placing a mass and confirming, or for finding an
  // answer.
  static constexpr double kByHand_s = 15;
  enum class Contact { unknown, stated, found };  // how the place of contact is known

  // `protocol`, `environment` and `plan` must outlive it. The largest forces and the range of
  // travel are stored in the plan.
  PlannedRig(const Protocol& protocol, const Environment& environment, const Rig& rig,
             const BoundLimits& limits, Plan& plan);

  const Protocol& protocol() const { return protocol_; }
  const Environment& environment() const { return environment_; }
  Asked asked() const { return {protocol_, environment_}; }
  double get(const Number& number) const { return environment_.get(number); }
  // Facts from outside the file. Its travels count from the present zero.
  const Rig& known() const { return rig_; }
  const FrameCapabilities& frame() const { return rig_.frame; }
  const BoundLimits& limits() const { return limits_; }
  const Forecast& forecast() const { return forecast_; }
  // The largest force at which a motion may end.
  double largest_end_N() const;
  // The same for a value that a refusal proposes. The noise is measured anew before the next plan,
  // which must accept it.
  double proposed_end_N() const;
  std::string limit_text() const;  // "the limit is 1.5 N", and what the noise takes of it
  double force_of(const Target& t) const { return target_force_N(t, environment_, rig_); }

  const LcrSettings& meter() const { return lcr_; }
  double travel_m() const { return travel_; }
  double force_N() const { return force_; }  // as shown by the cell
  // The force on the specimen when the cell shows `force_N`.
  double felt_N(double force_N) const { return force_N + below_N_; }
  double contact_m() const { return contact_; }  // an estimate until is_placed()
  double contact_N() const { return contact_N_; }
  Contact contact() const { return contact_state_; }
  bool can_be_measured() const { return contact_state_ == Contact::found; }
  bool is_placed() const { return placed_; }
  bool has_moved() const { return motions_ > 0; }
  std::int64_t motions() const { return motions_; }  // so far
  double fastest_m_s() const { return fastest_m_s_; }
  double pressed_m_s() const { return pressed_m_s_; }
  // Computed with the model of the specimen.
  double travel_at(double force_N) const;
  double force_at(double travel_m) const;

  // Effects of steps that do not move.
  void zero_force() { force_ = below_N_ = 0; }
  void zero_travel();
  void state_gap(double gap_m);
  void set_meter(LcrSettings settings);
  void add_level(std::int64_t readings, double within_s);

  // Sets the end of a motion or of a placed load; refuses it if the limits do not allow it. `to`
  // and `given` are the file's values, for advice.
  void go_to_travel(double travel_m, const Target* to, StepPlan& out);
  void go_to_force(double force_N, const Number* given, StepPlan& out);
  void use_speed(const Number& speed, StepPlan& out);
  // Stores the largest force that the specimen may feel, and the speed at which it may be pressed.
  void foresee(double worst_N, double speed_m_s);
  double stop_N(double felt_N, double speed_m_s);  // Forecast::stop_N, stored because it is slow
  void expect_overshoot(double N) { plan_.overshoot_N = std::max(plan_.overshoot_N, N); }
  void assume(const std::string& text);

  void begin_search() { contact_state_ = Contact::unknown; }  // until the search has measured it
  void find_contact(double rise_N, double speed_m_s);
  void unload() { force_ = 0; }

 private:
  void note_recording();

  const Protocol& protocol_;
  const Environment& environment_;
  Rig rig_;  // its travels are shifted to each new zero
  BoundLimits limits_;
  Forecast forecast_;
  Plan& plan_;
  LcrSettings lcr_;
  std::map<std::pair<double, double>, double> stops_;  // results of stop_N by force and speed
  double contact_ = 0;  // machine travel of first contact, m; an estimate until placed_
  double contact_N_ = 0;  // the largest force that may press at gap zero
  double travel_ = 0;  // present, m
  double force_ = 0;  // present, N
  double below_N_ = 0;  // how far below zero the unloaded cell shows
  double fastest_m_s_ = 0, pressed_m_s_ = 0;  // of all motions; of those that may press
  Contact contact_state_ = Contact::unknown;
  bool placed_ = false;  // machine travel and place of contact have a common zero
  std::int64_t motions_ = 0;
};

}  // namespace lcrig
