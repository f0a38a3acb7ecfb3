// SPDX-License-Identifier: Apache-2.0
// Knows the place of contact with the specimen as machine travel, which is gap zero. A search finds
// it, or a person states it. Motions to a gap, the guard and the end of the run need it.
#pragma once

#include <optional>

#include "protocols/run/frame_watch.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

class ContactPlace {
 public:
  // All must outlive it. `values`: of the numbers in targets.
  ContactPlace(const RunSetup& setup, const Environment& values, FrameWatch& watch)
      : setup_(setup), values_(values), watch_(watch) {}

  std::optional<double> travel_m() const { return travel_m_; }
  double force_N() const { return force_N_; }  // force there, beyond that at rest
  void place(double travel_m, double force_N);
  // From there to gap zero the probe may already touch the specimen.
  double depth_m() const { return depth_m_; }
  void know_depth(double depth_m) { depth_m_ = depth_m; }
  void forget() { travel_m_.reset(); }
  // A continued run knows it from the run before. The gap limits are not set again.
  void take_from(std::optional<double> travel_m) { travel_m_ = travel_m; }
  // Machine travel of a target in travel or gap. Errors: invalid_request without a contact.
  Result<double> travel_of(const Target& target, const std::string& step_id) const;

  // Makes this travel the new zero. Contact has to be found again.
  void zero_travel(double travel_m);
  // The present zero, counted from the one at the start of the run.
  double zero_m() const { return zero_m_; }
  FrameCapabilities frame_capabilities() const;  // with travel as samples show it now

  // Where the frame stood when the run began.
  std::optional<double> start_travel_m() const { return start_travel_m_; }
  void start_at(std::optional<double> travel_m) { start_travel_m_ = travel_m; }
  // Where a search began that has not found contact.
  std::optional<double> searched_from_m() const { return searched_from_m_; }
  void search_from(std::optional<double> travel_m) { searched_from_m_ = travel_m; }

 private:
  const RunSetup& setup_;
  const Environment& values_;
  FrameWatch& watch_;
  std::optional<double> travel_m_;
  double force_N_ = 0;
  double depth_m_ = 0;
  double zero_m_ = 0;
  std::optional<double> start_travel_m_, searched_from_m_;
};

}  // namespace lcrig
