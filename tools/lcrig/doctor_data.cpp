// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/doc_page.hpp"
#include "base/text.hpp"
#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/queue.hpp"
#include "storage/writer_lock.hpp"
#include "tools/lcrig/console.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

namespace fs = std::filesystem;

namespace {

Result<double> size_of(const Database& db) {
  auto pages = db.integer("PRAGMA page_count");
  if (!pages) return fail(pages.error());
  auto bytes = db.integer("PRAGMA page_size");
  if (!bytes) return fail(bytes.error());
  return static_cast<double>(*pages) * static_cast<double>(*bytes);
}

Finding unreadable(const Error& error) {
  return {"database", Health::bad, printable(error.what),
          doc_page("troubleshooting") + ", \"The data\""};
}

// Reading a large file takes minutes, so only small ones are checked.
Finding look_at_pages(const Database& db, double bytes) {
  constexpr double kQuick = 500e6;
  const auto size = fmt::format("{}: {:.1f} MB", printable(db.path()), bytes / 1e6);
  if (bytes > kQuick) {
    return {"database", Health::ok, size + "; too large to check in passing: lcrig backup does"};
  }
  auto words = db.first("PRAGMA quick_check(1)",
                        [](const Statement& row) { return std::string(row.text(0)); });
  if (!words) return unreadable(words.error());
  if (*words && **words == "ok") return {"database", Health::ok, size + ", its pages are sound"};
  return {"database", Health::bad,
          fmt::format("{}: damaged: {}", printable(db.path()), printable(words->value_or(""))),
          "stop lcrigd, and restore a backup: lcrig restore --help"};
}

// "frequency_Hz 1000.0, level_V 1.0"; empty if the object is empty.
std::string listed(const std::string& object) {
  using nlohmann::json;
  const json all = json::parse(object, nullptr, false);
  std::string out;
  if (!all.is_object()) return out;
  for (const auto& [key, value] : all.items()) {
    const auto words = value.is_string()
                           ? value.get<std::string>()
                           : value.dump(-1, ' ', false, json::error_handler_t::replace);
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", key, words);
  }
  return printable(out, kLongestWords);
}

}  // namespace

void look_at_database(const Database& db, Findings& findings) {
  const auto bytes = size_of(db);
  if (!bytes) {
    findings.push_back(unreadable(bytes.error()));
    return;
  }
  findings.push_back(look_at_pages(db, *bytes));
  if (const auto one = require_one_name(db.path()); !one) {
    findings.emplace_back("database", Health::bad, printable(one.error().what, kLongestWords),
                          "remove the other names: lcrigd refuses the file until then; " +
                              doc_page("troubleshooting") + ", \"The data\"");
  }
  const auto last = db.integer("SELECT coalesce(max(id), 0) FROM run");
  if (!last || *last == 0) return;
  const auto chain = verify_chain(db, *last);
  const auto about = fmt::format("run {}", *last);
  if (!chain) {
    findings.push_back(unreadable(chain.error()));
  } else if (chain->intact) {
    findings.emplace_back(about, Health::ok, "the last one is as it was recorded");
  } else {
    findings.emplace_back(about, chain->not_closed ? Health::warn : Health::bad,
                          printable(remark_on(*chain)), fmt::format("lcrig verify {}", *last));
  }
}

// How long the disk will last if the database keeps growing as it has since the first run.
Finding look_at_disk(const Database& db, std::int64_t now_unix_ns) {
  constexpr double kLeast = 200e6, kDaysToAct = 30;
  const std::string mend =
      "free some space; " + doc_page("lab-setup") + ", \"Backup, and room on the disk\"";
  std::error_code unknown;
  const auto folder = fs::absolute(db.path()).parent_path();
  const auto space = fs::space(folder, unknown);
  const auto bytes = size_of(db);
  const auto first = db.integer("SELECT coalesce(min(started_unix_ns), 0) FROM run");
  if (unknown || !bytes || !first) {
    return {"disk", Health::warn, "its free space is not known", "df -h"};
  }
  const auto free_bytes = static_cast<double>(space.available);
  auto words =
      fmt::format("{:.1f} GB are free for {:.3f} GB of database", free_bytes / 1e9, *bytes / 1e9);
  if (free_bytes < kLeast) return {"disk", Health::bad, words, mend};
  const double days = static_cast<double>(now_unix_ns - *first) / static_cast<double>(kDay_ns);
  if (*first == 0 || days < 1) return {"disk", Health::ok, words};
  const double left_days = free_bytes / (*bytes / days);
  constexpr double kMostDays = 3650;
  const double MB = *bytes / days / 1e6;
  words += fmt::format(", which grew by {} a day: room for {}",
                       MB < 0.1 ? fmt::format("{:.3g} kB", MB * 1e3) : fmt::format("{:.1f} MB", MB),
                       left_days > kMostDays ? std::string("more than ten years")
                                             : fmt::format("{:.0f} days", left_days));
  return left_days < kDaysToAct ? Finding("disk", Health::warn, words, mend)
                                : Finding("disk", Health::ok, words);
}

