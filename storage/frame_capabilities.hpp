// SPDX-License-Identifier: Apache-2.0
// What the frame of a run could do, and which load cell and probe were in it, as the run's row
// stores it (RunRow::frame_capabilities_json). The daemon writes it, the analysis reads it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

struct StoredCapabilities {
  bool motion = false, force_hold = false, device_stop = false;
  bool weights = false;  // a rod with weights
  double force_max_N = 0, speed_max_m_s = 0, travel_min_m = 0, travel_max_m = 0;
  double reaction_s = 0, deceleration_m_s2 = 0;
  std::optional<double> force_class_percent = {};  // of the load cell; absent: not stated
  std::string cell_serial = {}, probe_serial = {}, probe_name = {};  // as stated; empty: not stated
};
std::string to_json(const StoredCapabilities& capabilities);
// What `text` does not contain keeps its default.
StoredCapabilities parse_capabilities(std::string_view text);

}  // namespace lcrig
