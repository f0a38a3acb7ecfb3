// SPDX-License-Identifier: Apache-2.0
// The daemon's health as Prometheus reads it (text format 0.0.4). App writes it into
// `metrics_file`.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/messages.hpp"
#include "daemon/record/recorder.hpp"

namespace lcrig {

// Figures from files and from the kernel. Absent: not known.
struct SystemFigures {
  std::optional<double> wal_bytes, database_bytes, disk_free_bytes;
  std::optional<double> steal_s;  // since the computer started, of all processors
};
// A disk may take long to tell: not on the thread that runs the instruments.
SystemFigures read_system_figures(const std::string& database);

struct Metrics {
  DaemonStatus status;
  CommitStats commits;  // of the run that goes on, or of the last one
  Duration worst_lateness{};  // of the event loop, since the daemon started
  std::map<std::string, std::uint64_t> events;  // stored since then, by kind
  SystemFigures system;
};
// How the text begins.
constexpr std::string_view kMetricsBegin = "# HELP lcrig_";
std::string to_text(const Metrics& metrics);

}  // namespace lcrig
