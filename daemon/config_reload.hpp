// SPDX-License-Identifier: Apache-2.0
// The configuration of a daemon that rereads its file: what is in force, what the file says now,
// and which changes wait for the end of a run or for a restart. Used by ConfigTaker.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/config_keys.hpp"

namespace lcrig {

class ConfigReload {
 public:
  // `in_force` must outlive it and changes only in the calls below.
  explicit ConfigReload(Config& in_force) : in_force_(in_force) {}

  // Applies a file without mistakes. Some keys change at once. Others change while the daemon is
  // idle (`idle`, or take_when_idle), or need a restart. Returns the lines for the journal.
  std::vector<std::string> take(Config wanted, bool idle);
  // The daemon is idle now: applies the changes that waited for that. Returns the lines for the
  // journal; empty: there were none.
  std::vector<std::string> take_when_idle();
  // Takes note of a bad file. The configuration in force stays.
  void refuse(std::string why) { refused_ = std::move(why); }

  ConfigView view() const;

 private:
  Config& in_force_;
  std::optional<Config> wanted_;  // the last good file; empty: no other since the start
  std::string refused_;  // why the last file was not applied
};

}  // namespace lcrig
