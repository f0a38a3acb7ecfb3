// SPDX-License-Identifier: Apache-2.0
// Where the program runs: environment variables and files, replaceable in tests.
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
  std::filesystem::path daemon_db = "/var/lib/lcrig/lcrig.db";  // as systemd/lcrigd.service says
  std::filesystem::path daemon_socket = "/run/lcrig/control.sock";
  std::filesystem::path daemon_config = "/etc/lcrig/lcrigd.json";
  Duration daemon_patience = std::chrono::seconds(2);  // of commands that can do without a daemon
  // For people who stop the frame. They wait this long for the daemon, whose frame confirms
  // standstill first, and are then told to stop it by hand.
  Duration stop_hint_after = std::chrono::milliseconds(1500);
  Duration stop_patience = std::chrono::seconds(90);
  Duration status_patience = std::chrono::seconds(10);  // of who looks; no instrument is asked

  std::optional<std::string> get(const char* name) const {
    return variable ? variable(name) : std::nullopt;
  }
  // The user's own database: ${XDG_DATA_HOME:-~/.local/share}/lcrig/lcrig.db
  std::filesystem::path user_db() const;
  // Where rehearsals go: $LCRIG_DB, else the user's. Never the daemon's: they measure nothing.
  std::filesystem::path rehearsal_db() const;
  // $LCRIG_DB, else the daemon's if it exists, else the user's.
  std::filesystem::path default_db() const;
  std::filesystem::path default_socket() const;  // $LCRIG_SOCKET, else the daemon's
};

ProcessEnv real_process_env();

}  // namespace lcrig::cli
