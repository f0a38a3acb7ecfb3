// SPDX-License-Identifier: Apache-2.0
// Whether what a search touched is a contact, and how stiff it is: measured on the first
// micrometres of the way back, which cannot press harder. Used by the search.
#pragma once

#include <vector>

#include "protocols/run/run_parts.hpp"

namespace lcrig {

class ContactProbe {
 public:
  static constexpr Duration kLook = std::chrono::milliseconds(300);

  // `before`: what the cell showed without contact. `rise_N` above it counts as contact.
  ContactProbe(RunParts& run, const Rest& before, double rise_N)
      : run_(run), before_(before), rise_N_(rise_N) {}

  // Looks where it touches, then steps back, each time twice as far as before, as long as something
  // of the force is left: the longest way in contact tells the slope best.
  Task<Result<>> step_back(double touched_m);
  // After `step_back`.
  double touched_N() const { return looks_.front().force_N(); }  // once the frame stood there
  // What was felt is gone, or grew less, where the probe went away: a force that stays is none of a
  // specimen, and noise is none.
  bool is_contact() const;
  // A force that falls where the probe presses. Errors: refused.
  Result<> check_felt(double felt_N) const;
  // What the cell shows off the contact: `after`, unless the frame stands nearer there than at the
  // last step back and the cell shows more. A search that overran its contact by more than the way
  // back still presses.
  const Rest& off_contact(const Rest& after) const;
  // `after`: what the cell shows off the contact. Tells the forecast and the watch of the force.
  void conclude_stiffness(const Rest& after) const;

 private:
  double felt_N() const { return touched_N() - before_.force_N(); }

  RunParts& run_;
  const Rest before_;
  const double rise_N_;
  std::vector<Rest> looks_;  // at contact, and after each step back
};

}  // namespace lcrig
