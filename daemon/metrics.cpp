// SPDX-License-Identifier: Apache-2.0
#include "daemon/metrics.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string_view>

#include "base/processor_ticks.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

class Page {
 public:
  // Begins a family of metrics; `type` is one of Prometheus's types.
  Page& family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    out_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
    return *this;
  }
  Page& value(double v) { return value("", v); }
  Page& value(std::string_view label, std::string_view text, double v) {
    return value(fmt::format("{{{}=\"{}\"}}", label, escaped(text)), v);
  }
  Page& value(const std::optional<double>& v) { return v ? value(*v) : *this; }
  std::string text() && { return std::move(out_); }

 private:
  Page& value(const std::string& labels, double v) {
    out_ += fmt::format("{}{} {}\n", name_, labels, v);
    return *this;
  }
  static std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
      if (c == '\\' || c == '"') out += '\\';
      if (c == '\n') {
        out += "\\n";
      } else {
        out += c;
      }
    }
    return out;
  }
  std::string out_;
  std::string_view name_;
};

bool is_well(const InstrumentState& i) {
  return i.condition == InstrumentCondition::ready || i.condition == InstrumentCondition::in_use;
}

bool is_ill(const InstrumentState& i) {
  return i.condition == InstrumentCondition::absent || i.condition == InstrumentCondition::fault;
}

void add_rig(Page& page, const DaemonStatus& status) {
  page.family("lcrig_info", "gauge", "The running version; always 1.")
      .value("version", status.version, 1);
  page.family("lcrig_instrument_ready", "gauge", "1: it answered, or a run uses it.");
  for (const auto& i : status.instruments) {
    page.value("instrument", to_string(i.which), is_well(i) ? 1 : 0);
  }
  page.family("lcrig_instrument_missing", "gauge",
              "1: it did not answer, its port is away, or it reports a fault. 0 also: not asked.");
  for (const auto& i : status.instruments) {
    page.value("instrument", to_string(i.which), is_ill(i) ? 1 : 0);
  }
  page.family("lcrig_instrument_data_age_seconds", "gauge",
              "Since it was asked or sent data; absent: never.");
  for (const auto& i : status.instruments) {
    if (i.age_s) page.value("instrument", to_string(i.which), *i.age_s);
  }
}

void add_run(Page& page, const DaemonStatus& status) {
  page.family("lcrig_run_active", "gauge", "1: a run goes on.").value(status.run ? 1 : 0);
  if (status.run) {
    const auto& run = *status.run;
    page.family("lcrig_run_number", "gauge", "The run that goes on.")
        .value(static_cast<double>(run.run));
    page.family("lcrig_run_lcr_readings_total", "counter", "Stored readings of this run.")
        .value(static_cast<double>(run.lcr_readings + run.unproven_readings));
    page.family("lcrig_run_frame_samples_total", "counter", "Stored samples of this run.")
        .value(static_cast<double>(run.frame_samples));
  }
  if (!status.queue) return;
  page.family("lcrig_queue_entries", "gauge", "Runs that wait.")
      .value(static_cast<double>(status.queue->count));
  page.family("lcrig_queue_going", "gauge", "1: it begins runs by itself.")
      .value(status.queue->going ? 1 : 0);
}

void add_daemon(Page& page, const Metrics& m) {
  page.family("lcrig_events_total", "counter",
              "Stored events by kind (retry, late, loss, ...; docs/events.md).");
  for (const auto& [kind, count] : m.events) page.value("kind", kind, static_cast<double>(count));
  page.family("lcrig_commit_seconds", "summary", "Of the last run: a row queued to its commit.");
  for (const double quantile : {0.5, 0.99, 1.0}) {
    page.value("quantile", fmt::format("{}", quantile),
               to_seconds(m.commits.queued.percentile(quantile)));
  }
  page.family("lcrig_control_socket", "gauge", "1: clients find the daemon's socket.")
      .value(m.status.socket_trouble.empty() ? 1 : 0);
  page.family("lcrig_loop_lateness_seconds_max", "gauge",
              "The latest that the event loop ever was since the daemon started.")
      .value(to_seconds(m.worst_lateness));
}

void add_system(Page& page, const SystemFigures& s) {
  page.family("lcrig_wal_bytes", "gauge", "Size of the database's log.").value(s.wal_bytes);
  page.family("lcrig_database_bytes", "gauge", "Size of the database.").value(s.database_bytes);
  page.family("lcrig_disk_free_bytes", "gauge", "Free on its disk.").value(s.disk_free_bytes);
  page.family("lcrig_steal_seconds_total", "counter",
              "Taken away by the host of a virtual machine, all processors.")
      .value(s.steal_s);
}

std::optional<double> size_of(const std::string& file) {
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(file, unknown);
  if (unknown) return std::nullopt;
  return static_cast<double>(bytes);
}

}  // namespace

SystemFigures read_system_figures(const std::string& database) {
  SystemFigures out;
  out.database_bytes = size_of(database);
  out.wal_bytes = size_of(beside_database(database, "-wal"));
  std::error_code unknown;
  const auto folder = std::filesystem::absolute(database, unknown).parent_path();
  const auto space = std::filesystem::space(folder, unknown);
  if (!unknown) out.disk_free_bytes = static_cast<double>(space.available);
  if (const auto ticks = read_processor_ticks("/proc/stat")) {
    out.steal_s = ticks->steal / static_cast<double>(::sysconf(_SC_CLK_TCK));
  }
  return out;
}

std::string to_text(const Metrics& metrics) {
  Page page;
  add_rig(page, metrics.status);
  add_run(page, metrics.status);
  add_daemon(page, metrics);
  add_system(page, metrics.system);
  return std::move(page).text();
}

}  // namespace lcrig
