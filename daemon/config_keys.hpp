// SPDX-License-Identifier: Apache-2.0
// The keys of the config file one by one: what they are in a Config, and what a change of them
// asks for.
#pragma once

#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/control/config_view.hpp"

namespace lcrig {

// Every key that applies to such a rig, with its value and source.
std::vector<ConfigKeyView> keys_of(const Config& config);

struct ConfigChange {
  std::string key;
  ConfigValue from, to;
  ConfigEffect effect = ConfigEffect::at_once;
};
// The keys that differ in `wanted`, and when each can be taken. If the rig itself changes (its
// drivers, its ports, a bench), all keys of the rig wait for the restart: never half a rig.
std::vector<ConfigChange> changes_of(const Config& in_force, const Config& wanted);

// Takes from `wanted` what `changes` says can be taken so.
void take_changes(Config& in_force, const Config& wanted, const std::vector<ConfigChange>& changes,
                  ConfigEffect effect);

}  // namespace lcrig
