// SPDX-License-Identifier: Apache-2.0
#include "daemon/config_keys.hpp"

#include <algorithm>
#include <string_view>

#include "base/units.hpp"

namespace lcrig {

namespace {

// The part of the configuration that a key belongs to.
enum class Part { daemon, rig };
// The condition under which a key has a meaning.
enum class Needs { nothing, bench, ports, machine, force_loop };

struct Key {
  std::string_view name;
  Part part;
  Needs needs;
  ConfigEffect effect;
  ConfigValue (*value)(const Config&);
  void (*take)(Config& in_force, const Config& wanted);  // nullptr: takes effect only at a restart
};

ConfigValue text(const std::string& value) {
  if (value.empty()) return {};
  return value;
}

template <auto member>
ConfigValue text_of(const Config& c) {
  return text(c.*member);
}

ConfigValue scaled(const std::optional<double>& si, double to_unit) {
  if (!si) return {};
  return *si * to_unit;
}

double si_of(Duration time) {
  return to_seconds(time);
}
template <class Quantity>
double si_of(Quantity q) {
  return q.si();
}
template <auto member, double to_unit = 1.0>
ConfigValue of_loop(const Config& c) {
  if (!c.frame.stated.force_loop) return {};
  return si_of((*c.frame.stated.force_loop).*member) * to_unit;
}

template <auto member, double to_unit = 1.0>
ConfigValue stated(const Config& c) {
  const auto& value = c.frame.stated.*member;
  if (!value) return {};
  return si_of(*value) * to_unit;
}

template <auto member>
void take(Config& in_force, const Config& wanted) {
  in_force.*member = wanted.*member;
}

constexpr auto kNow = ConfigEffect::at_once;
constexpr auto kIdle = ConfigEffect::when_idle;
constexpr auto kRestart = ConfigEffect::restart;
constexpr auto kTakeFrame = take<&Config::frame>;
constexpr auto kTakeFixture = take<&Config::fixture>;

// lint: table
constexpr Key kKeys[] = {
    {"database", Part::daemon, Needs::nothing, kRestart, text_of<&Config::database>, nullptr},
    {"socket", Part::daemon, Needs::nothing, kRestart, text_of<&Config::socket>, nullptr},
    {"log_level", Part::daemon, Needs::nothing, kNow, text_of<&Config::log_level>,
     take<&Config::log_level>},
    {"metrics_file", Part::daemon, Needs::nothing, kNow, text_of<&Config::metrics_file>,
     take<&Config::metrics_file>},
    {"bench", Part::rig, Needs::bench, kRestart,
     [](const Config& c) { return text(c.bench.value_or("")); }, nullptr},
    {"meter.driver", Part::rig, Needs::ports, kRestart,
     [](const Config& c) {
       return text(c.meter_driver == nullptr ? "" : std::string(c.meter_driver->name));
     },
     nullptr},
    {"meter.port", Part::rig, Needs::ports, kRestart, text_of<&Config::meter_port>, nullptr},
    {"meter.serial_number", Part::rig, Needs::ports, kIdle, text_of<&Config::meter_serial_number>,
     take<&Config::meter_serial_number>},
    {"frame.driver", Part::rig, Needs::ports, kRestart,
     [](const Config& c) {
       if (c.bench) return ConfigValue();
       return text(std::string(to_string(c.frame_driver)));
     },
     nullptr},
    {"frame.port", Part::rig, Needs::machine, kRestart, text_of<&Config::frame_port>, nullptr},
    {"frame.stiffness_N_mm", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return scaled(c.frame.stiffness_N_m, 1e-3); }, kTakeFrame},
    {"frame.start_gap_mm", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return scaled(c.frame.start_gap_m, 1e3); }, kTakeFrame},
    {"frame.force_class", Part::rig, Needs::machine, kIdle,
     [](const Config& c) {
       const auto& cell = c.frame.stated.force_class;
       return cell ? ConfigValue(cell->percent()) : ConfigValue();
     },
     kTakeFrame},
    {"frame.travel_step_um", Part::rig, Needs::machine, kIdle,
     stated<&StatedFrame::travel_step, 1e6>, kTakeFrame},
    {"frame.force_step_mN", Part::rig, Needs::machine, kIdle, stated<&StatedFrame::force_step, 1e3>,
     kTakeFrame},
    {"frame.filter_s", Part::rig, Needs::machine, kIdle, stated<&StatedFrame::filter>, kTakeFrame},
    {"frame.play_um", Part::rig, Needs::machine, kIdle, stated<&StatedFrame::play, 1e6>,
     kTakeFrame},
    {"frame.cell_serial", Part::rig, Needs::machine, kIdle,
     [](const Config& c) { return text(c.frame.cell_serial); }, kTakeFrame},
    {"frame.force_loop.approach_mm_s", Part::rig, Needs::force_loop, kIdle,
     of_loop<&ForceLoop::approach, 1e3>, kTakeFrame},
    {"frame.force_loop.contact_N", Part::rig, Needs::force_loop, kIdle,
     of_loop<&ForceLoop::contact>, kTakeFrame},
    {"frame.force_loop.rate_max_N_s", Part::rig, Needs::force_loop, kIdle,
     of_loop<&ForceLoop::rate_max>, kTakeFrame},
    {"frame.force_loop.lag_s", Part::rig, Needs::force_loop, kIdle, of_loop<&ForceLoop::lag>,
     kTakeFrame},
    {"frame.force_loop.ripple_N", Part::rig, Needs::force_loop, kIdle, of_loop<&ForceLoop::ripple>,
     kTakeFrame},
    {"frame.force_loop.stiffness_max_N_mm", Part::rig, Needs::force_loop, kIdle,
     of_loop<&ForceLoop::stiffness_max, 1e-3>, kTakeFrame},
    {"fixture.probe_diameter_mm", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return scaled(c.fixture.probe_diameter_m, 1e3); }, kTakeFixture},
    {"fixture.probe_serial", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return text(c.fixture.probe_serial); }, kTakeFixture},
    {"fixture.probe_name", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return text(c.fixture.probe_name); }, kTakeFixture},
    {"fixture.local_gravity_m_s2", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return ConfigValue(c.fixture.local_gravity_m_s2); }, kTakeFixture},
    {"fixture.stray_limit_fF", Part::rig, Needs::ports, kIdle,
     [](const Config& c) { return scaled(c.fixture.stray_limit_F, 1e15); }, kTakeFixture},
    {"wire_log_directory", Part::daemon, Needs::ports, kIdle, text_of<&Config::wire_log_directory>,
     take<&Config::wire_log_directory>},
};

