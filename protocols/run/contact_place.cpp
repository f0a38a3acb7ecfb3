// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/contact_place.hpp"

namespace lcrig {

void ContactPlace::place(double travel_m, double force_N) {
  travel_m_ = travel_m;
  force_N_ = force_N;
  depth_m_ = 0;
  watch_.place_contact(travel_m);
}

Result<double> ContactPlace::travel_of(const Target& target, const std::string& step_id) const {
  const double value = values_.get(target.value);
  if (target.kind == TargetKind::travel) return value;
  if (!travel_m_) {
    return fail(Errc::invalid_request,
                "step {}: a gap, and the place of contact is not known: find the contact first, or "
                "state the gap (set_gap)",
                step_id);
  }
  return *travel_m_ - value;
}

void ContactPlace::zero_travel(double travel_m) {
  forget();
  watch_.zero_travel(travel_m);
  zero_m_ += travel_m;
}

FrameCapabilities ContactPlace::frame_capabilities() const {
  return with_zero_at(setup_.frame.capabilities(), zero_m_);
}

}  // namespace lcrig
