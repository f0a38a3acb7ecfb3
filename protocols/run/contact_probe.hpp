// SPDX-License-Identifier: Apache-2.0
// Whether what a search touched is a contact, and how stiff it is: measured on the first
// micrometres of the way back, which cannot press harder. Used by the search.
#pragma once

#include <cstddef>
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
  // Whether the force that was felt fell on the way back. One that stays does not come from a
  // specimen, and noise is no contact.
  bool is_contact() const;
  // Errors: refused, when the force fell where the probe presses.
  Result<> check_felt(double felt_N) const;
  // Force that the cell shows off the contact: `after`, or the last step back if that was further
  // away and shows less. After a search that overran its contact the way back may end too early,
  // with the probe still pressing.
  const Rest& off_contact(const Rest& after) const;
  // `after`: the force off the contact. `speed_m_s`: of the search. Tells the forecast and the
  // watch of the force.
  void conclude_stiffness(const Rest& after, double speed_m_s) const;

 private:
  double first_step_m() const;
  std::size_t touching(const Rest& after) const;  // so many of the looks, the first ones
  double felt_N() const { return touched_N() - before_.force_N(); }

  RunParts& run_;
  const Rest before_;
  const double rise_N_;
  std::vector<Rest> looks_;  // at contact, and after each step back
};

}  // namespace lcrig
