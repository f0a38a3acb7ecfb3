// SPDX-License-Identifier: Apache-2.0
#include "storage/frame_capabilities.hpp"

#include <nlohmann/json.hpp>

namespace lcrig {

using nlohmann::json;

namespace {

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
}

}  // namespace

std::string to_json(const StoredCapabilities& capabilities) {
  json out;
  fields([&out](const char* key, auto value) { out[key] = value; }, capabilities);
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
  return out;
}

}  // namespace lcrig
