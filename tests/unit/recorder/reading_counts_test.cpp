// SPDX-License-Identifier: Apache-2.0
// Counts of a run while it is recorded. The test draws which readings are unproven and which levels
// are abandoned, and commits rows and events in the order of a run.
#include "daemon/record/reading_counts.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace lcrig {
namespace {

MonoTime at(std::int64_t ns) {
  return MonoTime(Duration(ns));
}

RunEvent read_back(std::int64_t ns, bool equal) {
  ReadBackEvent event;
  event.equal = equal;
  return RunEvent(at(ns), "", event);
}

RunEvent unproven(std::int64_t ns, std::int64_t from, std::int64_t to) {
  UnprovenEvent event;
  event.asked_from_mono_ns = from;
  event.asked_to_mono_ns = to;
  return RunEvent(at(ns), "", event);
}

RunEvent abandoned(std::int64_t ns, std::int64_t level, std::int64_t readings) {
  LevelAbandonedEvent event;
  event.level = level;
  event.readings = readings;
  return RunEvent(at(ns), "", event);
}

// What a run would hand over, commit by commit.
class DrawnRows {
 public:
  explicit DrawnRows(std::uint64_t seed) : random_(seed) {}
  std::int64_t below(std::int64_t n) {
    return std::uniform_int_distribution<std::int64_t>(0, n - 1)(random_);
  }
  // Readings up to the next read-back. Unequal: all of them are unproven, or only the last ones.
  void stretch(bool equal) {
    const std::int64_t level = below(3) == 0 ? 0 : ++levels_, count = 1 + below(12);
    const std::int64_t good = equal || below(2) == 0 ? 0 : below(count);
    std::int64_t from = 0, of_level = 0, proven_of_level = 0;
    for (std::int64_t i = 0; i < count; ++i) {
      const bool bad = !equal && i >= good;
      if (bad && from == 0) from = now_ + 1;
      read(level, bad);
      if (level > 0) ++of_level;
      if (level > 0 && !bad) ++proven_of_level;
      if (below(4) == 0) flush();
    }
    const bool lost = level > 0 && below(4) == 0, first = below(2) == 0;
    if (lost) of_levels -= proven_of_level;
    if (lost && first) next_.events.push_back(abandoned(++now_, level, of_level));
    next_.events.push_back(read_back(++now_, equal));
    ++now_;
    if (!equal) next_.events.push_back(unproven(now_, from, now_));
    if (lost && !first) next_.events.push_back(abandoned(++now_, level, of_level));
    if (!equal) next_.events.emplace_back(at(++now_), EventKind::settings, "", "{}");
    if (below(2) == 0) flush();
  }
  // Readings behind which nothing is read back.
  void tail(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) read(0, true);
    flush();
  }
  void flush() {
    counts.add(next_);
    next_ = Committed();
  }
  ReadingCounts counts;
  std::int64_t proven = 0, bad_readings = 0, of_levels = 0;

 private:
  void read(std::int64_t level, bool bad) {
    next_.readings.push_back({at(++now_), level, level > 0});
    ++(bad ? bad_readings : proven);
    if (level > 0 && !bad) ++of_levels;
  }
  std::mt19937_64 random_;
  Committed next_;
  std::int64_t now_ = 0, levels_ = 0;
};

TEST(ReadingCounts, LeaveOutWhatIsUnprovenOrAbandonedWhateverComesFirst) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    DrawnRows rows(seed);
    for (std::int64_t i = rows.below(12); i >= 0; --i) rows.stretch(rows.below(3) > 0);
    rows.tail(rows.below(3) * rows.below(5));
    rows.counts.close();
    ASSERT_EQ(rows.counts.readings(), rows.proven);
    ASSERT_EQ(rows.counts.unproven(), rows.bad_readings);
    ASSERT_EQ(rows.counts.of_levels(), rows.of_levels);
  }
}

TEST(ReadingCounts, CountEveryReadingWhereNothingIsReadBack) {
  DrawnRows rows(1);
  rows.tail(7);
  rows.counts.close();
  EXPECT_EQ(rows.counts.readings(), 7);
  EXPECT_EQ(rows.counts.unproven(), 0);
}

}  // namespace
}  // namespace lcrig