bool applies(const Key& key, const Config& config) {
  switch (key.needs) {
    case Needs::nothing: return true;
    case Needs::bench: return config.bench.has_value();
    case Needs::ports: return !config.bench;
    case Needs::machine: return !config.bench && config.frame_driver == FrameDriver::zwick;
    case Needs::force_loop: return !config.bench && config.frame.stated.force_loop.has_value();
  }
  return true;
}

// The file may give a key in another unit: "frame.stiffness_N_m".
bool is_given(const std::vector<std::string>& given, std::string_view key) {
  const auto stem = split_key(key).stem;
  return std::ranges::any_of(given,
                             [&](const std::string& k) { return split_key(k).stem == stem; });
}

ConfigSource source_of(const Config& config, std::string_view key) {
  if (std::ranges::count(config.of_command_line, key) > 0) return ConfigSource::command_line;
  return is_given(config.given, key) ? ConfigSource::file : ConfigSource::built_in;
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
    other_rig = other_rig || (key.part == Part::rig && key.effect == kRestart);
    out.push_back(std::move(change));
  }
  if (!other_rig) return out;
  // All keys of the rig change together.
  for (ConfigChange& change : out) {
    const auto key = std::ranges::find(kKeys, change.key, &Key::name);
    if (key->part == Part::rig) change.effect = kRestart;
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
