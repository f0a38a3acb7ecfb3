// SPDX-License-Identifier: Apache-2.0
// Milliseconds to queue 1,000 and 10,000 runs, one by one and as one table, and to list them. Only
// the database takes part. Prints one JSON object for each size. Usage: queue_bench [FOLDER]
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "protocols/batch/batch.hpp"
#include "storage/batches.hpp"
#include "storage/database.hpp"

namespace lcrig {
namespace {

double milliseconds_since(MonoTime begin) {
  return to_seconds(RealClock().now() - begin) * 1e3;
}

// Texts as long as those of shipped files.
QueuedRun some_run() {
  QueuedRun out;
  out.protocol_name = "static-frame";
  out.protocol_text = std::string(4000, 'p');
  out.specimen_name = "paper-1";
  out.specimen_text = std::string(900, 's');
  out.parameters_json = R"({"from_kPa":"10"})";
  out.plan_json = R"({"duration_s":770.5,"measure_readings":1680,"bytes":2400000})";
  return out;
}

std::string table_of(std::int64_t rows) {
  std::string out = "specimen,protocol,for_s\n";
  for (std::int64_t i = 0; i < rows; ++i) out += fmt::format("paper-1,static-frame,{}\n", i);
  return out;
}

Result<double> list_all(const Database& db, std::int64_t entries) {
  constexpr std::int64_t kPage = 500;
  const MonoTime begin = RealClock().now();
  for (std::int64_t skip = 0; skip < entries; skip += kPage) {
    auto page = list_queue(db, skip, kPage);
    if (!page) return fail(page.error());
  }
  return milliseconds_since(begin);
}

Result<nlohmann::json> measure(const std::string& path, std::int64_t entries) {
  auto db = open_read_write(path);
  if (!db) return fail(db.error());
  const std::vector<QueuedRun> runs(1, some_run());
  QueueActor who;
  MonoTime begin = RealClock().now();
  for (std::int64_t i = 0; i < entries; ++i) {
    auto added = add_to_queue(*db, runs, QueuePlace(), who);
    if (!added) return fail(added.error());
  }
  const double one_by_one = milliseconds_since(begin);
  auto listed = list_all(*db, entries);
  if (!listed) return fail(listed.error());
  begin = RealClock().now();
  auto table = read_batch_table(table_of(entries), "table.csv");
  if (!table) return fail(table.error());
  const double read = milliseconds_since(begin);
  StoredBatch batch;
  batch.name = "day";
  batch.order = BatchOrder::given;
  const auto run_at = [&runs](std::size_t i) {
    BatchedRun out;
    out.run = &runs.front();
    out.line = static_cast<std::int64_t>(i) + 2;
    return out;
  };
  begin = RealClock().now();
  auto added = add_batch_to_queue(*db, batch, table->text, static_cast<std::size_t>(entries),
                                  run_at, QueuePlace(), who);
  if (!added) return fail(added.error());
  return nlohmann::json{{"entries", entries},
                        {"add_one_by_one_ms", one_by_one},
                        {"list_ms", *listed},
                        {"read_table_ms", read},
                        {"add_table_ms", milliseconds_since(begin)}};
}

int run(const std::filesystem::path& folder) {
  for (const std::int64_t entries : {1000, 10'000}) {
    const auto path = folder / fmt::format("queue-bench-{}.db", entries);
    auto figures = measure(path.string(), entries);
    for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(path.string() + part);
    if (!figures) {
      std::fprintf(stderr, "%s\n", figures.error().what.c_str());
      return 1;
    }
    std::printf("%s\n", figures->dump().c_str());
  }
  return 0;
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  return lcrig::run(argc > 1 ? argv[1] : ".");
}
