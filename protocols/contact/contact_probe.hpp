// SPDX-License-Identifier: Apache-2.0
// Finds out whether a search has touched a specimen, and how stiff the contact is. It measures on
// the first micrometres of the way back, because these cannot press harder. Used by the search.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

struct RunParts;

class ContactProbe {
 public:
  // `before`: the cell without contact. A force of `rise_N` above it counts as contact.
  ContactProbe(RunParts& run, const RestMeasurement& before, double rise_N)
      : run_(run), before_(before), rise_N_(rise_N) {}

  // Measures where it touches and then steps back, each time twice as far, as long as some of the
  // force is left. The longest way in contact gives the best slope.
  Task<Result<>> step_back(double touched_m);
  // To be called after `step_back`.
  double touched_N() const { return touched_->force_N(); }  // at standstill
  // Whether the felt force fell on the way back. A force that stays does not come from a specimen,
  // and noise is no contact.
  bool is_contact() const;
  // Whether the way back ended because the force rose on it.
  bool rose() const { return rise_.has_value(); }
  // By how much more than the cell drifts; not positive: the drift explains it. `after`: a look at
  // rest afterwards.
  double rose_beyond_N(const RestMeasurement& after) const;
  std::string why_rose() const;  // the forces; call it only if it rose
  // Errors: refused, when pressing lowered the force.
  Result<> check_felt(double felt_N) const;
  // The force of the cell without contact: `after`, or the last step back if that was further away
  // and shows less. After a search that overran its contact, the way back may end too early, with
  // the probe still pressing.
  const RestMeasurement& off_contact(const RestMeasurement& after) const;
  // How far back from where it touched the specimen may still be touched. At contact the probe
  // stands inside it.
  double depth_m() const;
  // Whether the probe still presses at this look, so that it is none of the cell without contact.
  bool presses(const RestMeasurement& look) const;
  // Computes the stiffness and passes it to the forecast and to the watch of the force. `after`:
  // the cell without contact. `speed_m_s`: of the search.
  void conclude_stiffness(const RestMeasurement& after, double speed_m_s) const;

 private:
  Task<> let_follow() const;
  Task<Result<>> look_at_contact();
  std::string why_not_measured(std::size_t touching, bool overran) const;
  std::size_t touching(
      const RestMeasurement& after) const;  // how many of the first looks still touch
  double felt_N() const { return touched_N() - before_.force_N(); }
  double left_N(const RestMeasurement& look) const { return look.force_N() - before_.force_N(); }

  RunParts& run_;
  const RestMeasurement before_;
  const double rise_N_;
  std::optional<RestMeasurement> touched_;  // the first look at contact
  std::vector<RestMeasurement>
      looks_;  // at contact, when the specimen had relaxed, and after each step back
  std::optional<std::pair<RestMeasurement, RestMeasurement>>
      rise_;  // the look at contact, and the higher one
  double relaxes_N_s_ = HUGE_VAL;  // at most, at the first of them
  double first_step_m_ = 0;
};

}  // namespace lcrig
