// SPDX-License-Identifier: Apache-2.0
// The daemon's health as text for Prometheus (text format 0.0.4). App writes it to `metrics_file`.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/messages.hpp"
#include "daemon/record/recorder.hpp"

namespace lcrig {

// Figures from files and from the kernel. Absent: unknown.
struct SystemFigures {
  std::optional<double> wal_bytes, database_bytes, disk_free_bytes;
  std::optional<double> steal_s;  // over all processors, since the computer was started
};
// A disk may be slow to answer, so do not call it on the thread of the instruments.
SystemFigures read_system_figures(const std::string& database);

struct Metrics {
  DaemonStatus status;
  CommitStats commits;  // of the current run, or of the last one
  Duration worst_lateness{};  // of the event loop, since the daemon started
  std::map<std::string, std::uint64_t> events;  // number stored since then, by kind
  SystemFigures system;
};
// The beginning of the text, which identifies such a file.
constexpr std::string_view kMetricsBegin = "# HELP lcrig_";
std::string to_text(const Metrics& metrics);

}  // namespace lcrig
