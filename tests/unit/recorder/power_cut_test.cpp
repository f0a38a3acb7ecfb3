// SPDX-License-Identifier: Apache-2.0
// Acknowledged rows survive a power cut at any write. What was not synced may be lost completely or
// in part.
#include <gtest/gtest.h>

#include <random>

#include "daemon/record/batch.hpp"
#include "daemon/record/database.hpp"
#include "storage/chain.hpp"
#include "storage/runs.hpp"
#include "tests/support/power_cut_vfs.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

struct Survived {
  std::int64_t acknowledged = 0, found = 0;
  bool lost_run = false, damaged = false;
  std::string finding;
};

Batch some_rows(std::mt19937_64& random) {
  Batch batch;
  const auto n = 1 + random() % 3;
  for (std::size_t i = 0; i < n; ++i) {
    Batch::TaggedReading row;
    row.reading.primary = 1e-12;
    row.reading.status = std::string(random() % 200, 's');
    batch.readings.push_back(row);
  }
  RunEvent event(MonoTime(), EventKind::mark, "m", "x");
  if (random() % 4 == 0) batch.events.push_back(event);
  return batch;
}

// Records until the power fails. Returns how many readings had been acknowledged by then.
std::int64_t record_until_cut(const std::string& path, support::PowerCutVfs& disk,
                              const char* pragma, std::mt19937_64& random) {
  auto owned = open_as_owner(path, 1);
  if (!owned || !owned->db.execute(pragma)) return -1;
  // Frequent checkpoints, so that many cuts happen during one.
  if (!owned->db.execute("PRAGMA wal_autocheckpoint = 8")) return -1;
  auto run = insert_run(owned->db, RunRow());
  auto writer = BatchWriter::prepare(owned->db);
  if (!run || !writer) return -1;
  std::int64_t acknowledged = 0;
  disk.cut_after(static_cast<int>(1 + random() % 400));
  while (!disk.is_cut()) {
    const Batch batch = some_rows(random);
    if (!writer->write(owned->db, *run, batch, nullptr)) return -1;
    if (!disk.is_cut()) acknowledged += std::ssize(batch.readings);
  }
  return acknowledged;
}

Survived look(const std::string& path) {
  Survived out;
  auto owned = open_as_owner(path, 2);
  if (!owned) {
    out.damaged = true;
    out.finding = owned.error().what;
    return out;
  }
  out.lost_run = owned->interrupted.size() != 1;
  const auto ok = owned->db.integer("SELECT integrity_check = 'ok' FROM pragma_integrity_check");
  out.damaged = !ok || *ok != 1;
  const auto found = owned->db.integer("SELECT count(*) FROM lcr_reading");
  if (found) out.found = *found;
  if (out.lost_run) return out;
  const auto chain = verify_chain(owned->db, 1);
  if (!chain || !chain->intact) out.damaged = true;
  if (chain) out.finding = chain->finding;
  return out;
}

Survived one_cut(std::uint64_t seed, const char* pragma) {
  std::mt19937_64 random(seed);
  const TempDir before, after;
  std::int64_t acknowledged = 0;
  {
    support::PowerCutVfs disk(seed);
    acknowledged = record_until_cut(before.file("a.db"), disk, pragma, random);
    disk.write_survivors(after.path().string());
  }
  Survived out = look(after.file("a.db"));
  out.acknowledged = acknowledged;
  return out;
}

TEST(PowerCut, LosesNoAcknowledgedReadingAndKeepsTheChain) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const Survived s = one_cut(seed, "PRAGMA synchronous = FULL");
    ASSERT_GE(s.acknowledged, 0) << "the recording failed before the cut";
    EXPECT_FALSE(s.damaged) << s.finding;
    EXPECT_FALSE(s.lost_run);
    EXPECT_GE(s.found, s.acknowledged);
  }
}

// The disk of this test really loses what is not synced: with NORMAL the same cuts lose readings.
TEST(PowerCut, TheTestSeesWhatARelaxedDatabaseLoses) {
  int lossy = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Survived s = one_cut(seed, "PRAGMA synchronous = NORMAL");
    if (s.found < s.acknowledged) ++lossy;
  }
  EXPECT_GT(lossy, 5);
}

}  // namespace
}  // namespace lcrig
