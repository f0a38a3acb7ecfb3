// SPDX-License-Identifier: Apache-2.0
// Searches for contact: with a cell that is alive, over a bounded way, and in legs, so that drift
// of the cell is not taken for a force. Used by the step `find_contact`.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

class ContactProbe;
struct RunParts;
struct FindContactStep;  // steps/find_contact.hpp

class ContactSearch {
 public:
  // Both must outlive it.
  ContactSearch(RunParts& run, const FindContactStep& step);

  // On success the place of contact is set, its stiffness is known as far as samples can show it,
  // and the probe is clear of it. `start_travel_m` stores where the search began, in case it has to
  // begin again. Errors: refused (no contact, or a cell that lies), limit_tripped, invalid_request.
  Task<Result<>> find(std::optional<double>& start_travel_m);

 private:
  Task<Result<>> return_to(double travel_m);
  Task<Result<>> look_before();
  Task<Result<>> check_obeys(const ContactProbe& probe);
  Result<> disbelieve_drive(const std::string& seen) const;
  Task<Result<>> look_again(MonoTime begun, const RestMeasurement& first);
  double speed_m_s() const;
  double furthest_m() const;
  Task<Result<MotionOutcome>> search();
  Task<Result<std::optional<MotionOutcome>>> approach();
  Task<Result<std::optional<MotionOutcome>>> look_between(MonoTime begun);
  double felt_beyond_drift_N(const RestMeasurement& now, Duration ago) const;
  Result<> check_touched(const MotionOutcome& touched) const;
  Task<Result<>> take_contact(const MotionOutcome& touched, const ContactProbe& probe);

  RunParts& run_;
  const FindContactStep& step_;
  double rise_N_;  // the rise above the force at rest that counts as contact
  RestMeasurement rest_;  // the cell's force here without the specimen
  double end_m_ = 0;  // end of the allowed way
  MonoTime deadline_{};
  int rises_ = 0;  // of the force on ways back, beyond drift
};

}  // namespace lcrig
