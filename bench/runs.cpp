// SPDX-License-Identifier: Apache-2.0
// Processor milliseconds to list 10,000 runs with 700 links each, as many as a static run has, and
// to make the lines of `lcrig runs list --json`. Prints one JSON object. Usage: runs_bench [FOLDER]
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig {
namespace {

constexpr std::int64_t kRuns = 10'000, kLinks = 700;

Result<> add_run(const Database& db, std::int64_t number) {
  RunRow row;
  row.protocol_name = "static-frame";
  row.protocol_text = std::string(4000, 'p');  // as long as a shipped file
  row.specimen_name = fmt::format("paper-{}", number % 37);
  row.specimen_text = std::string(900, 's');
  row.operator_name = "lab";
  row.started_unix_ns = number * 900'000'000'000;
  const auto run = insert_run(db, row);
  if (!run) return fail(run.error());
  auto linked = db.change(
      "WITH RECURSIVE n(seq) AS (VALUES (2) UNION ALL SELECT seq + 1 FROM n WHERE seq < ?2)"
      " INSERT INTO chain SELECT ?1, seq, 0, seq, seq, seq, 0, 0, zeroblob(32) FROM n",
      *run, kLinks - 1);
  if (!linked) return linked;
  RunEnd end;
  end.status = ExitStatus::success;
  end.ended_unix_ns = row.started_unix_ns + 770'000'000'000;
  return insert_run_end(db, *run, end);
}

Result<> fill(const std::string& path) {
  auto db = open_read_write(path);
  if (!db) return fail(db.error());
  if (auto r = db->execute("PRAGMA synchronous = OFF"); !r) return r;
  for (std::int64_t i = 1; i <= kRuns; ++i) {
    if (auto r = add_run(*db, i); !r) return r;
  }
  return {};
}

double milliseconds_of(std::clock_t ticks) {
  return 1e3 * static_cast<double>(ticks) / CLOCKS_PER_SEC;
}

// Times of listing the runs and of making the lines.
Result<std::pair<double, double>> list_once(const std::string& path) {
  const std::clock_t begin = std::clock();
  auto db = open_read_only(path);
  if (!db) return fail(db.error());
  auto runs = list_runs(*db);
  if (!runs) return fail(runs.error());
  const std::clock_t listed = std::clock();
  std::size_t bytes = 0;
  for (const auto& run : *runs) bytes += cli::run_listing_line(run).size();
  if (bytes == 0) return fail(Errc::bug, "no lines");
  return std::pair(milliseconds_of(listed - begin), milliseconds_of(std::clock() - listed));
}

Result<nlohmann::json> measure(const std::string& path) {
  if (auto r = fill(path); !r) return fail(r.error());
  double list_ms = 1e9, lines_ms = 1e9;
  for (int i = 0; i < 5; ++i) {
    auto once = list_once(path);
    if (!once) return fail(once.error());
    list_ms = std::min(list_ms, once->first);
    lines_ms = std::min(lines_ms, once->second);
  }
  return nlohmann::json{{"runs", kRuns},
                        {"links_each", kLinks},
                        {"list_cpu_ms", list_ms},
                        {"json_lines_cpu_ms", lines_ms}};
}

int run(const std::filesystem::path& folder) {
  const auto path = folder / "runs-bench.db";
  const auto figures = measure(path.string());
  for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(path.string() + part);
  if (!figures) {
    std::fprintf(stderr, "%s\n", figures.error().what.c_str());
    return 1;
  }
  std::printf("%s\n", figures->dump().c_str());
  return 0;
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  return lcrig::run(argc > 1 ? argv[1] : ".");
}
