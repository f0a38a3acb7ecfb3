// SPDX-License-Identifier: Apache-2.0
#include "storage/frame_capabilities.hpp"

#include <nlohmann/json.hpp>
#include <type_traits>

namespace lcrig {

using nlohmann::json;

namespace {

constexpr const char* kForceClass = "force_class_percent";

template <class F, class T>
void fields(F field, T& c) {
  field("motion", c.motion);
  field("force_hold", c.force_hold);
  field("device_stop", c.device_stop);
  field("weights", c.weights);
  field("force_max_N", c.force_max_N);
  field("speed_max_m_s", c.speed_max_m_s);
  field("travel_min_m", c.travel_min_m);
  field("travel_max_m", c.travel_max_m);
  field("reaction_s", c.reaction_s);
  field("deceleration_m_s2", c.deceleration_m_s2);
  field("cell_serial", c.cell_serial);
  field("probe_serial", c.probe_serial);
  field("probe_name", c.probe_name);
}

}  // namespace

std::string to_json(const StoredCapabilities& capabilities) {
  json out;
  const auto write = [&out](const char* key, const auto& value) {
    if constexpr (std::is_same_v<decltype(value), const std::string&>) {
      if (value.empty()) return;
    }
    out[key] = value;
  };
  fields(write, capabilities);
  if (capabilities.force_class_percent) out[kForceClass] = *capabilities.force_class_percent;
  return out.dump();
}

StoredCapabilities parse_capabilities(std::string_view text) {
  const json stored = json::parse(text, nullptr, false);
  StoredCapabilities out;
  const auto read = [&stored](const char* key, auto& value) {
    const auto found = stored.find(key);
    if (found != stored.end() && found->type() == json(value).type()) found->get_to(value);
  };
  fields(read, out);
  double percent = 0;
  read(kForceClass, percent);
  if (percent > 0) out.force_class_percent = percent;
  return out;
}

}  // namespace lcrig
