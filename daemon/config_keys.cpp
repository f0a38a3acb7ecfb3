// SPDX-License-Identifier: Apache-2.0
#include "daemon/config_keys.hpp"

#include <algorithm>
#include <functional>
#include <string_view>

namespace lcrig {

namespace {

// The part of the configuration that a key belongs to.
enum class Part { daemon, rig };
// What must be there for a key to mean anything.
enum class Needs { nothing, bench, ports, machine, force_loop };

struct Key {
  std::string_view name;
  Part part;
  Needs needs;
  ConfigEffect effect;
  ConfigValue (*value)(const Config&);
  void (*take)(Config& in_force, const Config& wanted);  // nullptr: only a restart does
};

ConfigValue text(const std::string& value) {
  if (value.empty()) return {};
  return value;
}

ConfigValue scaled(const std::optional<double>& si, double to_unit) {
  if (!si) return {};
  return *si * to_unit;
}

template <class Read>
ConfigValue of_loop(const Config& c, Read read) {
  if (!c.frame.force_loop) return {};
  return read(*c.frame.force_loop);
}

void take_frame(Config& in_force, const Config& wanted) {
  in_force.frame = wanted.frame;
}
void take_fixture(Config& in_force, const Config& wanted) {
  in_force.fixture = wanted.fixture;
}

constexpr auto kNow = ConfigEffect::at_once;
constexpr auto kIdle = ConfigEffect::when_idle;
constexpr auto kRestart = ConfigEffect::restart;

// lint: table
constexpr Key kKeys[] = {
    {"database", Part::daemon, Needs::nothing, kRestart,
     [](const Config& c) { return text(c.database); }, nullptr},
    {"socket", Part::daemon, Needs::nothing, kRestart,
     [](const Config& c) { return text(c.socket); }, nullptr},
    {"log_level", Part::daemon, Needs::nothing, kNow,
     [](const Config& c) { return text(c.log_level); },
     [](Config& c, const Config& w) { c.log_level = w.log_level; }},
    {"metrics_file", Part::daemon, Needs::nothing, kNow,
     [](const Config& c) { return text(c.metrics_file); },
     [](Config& c, const Config& w) { c.metrics_file = w.metrics_file; }},
    {"bench", Part::rig, Needs::bench, kRestart,
     [](const Config& c) { return text(c.bench.value_or("")); }, nullptr},
    {"meter.driver", Part::rig, Needs::ports, kRestart,
     [](const Config& c) {
       return text(c.meter_driver == nullptr ? "" : std::string(c.meter_driver->name));
     },
     nullptr},
    {"meter.port", Part::rig, Needs::ports, kRestart,
     [](const Config& c) { return text(c.meter_port); }, nullptr},
    {"meter.serial_number", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return text(c.meter_serial_number); },
     [](Config& c, const Config& w) { c.meter_serial_number = w.meter_serial_number; }},
    {"frame.driver", Part::rig, Needs::ports, kRestart,
     [](const Config& c) {
       if (c.bench) return ConfigValue();
       return text(c.frame_driver == FrameDriver::zwick ? "zwick" : "dead_weight");
     },
     nullptr},
    {"frame.port", Part::rig, Needs::machine, kRestart,
     [](const Config& c) { return text(c.frame_port); }, nullptr},
    {"frame.stiffness_N_mm", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return scaled(c.frame.stiffness_N_m, 1e-3); }, take_frame},
    {"frame.start_gap_mm", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return scaled(c.frame.start_gap_m, 1e3); }, take_frame},
    {"frame.force_class", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return ConfigValue(c.frame.force_class_percent); }, take_frame},
    {"frame.force_loop.approach_mm_s", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) {
       return of_loop(c, [](const ForceLoop& l) { return l.approach.si() * 1e3; });
     },
     take_frame},
    {"frame.force_loop.contact_N", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) { return of_loop(c, [](const ForceLoop& l) { return l.contact.si(); }); },
     take_frame},
    {"frame.force_loop.rate_max_N_s", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) { return of_loop(c, [](const ForceLoop& l) { return l.rate_max.si(); }); },
     take_frame},
    {"frame.force_loop.lag_s", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) {
       return of_loop(c, [](const ForceLoop& l) { return to_seconds(l.lag); });
     },
     take_frame},
    {"frame.force_loop.ripple_N", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) { return of_loop(c, [](const ForceLoop& l) { return l.ripple.si(); }); },
     take_frame},
    {"frame.force_loop.stiffness_max_N_mm", Part::rig, Needs::force_loop, kIdle,
     [](const Config& c) {
       return of_loop(c, [](const ForceLoop& l) { return l.stiffness_max.si() * 1e-3; });
     },
     take_frame},
    {"fixture.probe_diameter_mm", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return scaled(c.fixture.probe_diameter_m, 1e3); }, take_fixture},
    {"fixture.local_gravity_m_s2", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return ConfigValue(c.fixture.local_gravity_m_s2); }, take_fixture},
    {"wire_log_directory", Part::daemon, Needs::ports, kIdle,
     [](const Config& c) { return text(c.wire_log_directory); },
     [](Config& c, const Config& w) { c.wire_log_directory = w.wire_log_directory; }},
};

