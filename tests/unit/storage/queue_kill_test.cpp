// SPDX-License-Identifier: Apache-2.0
// A process that works with the queue dies at each of its writes to the disk. Whatever it was told
// is stored must be there, and no entry begins a second time without a person's consent. Fifty
// lives by default; for more: LCRIG_KILLS=200 unit_storage_tests --gtest_filter='QueueKills.*'.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <set>

#include "base/number.hpp"
#include "storage/database.hpp"
#include "tests/support/deadly_vfs.hpp"
#include "tests/support/queued_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

// Acknowledgements that the process received before it died, to be checked against the stored rows.
struct Told {
  enum class What : int { added, removed, begun, done, said };
  What what = What::added;
  std::int64_t entry = 0;
};

// Adds, moves, removes and runs entries, as the daemon does.
class Worker {
 public:
  Worker(const std::string& path, std::uint64_t seed, int tell) : random_(seed), tell_(tell) {
    auto db = open_read_write(path);
    if (db) db_ = std::move(*db);
  }
  void work() {
    for (int i = 0; i < 12; ++i) act(random_() % 6);
  }

 private:
  void tell(Told::What what, std::int64_t entry) const {
    Told told;
    told.what = what;
    told.entry = entry;
    [[maybe_unused]] const auto n = ::write(tell_, &told, sizeof told);
  }
  std::int64_t any() {
    const auto order = order_of(db_);
    return order.empty() ? 0 : order[random_() % order.size()];
  }
  void act(std::uint64_t which) {
    if (which <= 1) {
      if (auto entry = add_one(db_, queued("s"))) tell(Told::What::added, *entry);
    } else if (which == 2) {
      QueuePlace place;
      place.where = QueuePlace::Where::first;
      static_cast<void>(move_in_queue(db_, any(), place, by("lab")));
    } else if (which == 3) {
      const auto entry = any();
      if (remove_from_queue(db_, entry, by("lab"))) tell(Told::What::removed, entry);
    } else {
      run_head();
    }
  }
  void run_head() {
    const auto head = queue_head(db_).value();
    if (!head) return;
    if (!get_queue_state(db_)->going) {
      const bool repeats = head->state != EntryState::waiting;
      // A person consents before this is stored.
      if (repeats) tell(Told::What::said, head->entry);
      static_cast<void>(
          start_queue(db_, repeats ? HeadChoice::repeat : HeadChoice::none, by("lab")));
    }
    auto run = begin_entry(db_, head->entry);
    if (!run) return;
    tell(Told::What::begun, head->entry);
    const bool good = random_() % 2 == 0;
    static_cast<void>(close_run(db_, *run, good ? ExitStatus::success : ExitStatus::fail));
    EntryEnd end;
    end.state = good ? EntryState::done : EntryState::failed;
    if (!good) end.hold = HoldCause::failure;
    if (end_queue_entry(db_, head->entry, end, QueueActor()) && good) {
      tell(Told::What::done, head->entry);
    }
  }

  Database db_;
  std::mt19937_64 random_;
  int tell_;
};

int lives_wanted() {
  const char* text = std::getenv("LCRIG_KILLS");
  return number_from<int>(text == nullptr ? "" : text).value_or(50);
}

class QueueKills : public testing::Test {
 protected:
  // One life of a process. False: it reached its end alive.
  bool live(int operations, std::uint64_t seed) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(ends[0]);
      const DeadlyVfs vfs(operations);
      Worker(path(), seed, ends[1]).work();
      ::_exit(0);
    }
    ::close(ends[1]);
    Told told;
    while (::read(ends[0], &told, sizeof told) == static_cast<ssize_t>(sizeof told)) take(told);
    ::close(ends[0]);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    return WEXITSTATUS(status) == DeadlyVfs::kDied;
  }
  void take(const Told& told) {
    switch (told.what) {
      case Told::What::added: added_.insert(told.entry); break;
      case Told::What::removed: removed_.insert(told.entry); break;
      case Told::What::begun: ++begun_[told.entry]; break;
      case Told::What::done: done_.insert(told.entry); break;
      case Told::What::said: ++said_[told.entry]; break;
    }
  }
  // Opens the database as the daemon does when it starts.
  void start_again() {
    auto db = open_read_write(path());
    ASSERT_TRUE(db) << db.error().what;
    ASSERT_TRUE(close_orphaned_runs(*db, 1));
    ASSERT_TRUE(settle_queue(*db, 1));
    EXPECT_FALSE(get_queue_state(*db)->going);
    EXPECT_EQ(db->integer("SELECT count(*) FROM queue_entry WHERE state = 'running'").value(), 0);
    for (const auto entry : added_) {
      const auto stored = get_queue_entry(*db, entry);
      ASSERT_TRUE(stored) << "entry " << entry << " is lost";
      const bool left = removed_.contains(entry) || done_.contains(entry);
      if (left) {
        EXPECT_TRUE(stored->state == EntryState::removed || stored->state == EntryState::done);
      }
      if (stored->state == EntryState::removed) ++removals_;
      EXPECT_GE(stored->attempts, begun_[entry]) << "a run that was begun is lost";
      EXPECT_LE(stored->attempts, 1 + said_[entry]) << "entry " << entry << " began by itself";
      EXPECT_EQ(stored->attempts > 0 && stored->state == EntryState::waiting, false)
          << "it was begun and waits as if it had not been";
    }
    EXPECT_EQ(db->integer("SELECT count(*) FROM run WHERE id NOT IN (SELECT run_id FROM "
                          "queue_attempt)")
                  .value(),
              0)
        << "a run without its entry";
  }
  std::string path() const { return dir_.file("q.db"); }

  TempDir dir_;
  std::set<std::int64_t> added_, removed_, done_;
  std::map<std::int64_t, std::int64_t> begun_, said_;
  int removals_ = 0;
};

TEST_F(QueueKills, AtEveryWriteLoseNoEntryAndBeginNoneTwice) {
  {
    ASSERT_TRUE(open_read_write(path()));
  }  // the schema alone takes many writes
  int deaths = 0;
  const int lives = lives_wanted();
  for (int n = 0; n < lives; ++n) {
    SCOPED_TRACE(n);
    deaths += live(7 * n % 50, static_cast<std::uint64_t>(n)) ? 1 : 0;
    start_again();
    if (HasFatalFailure() || HasNonfatalFailure()) return;
  }
  EXPECT_GT(deaths, lives / 2);
  EXPECT_GT(added_.size(), 10U);
  EXPECT_FALSE(said_.empty()) << "no entry was ever repeated";
  EXPECT_GT(removals_, 0);
  std::printf("%d deaths, %zu entries, %zu of them begun again on a word\n", deaths, added_.size(),
              said_.size());
}

}  // namespace
}  // namespace lcrig
