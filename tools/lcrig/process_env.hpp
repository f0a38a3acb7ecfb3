// SPDX-License-Identifier: Apache-2.0
// The surroundings of the program: environment variables and well-known files. Tests replace it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/time.hpp"

namespace lcrig::cli {

struct ProcessEnv {
  // Empty values count as absent.
  std::function<std::optional<std::string>(const char*)> variable;
  std::filesystem::path executable;
  std::filesystem::path daemon_db = "/var/lib/lcrig/lcrig.db";  // as in systemd/lcrigd.service
  std::filesystem::path daemon_socket = "/run/lcrig/control.sock";
  std::filesystem::path daemon_config = "/etc/lcrig/lcrigd.json";
  Duration daemon_patience = std::chrono::seconds(2);  // for commands that can do without a daemon
  // For people who stop the frame. The daemon answers only when the frame has confirmed standstill.
  // The first is when they are told to stop it by hand; the second ends the wait.
  Duration stop_hint_after = std::chrono::milliseconds(1500);
  Duration stop_patience = std::chrono::seconds(90);
  Duration status_patience = std::chrono::seconds(10);  // for those who look; asks no instrument

  std::optional<std::string> get(const char* name) const {
    return variable ? variable(name) : std::nullopt;
  }
  // The user's own database: ${XDG_DATA_HOME:-~/.local/share}/lcrig/lcrig.db
  std::filesystem::path user_db() const;
  // Database of rehearsals: $LCRIG_DB, else the user's. Never the daemon's: they measure nothing.
  std::filesystem::path rehearsal_db() const;
  // $LCRIG_DB, or else the daemon's if it exists, or else the user's.
  std::filesystem::path default_db() const;
  std::filesystem::path default_socket() const;  // $LCRIG_SOCKET, or else the daemon's
};

ProcessEnv real_process_env();

}  // namespace lcrig::cli
