// SPDX-License-Identifier: Apache-2.0
// What the frame of a run could do, and which load cell and probe were in it, as the run's row
// stores it (RunRow::frame_capabilities_json). The daemon writes it, the analysis reads it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

struct StoredForceLoop {
  double approach_m_s = 0, contact_N = 0, rate_max_N_s = 0, lag_s = 0, ripple_N = 0;
  double stiffness_max_N_m = 0;
};

// Rows of an older lcrig lack `force_loop`, the channels, the zeros, `speed_min_m_s` and
// `sample_rate_max_Hz`.
struct StoredCapabilities {
  bool motion = false, force_hold = false, device_stop = false;
  bool weights = false;  // a rod with weights
  bool force_channel = true, travel_channel = true, zero_force = false, zero_travel = false;
  double force_max_N = 0, speed_min_m_s = 0, speed_max_m_s = 0;
  double travel_min_m = 0, travel_max_m = 0, sample_rate_max_Hz = 0;
  double reaction_s = 0, deceleration_m_s2 = 0;
  std::optional<double> force_class_percent = {};  // of the load cell; absent: not stated
  std::optional<StoredForceLoop> force_loop = {};  // absent: not known
  // As stated; absent: not stated.
  std::optional<double> travel_step_m = {}, force_step_N = {}, filter_s = {}, play_m = {};
  std::string cell_serial = {}, probe_serial = {}, probe_name = {};  // as stated; empty: not stated
};
std::string to_json(const StoredCapabilities& capabilities);
// What `text` does not contain keeps its default.
StoredCapabilities parse_capabilities(std::string_view text);

}  // namespace lcrig
