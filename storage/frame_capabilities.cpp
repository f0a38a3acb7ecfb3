// SPDX-License-Identifier: Apache-2.0
#include "storage/frame_capabilities.hpp"

#include <nlohmann/json.hpp>
#include <type_traits>

namespace lcrig {

using nlohmann::json;

namespace {

constexpr const char* kForceLoop = "force_loop";

template <class F, class T>
void fields(F field, T& c) {
  field("motion", c.motion);
  field("force_hold", c.force_hold);
  field("device_stop", c.device_stop);
  field("weights", c.weights);
  field("force_channel", c.force_channel);
  field("travel_channel", c.travel_channel);
  field("zero_force", c.zero_force);
  field("zero_travel", c.zero_travel);
  field("force_max_N", c.force_max_N);
  field("speed_min_m_s", c.speed_min_m_s);
  field("speed_max_m_s", c.speed_max_m_s);
  field("travel_min_m", c.travel_min_m);
  field("travel_max_m", c.travel_max_m);
  field("sample_rate_max_Hz", c.sample_rate_max_Hz);
  field("reaction_s", c.reaction_s);
  field("deceleration_m_s2", c.deceleration_m_s2);
  field("cell_serial", c.cell_serial);
  field("probe_serial", c.probe_serial);
  field("probe_name", c.probe_name);
}

// Optional numbers.
template <class F, class T>
void stated_fields(F field, T& c) {
  field("force_class_percent", c.force_class_percent);
  field("travel_step_m", c.travel_step_m);
  field("force_step_N", c.force_step_N);
  field("filter_s", c.filter_s);
  field("play_m", c.play_m);
}

template <class F, class T>
void loop_fields(F field, T& loop) {
  field("approach_m_s", loop.approach_m_s);
  field("contact_N", loop.contact_N);
  field("rate_max_N_s", loop.rate_max_N_s);
  field("lag_s", loop.lag_s);
  field("ripple_N", loop.ripple_N);
  field("stiffness_max_N_m", loop.stiffness_max_N_m);
}

// Some of its fields without the others bound nothing.
std::optional<StoredForceLoop> parse_loop(const json& stored) {
  if (!stored.is_object()) return std::nullopt;
  StoredForceLoop out;
  bool whole = true;
  const auto read = [&](const char* key, double& value) {
    const auto found = stored.find(key);
    if (found != stored.end() && found->is_number()) {
      found->get_to(value);
    } else {
      whole = false;
    }
  };
  loop_fields(read, out);
  return whole ? std::optional(out) : std::nullopt;
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
  const auto write_stated = [&out](const char* key, const std::optional<double>& value) {
    if (value) out[key] = *value;
  };
  stated_fields(write_stated, capabilities);
  if (capabilities.force_loop) {
    json& loop = out[kForceLoop];
    const auto write_loop = [&loop](const char* key, double value) { loop[key] = value; };
    loop_fields(write_loop, *capabilities.force_loop);
  }
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
  const auto read_stated = [&stored](const char* key, std::optional<double>& value) {
    const auto found = stored.find(key);
    if (found != stored.end() && found->is_number()) value = found->get<double>();
  };
  stated_fields(read_stated, out);
  if (!(out.force_class_percent.value_or(1) > 0)) out.force_class_percent.reset();
  if (const auto loop = stored.find(kForceLoop); loop != stored.end()) {
    out.force_loop = parse_loop(*loop);
  }
  return out;
}

}  // namespace lcrig
