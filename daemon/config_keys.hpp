// SPDX-License-Identifier: Apache-2.0
// A table of all keys of the config file: their values in a Config, and when a change of each takes
// effect. Used by ConfigReload and `lcrig config`.
#pragma once

#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/control/config_view.hpp"

namespace lcrig {

// Every key that applies to this rig, with its value and source.
std::vector<ConfigKeyView> keys_of(const Config& config);

struct ConfigChange {
  std::string key;
  ConfigValue from, to;
  ConfigEffect effect = ConfigEffect::at_once;
};
// The keys that differ in `wanted`, and when each change takes effect. If the rig itself changes
// (drivers, ports, bench), all keys of the rig wait for a restart, so that the daemon never mixes
// two rigs.
std::vector<ConfigChange> changes_of(const Config& in_force, const Config& wanted);

// Applies those of `changes` that take effect at `effect`.
void take_changes(Config& in_force, const Config& wanted, const std::vector<ConfigChange>& changes,
                  ConfigEffect effect);

}  // namespace lcrig
