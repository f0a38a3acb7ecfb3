// SPDX-License-Identifier: Apache-2.0
// The configuration of a daemon that is asked to read its file again: what is in force, what the
// file says since, and what of it waits for the end of a run or for a restart.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/config_keys.hpp"

namespace lcrig {

class ConfigReload {
 public:
  // `in_force` outlives it and changes only in the calls below.
  explicit ConfigReload(Config& in_force) : in_force_(in_force) {}

  // Applies a file without mistakes. Some keys change at once. The others change while the daemon
  // is idle (`idle`, or take_when_idle), or need a restart. Returns the lines for the journal.
  std::vector<std::string> take(Config wanted, bool idle);
  // The daemon is idle now: takes what waited for that. Empty: nothing did.
  std::vector<std::string> take_when_idle();
  // A bad file: what is in force stays.
  void refuse(std::string why) { refused_ = std::move(why); }

  ConfigView view() const;

 private:
  Config& in_force_;
  std::optional<Config> wanted_;  // the last good file; empty: the one that the daemon began with
  std::string refused_;  // why the last one was not taken
};

}  // namespace lcrig
