// SPDX-License-Identifier: Apache-2.0
// The checks of `lcrig doctor`. Each opens no port, changes nothing, and says in one line what it
// found, and how to mend it.
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
  std::string what, mend;  // mend: empty when nothing is to be done
};
using Findings = std::vector<Finding>;
Health worst_of(const Findings& findings);

// The computer; replaceable in tests.
struct Machine {
  std::filesystem::path root = "/";  // of proc, sys, run and dev
  // Output of a command; nullopt: it is not there, or failed. Words are taken as they are.
  std::function<std::optional<std::string>(const std::vector<std::string>&)> output;
  std::function<std::optional<bool>()> clock_is_synchronised;
};
Machine real_machine();

// The part of the daemon's configuration that the checks need.
struct RigConfig {
  std::string file;
  std::string meter_port, frame_port;  // empty: none
  std::string wire_log_directory;
};
// nullopt: not there, not readable, or wrong; `findings` says which.
std::optional<RigConfig> look_at_config(const std::string& file, Findings& findings);

// The computer.
Finding look_at_clock(const Machine& machine);
Finding look_at_steal(const Machine& machine);
Finding look_at_lateness(const Clock& clock);
void look_at_service(const Machine& machine, Findings& findings);
void look_at_memory(const Machine& machine, std::optional<int> daemon_pid, Findings& findings);

// The rig.
void look_at_ports(const Machine& machine, const RigConfig& config, Findings& findings);
void look_at_modules(const Machine& machine, const RigConfig& config, Findings& findings);
Finding look_at_group(const std::string& group);
void look_at_instruments(const DaemonStatus& status, Findings& findings);

// The data.
void look_at_database(const Database& db, Findings& findings);
Finding look_at_disk(const Database& db, std::int64_t now_unix_ns);
// Room for the plans of all that waits in the queue.
Finding look_at_plans(const Database& db);
// The meter's, as it was read back in the last run with instruments; nothing without such a run.
void look_at_meter_settings(const Database& db, Findings& findings);
// Open and short correction of the meter that said so now, else of the last run with instruments.
void look_at_corrections(const Database& db, const std::optional<MeterCorrections>& asked,
                         std::int64_t now_unix_ns, Findings& findings);
// Of the file that the daemon says it has: nullopt unless it has another one open, of this name.
std::optional<Finding> look_whether_replaced(const Machine& machine, const std::string& database);
// Process that holds the writer's lock; nullopt: none, or it cannot be told.
std::optional<int> writer_of(const std::string& database);

}  // namespace lcrig::cli