Finding look_at_plans(const Database& db) {
  // A database of an older lcrig has no queue.
  const auto planned = read_if(has_table(db, "queue_entry"), [&db] { return planned_bytes(db); });
  if (!planned) return unreadable(planned.error());
  std::error_code unknown;
  const auto folder = fs::absolute(db.path(), unknown).parent_path();
  const auto space = fs::space(folder, unknown);
  if (unknown) {
    return {"disk for plans", Health::warn, "the free space is not known", "df -h"};
  }
  const double needed = static_cast<double>(*planned) + static_cast<double>(kStaysFree_bytes);
  const auto words = fmt::format(
      "what waits in the queue needs {:.1f} MB, {:.1f} MB have to stay free, {:.1f} MB are free",
      static_cast<double>(*planned) / 1e6, static_cast<double>(kStaysFree_bytes) / 1e6,
      static_cast<double>(space.available) / 1e6);
  if (static_cast<double>(space.available) >= needed) {
    return {"disk for plans", Health::ok, words};
  }
  return {"disk for plans", Health::bad, words,
          "free some space, or take entries out: lcrig queue remove --help; " +
              doc_page("lab-setup") + ", \"Backup, and room on the disk\""};
}

void look_at_meter_settings(const Database& db, Findings& findings) {
  using Last = std::pair<std::int64_t, std::string>;
  const auto last =
      db.first("SELECT id, lcr_settings_json FROM run WHERE simulated = 0 ORDER BY id DESC LIMIT 1",
               [](const Statement& row) { return Last(row.integer(0), row.text(1)); });
  if (!last) {
    findings.push_back(unreadable(last.error()));
    return;
  }
  if (!*last) return;
  const auto& [run, settings] = **last;
  const auto read_back = listed(settings);
  if (read_back.empty()) {
    findings.emplace_back("meter settings", Health::warn,
                          fmt::format("run {} has none that can be read", run),
                          fmt::format("lcrig verify {}", run));
  } else {
    findings.emplace_back("meter settings", Health::ok,
                          fmt::format("read back in run {}: {}", run, read_back));
  }
}

namespace {

// True if the process has a file of this name open that is no longer this file. Also false if the
// open files of the process cannot be seen.
bool has_other_file_open(const Machine& machine, int pid, const std::string& file) {
  bool seen = false;
  std::error_code unknown;
  const auto files = machine.root / "proc" / std::to_string(pid) / "fd";
  for (const auto& open : fs::directory_iterator(files, unknown)) {
    seen = true;
    if (fs::equivalent(open.path(), file, unknown)) return false;
  }
  return seen;
}

}  // namespace

std::optional<Finding> look_whether_replaced(const Machine& machine, const std::string& database) {
  const auto written = has_writer(database);
  if (!written) return std::nullopt;
  const auto pid = writer_of(database);
  if (*written && !(pid && has_other_file_open(machine, *pid, database))) return std::nullopt;
  return Finding("database", Health::bad,
                 fmt::format("{}: lcrigd has another file of this name open, which was moved, "
                             "replaced or deleted, and begins no run",
                             printable(database)),
                 "move that one back, with the files beside it, or go on with what is there now: "
                 "sudo systemctl restart lcrigd");
}

std::optional<int> writer_of(const std::string& database) {
  const auto written = has_writer(database);
  if (!written || !*written) return std::nullopt;
  std::ifstream file(beside_database(database, ".lock"));
  int pid = 0;
  if (!(file >> pid) || pid <= 0) return std::nullopt;
  return pid;
}

}  // namespace lcrig::cli
