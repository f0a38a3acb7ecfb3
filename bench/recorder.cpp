// SPDX-License-Identifier: Apache-2.0
// Compares the recorder's readings per second in a burst, and its latency of single commits, with
// plain SQLite inserts of the same columns. Prints one JSON object. Usage: recorder_bench [FOLDER]
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "daemon/record/recorder.hpp"

namespace lcrig {
namespace {

constexpr int kSingles = 2000;
constexpr int kBatches = 30, kPerBatch = 10'000;  // 100,000 readings/s in batches of 100 ms

template <class T>
T run_task(asio::io_context& io, Task<T> task) {
  std::optional<T> out;
  asio::co_spawn(io, std::move(task), [&](std::exception_ptr, T value) { out = std::move(value); });
  io.restart();
  while (!out && io.run_one() > 0) {
  }
  return std::move(*out);
}

LcrReading some_reading() {
  LcrReading r;
  r.primary = 1.84249e-12;
  r.secondary = 0.00413;
  return r;
}

double seconds_since(MonoTime begin) {
  return to_seconds(RealClock().now() - begin);
}

Result<> raw_inserts(const Database& db, int transactions, int rows, LatencyHistogram& latency) {
  auto s = db.prepare(
      "INSERT INTO raw VALUES (1,?,?,?,?,NULL,'m',1,1,1,1,0,'Cp-D','',?,?,"
      "NULL,NULL,NULL,NULL,NULL)");
  if (!s) return fail(s.error());
  std::int64_t seq = 0;
  for (int t = 0; t < transactions; ++t) {
    const MonoTime begin = RealClock().now();
    auto transaction = Transaction::begin(db);
    if (!transaction) return fail(transaction.error());
    for (int i = 0; i < rows; ++i) {
      s->bind(0, ++seq);
      for (int p = 1; p <= 3; ++p) s->bind(p, seq * 1000);
      s->bind(4, 1.84249e-12);
      s->bind(5, 0.00413);
      if (auto r = s->run(); !r) return r;
    }
    if (auto r = transaction->commit(); !r) return r;
    latency.add(RealClock().now() - begin);
  }
  return db.execute("DELETE FROM raw");
}

Result<> measure(const std::string& folder) {
  const std::string path = folder + "/recorder-bench.db";
  for (const char* end : {"", "-wal", "-shm", ".lock", ".writer"}) {
    std::filesystem::remove(path + end);
  }
  asio::io_context io;
  RealClock clock;
  auto recorder = Recorder::open(io, clock, Recorder::Options(path));
  if (!recorder) return fail(recorder.error());
  auto run = run_task(io, (*recorder)->begin_run(RunRow()));
  if (!run) return fail(run.error());
  ReadingTag tag;
  tag.step_id = "m";
  for (int i = 0; i < kSingles; ++i) {
    (*recorder)->reading(some_reading(), tag);
    if (auto r = run_task(io, (*recorder)->flush()); !r) return r;
  }
  const CommitStats singles = (*recorder)->stats();
  const MonoTime begin = clock.now();
  for (int b = 0; b < kBatches; ++b) {
    for (int i = 0; i < kPerBatch; ++i) (*recorder)->reading(some_reading(), tag);
    if (auto r = run_task(io, (*recorder)->flush()); !r) return r;
  }
  const double burst_s = seconds_since(begin);
  auto ended = run_task(io, (*recorder)->end_run(ExitStatus::success, ""));
  if (!ended) return fail(ended.error());
  recorder->reset();

  auto db = open_read_write(path);
  if (!db) return fail(db.error());
  if (auto r = db->execute("CREATE TABLE raw AS SELECT * FROM lcr_reading LIMIT 0"); !r) return r;
  LatencyHistogram raw, unused;
  if (auto r = raw_inserts(*db, kSingles, 1, raw); !r) return r;
  const MonoTime raw_begin = clock.now();
  if (auto r = raw_inserts(*db, kBatches, kPerBatch, unused); !r) return r;
  const double raw_s = seconds_since(raw_begin);
  const auto ms = [](Duration d) { return to_seconds(d) * 1e3; };
  fmt::print(
      "{{\"burst_rows_per_s\":{:.0f},\"raw_rows_per_s\":{:.0f},\"burst_over_raw\":{:.2f},"
      "\"commit_ms\":{{\"p50\":{:.3f},\"p99\":{:.3f},\"max\":{:.3f}}},"
      "\"queued_to_committed_ms\":{{\"p50\":{:.3f},\"p99\":{:.3f}}},"
      "\"raw_commit_ms\":{{\"p50\":{:.3f},\"p99\":{:.3f},\"max\":{:.3f}}}}}\n",
      kBatches * kPerBatch / burst_s, kBatches * kPerBatch / raw_s, raw_s / burst_s,
      ms(singles.commit.percentile(0.5)), ms(singles.commit.percentile(0.99)),
      ms(singles.commit.max()), ms(singles.queued.percentile(0.5)),
      ms(singles.queued.percentile(0.99)), ms(raw.percentile(0.5)), ms(raw.percentile(0.99)),
      ms(raw.max()));
  return {};
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  auto r = lcrig::measure(argc > 1 ? argv[1] : "/var/tmp");
  if (!r) fmt::print(stderr, "recorder_bench: {}\n", r.error().what);
  return r ? 0 : 1;
}