bool applies(const Key& key, const Config& config) {
  switch (key.needs) {
    case Needs::nothing: return true;
    case Needs::bench: return config.bench.has_value();
    case Needs::ports: return !config.bench;
    case Needs::machine: return !config.bench && config.frame_driver == FrameDriver::zwick;
    case Needs::force_loop: return !config.bench && config.frame.force_loop.has_value();
  }
  return true;
}

// A key may have another unit in the file: "frame.stiffness_N_m".
bool is_given(const std::vector<std::string>& given, std::string_view key) {
  std::string_view stem = key;
  for (const std::string_view unit : {"_N_mm", "_mm_s", "_mm", "_N_s", "_m_s2", "_N", "_s"}) {
    if (!stem.ends_with(unit)) continue;
    stem.remove_suffix(unit.size());
    break;
  }
  const bool has_unit = stem.size() < key.size();
  return std::ranges::any_of(given, [&](const std::string& k) {
    return k == key || (has_unit && k.starts_with(std::string(stem) + "_"));
  });
}

ConfigSource source_of(const Config& config, std::string_view key) {
  if (std::ranges::count(config.of_command_line, key) > 0) return ConfigSource::command_line;
  return is_given(config.given, key) ? ConfigSource::file : ConfigSource::built_in;
}

// All keys of the rig belong together.
bool is_of_rig(const Key& key) {
  return key.part != Part::daemon;
}

}  // namespace

std::vector<ConfigKeyView> keys_of(const Config& config) {
  std::vector<ConfigKeyView> out;
  for (const Key& key : kKeys) {
    if (!applies(key, config)) continue;
    auto& view = out.emplace_back();
    view.key = key.name;
    view.value = key.value(config);
    view.source = source_of(config, key.name);
  }
  return out;
}

std::vector<ConfigChange> changes_of(const Config& in_force, const Config& wanted) {
  std::vector<ConfigChange> out;
  bool other_rig = false;
  for (const Key& key : kKeys) {
    ConfigChange change;
    change.key = key.name;
    change.from = key.value(in_force);
    change.to = key.value(wanted);
    change.effect = key.effect;
    if (change.from == change.to) continue;
    other_rig = other_rig || (is_of_rig(key) && key.effect == kRestart);
    out.push_back(std::move(change));
  }
  if (!other_rig) return out;
  for (ConfigChange& change : out) {
    const auto key = std::ranges::find(kKeys, change.key, &Key::name);
    if (is_of_rig(*key)) change.effect = kRestart;
  }
  return out;
}

void take_changes(Config& in_force, const Config& wanted, const std::vector<ConfigChange>& changes,
                  ConfigEffect effect) {
  for (const ConfigChange& change : changes) {
    const auto key = std::ranges::find(kKeys, change.key, &Key::name);
    if (change.effect == effect && key->take != nullptr) key->take(in_force, wanted);
  }
}

}  // namespace lcrig
