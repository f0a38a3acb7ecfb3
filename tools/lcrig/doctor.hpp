// SPDX-License-Identifier: Apache-2.0
// The checks of `lcrig doctor`. They open no port and change nothing. Each says in one line what it
// found and how to mend it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "daemon/control/messages.hpp"
#include "storage/corrections.hpp"
#include "storage/sqlite.hpp"

namespace lcrig::cli {

enum class Health { ok, warn, bad };
const char* to_string(Health health);

struct Finding {
  Finding(std::string a, Health h, std::string w, std::string m = {})
      : about(std::move(a)), health(h), what(std::move(w)), mend(std::move(m)) {}
  std::string about;
  Health health;
  std::string what, mend;  // mend: empty when there is nothing to do
};
using Findings = std::vector<Finding>;
Health worst_of(const Findings& findings);

// The computer. Tests replace it.
struct Machine {
  std::filesystem::path root = "/";  // folder that contains proc, sys, run and dev
  // Output of a command, whose words are passed on unchanged. nullopt: it does not exist, or
  // failed.
  std::function<std::optional<std::string>(const std::vector<std::string>&)> output;
  std::function<std::optional<bool>()> clock_is_synchronised;
};
Machine real_machine();

// The part of the daemon's configuration that the checks need.
struct RigConfig {
  std::string file;
  std::string meter_port, frame_port;  // empty: there is none
  std::string wire_log_directory;
};
// nullopt: the file does not exist, is not readable or is wrong; `findings` says which.
std::optional<RigConfig> look_at_config(const std::string& file, Findings& findings);

// Checks of the computer.
Finding look_at_clock(const Machine& machine);
Finding look_at_steal(const Machine& machine);
Finding look_at_lateness(const Clock& clock);
void look_at_service(const Machine& machine, Findings& findings);
void look_at_memory(const Machine& machine, std::optional<int> daemon_pid, Findings& findings);

// Checks of the rig.
void look_at_ports(const Machine& machine, const RigConfig& config, Findings& findings);
void look_at_modules(const Machine& machine, const RigConfig& config, Findings& findings);
Finding look_at_group(const std::string& group);
void look_at_instruments(const DaemonStatus& status, Findings& findings);

// Checks of the data.
void look_at_database(const Database& db, Findings& findings);
Finding look_at_disk(const Database& db, std::int64_t now_unix_ns);
// Room on the disk for the plans of everything in the queue.
Finding look_at_plans(const Database& db);
// The meter's settings as read back in the last run with instruments; nothing without such a run.
void look_at_meter_settings(const Database& db, Findings& findings);
// Open and short correction, as the meter says now or else as in the last run with instruments.
void look_at_corrections(const Database& db, const std::optional<MeterCorrections>& asked,
                         std::int64_t now_unix_ns, Findings& findings);
// The finding that the daemon has another file of this name open. nullopt: it has not, or nobody
// knows.
std::optional<Finding> look_whether_replaced(const Machine& machine, const std::string& database);
// Process that holds the writer's lock. nullopt: there is none, or it cannot be determined.
std::optional<int> writer_of(const std::string& database);

}  // namespace lcrig::cli
