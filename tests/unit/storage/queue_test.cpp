// SPDX-License-Identifier: Apache-2.0
#include "storage/queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "storage/database.hpp"
#include "tests/support/queued_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Queue : public testing::Test {
 protected:
  Queue() : db(open_read_write(dir.file("q.db")).value()) {
    EXPECT_TRUE(db.execute("PRAGMA synchronous = OFF"));  // a power cut need not be survived
  }
  std::int64_t add(const std::string& specimen, QueuePlace place = QueuePlace()) {
    auto entry = add_one(db, queued(specimen), place);
    EXPECT_TRUE(entry) << entry.error().what;
    return entry.value_or(0);
  }
  void start(HeadChoice choice = HeadChoice::none) {
    auto started = start_queue(db, choice, by("lab"));
    EXPECT_TRUE(started) << started.error().what;
  }
  EntryState state(std::int64_t entry) { return get_queue_entry(db, entry).value().state; }
  QueueState queue() { return get_queue_state(db).value(); }
  void end(std::int64_t entry, EntryState state, bool goes_on) {
    EntryEnd how;
    how.state = state;
    if (!goes_on) how.hold = HoldCause::failure;
    how.why = goes_on ? "" : "it broke";
    ASSERT_TRUE(end_queue_entry(db, entry, how, QueueActor()));
  }
  static QueuePlace at(QueuePlace::Where where, std::int64_t entry = 0) {
    QueuePlace out;
    out.where = where;
    out.entry = entry;
    return out;
  }

  using Where = QueuePlace::Where;
  TempDir dir;
  Database db;
};

TEST_F(Queue, KeepsTheOrderAndWhatWasAskedForAcrossAReopening) {
  QueuedRun wanted = queued("paper-1");
  wanted.parameters_json = R"({"cycles":"5"})";
  wanted.note = "first of the day";
  const auto a = add_one(db, wanted).value();
  const auto b = add("paper-2");
  db = Database();
  db = open_read_write(dir.file("q.db")).value();
  EXPECT_THAT(order_of(db), ElementsAre(a, b));
  const auto stored = get_queued_run(db, a);
  ASSERT_TRUE(stored) << stored.error().what;
  EXPECT_EQ(stored->protocol_text, wanted.protocol_text);
  EXPECT_EQ(stored->specimen_text, wanted.specimen_text);
  EXPECT_EQ(stored->parameters_json, wanted.parameters_json);
  EXPECT_EQ(stored->note, "first of the day");
  EXPECT_EQ(get_queue_entry(db, a)->added_by, "lab");
}

TEST_F(Queue, StoresATextOnce) {
  const std::vector<QueuedRun> runs(50, queued("paper-1"));
  ASSERT_TRUE(add_to_queue(db, runs, QueuePlace(), by("lab")));
  EXPECT_EQ(db.integer("SELECT count(*) FROM queue_text").value(), 2);
}

TEST_F(Queue, MovesBeforeBehindFirstAndLast) {
  const auto a = add("a"), b = add("b"), c = add("c");
  ASSERT_TRUE(move_in_queue(db, c, at(Where::first), by("lab")));
  EXPECT_THAT(order_of(db), ElementsAre(c, a, b));
  ASSERT_TRUE(move_in_queue(db, a, at(Where::last), by("lab")));
  EXPECT_THAT(order_of(db), ElementsAre(c, b, a));
  ASSERT_TRUE(move_in_queue(db, c, at(Where::before, a), by("lab")));
  EXPECT_THAT(order_of(db), ElementsAre(b, c, a));
  ASSERT_TRUE(move_in_queue(db, a, at(Where::after, b), by("lab")));
  EXPECT_THAT(order_of(db), ElementsAre(b, a, c));
  const auto d = add("d", at(Where::first));
  EXPECT_THAT(order_of(db), ElementsAre(d, b, a, c));
}

// Places are halved until they are numbered anew.
TEST_F(Queue, TakesAnyNumberOfEntriesBetweenTwo) {
  const auto a = add("a"), z = add("z");
  std::vector<std::int64_t> expected{a};
  for (int i = 0; i < 100; ++i) {
    expected.push_back(add("m", at(Where::before, z)));
  }
  expected.push_back(z);
  EXPECT_EQ(order_of(db), expected);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(move_in_queue(db, z, at(Where::after, a), by("lab")));
    ASSERT_TRUE(move_in_queue(db, z, at(Where::last), by("lab")));
  }
  EXPECT_EQ(order_of(db), expected);
}

TEST_F(Queue, NothingComesBeforeAnEntryThatHasBegun) {
  const auto a = add("a"), b = add("b");
  start();
  ASSERT_TRUE(begin_entry(db, a));
  const auto before = move_in_queue(db, b, at(Where::before, a), by("lab"));
  ASSERT_FALSE(before);
  EXPECT_THAT(before.error().what, HasSubstr("entry 1 is running"));
  const auto c = add("c", at(Where::first));
  EXPECT_THAT(order_of(db), ElementsAre(a, c, b));
  EXPECT_FALSE(move_in_queue(db, a, at(Where::last), by("lab")));
  EXPECT_FALSE(remove_from_queue(db, a, by("lab")));
  ASSERT_EQ(clear_queue(db, by("lab")).value(), 2);
  EXPECT_THAT(order_of(db), ElementsAre(a));
}

TEST_F(Queue, WhatIsNotThereIsRefusedInWords) {
  for (const auto& r :
       {move_in_queue(db, 7, QueuePlace(), by("lab")), remove_from_queue(db, 7, by("lab"))}) {
    ASSERT_FALSE(r);
    EXPECT_EQ(r.error().code, Errc::invalid_request);
    EXPECT_THAT(r.error().what, HasSubstr("no entry 7"));
  }
  EXPECT_FALSE(get_queue_entry(db, 7));
  EXPECT_FALSE(add_one(db, queued("a"), at(Where::after, 7)));
  EXPECT_THAT(order_of(db), IsEmpty());
}

TEST_F(Queue, TheDatabaseRefusesToChangeWhatWasAskedFor) {
  const auto a = add("a");
  ASSERT_TRUE(remove_from_queue(db, a, by("lab")));
  EXPECT_FALSE(db.execute("UPDATE queue_entry SET note = 'x'"));
  EXPECT_FALSE(db.execute("UPDATE queue_entry SET state = 'waiting', place = 1"));
  EXPECT_FALSE(db.execute("DELETE FROM queue_entry"));
  EXPECT_FALSE(db.execute("DELETE FROM queue_act"));
  EXPECT_FALSE(db.execute("UPDATE queue_text SET text = 'x'"));
  EXPECT_FALSE(db.execute("DELETE FROM queue_state"));
}

TEST_F(Queue, AnEntryBeginsWithTheRowOfItsRunOrNotAtAll) {
  const auto a = add("a"), b = add("b");
  const auto runs = [this] { return db.integer("SELECT count(*) FROM run").value(); };
  EXPECT_FALSE(begin_entry(db, a)) << "nobody started the queue";
  start();
  EXPECT_FALSE(begin_entry(db, b)) << "it is not its turn";
  ASSERT_TRUE(hold_queue(db, HoldCause::person, "by lab", by("lab")));
  const auto held = begin_entry(db, a);
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().code, Errc::aborted);
  EXPECT_THAT(held.error().what, HasSubstr("by lab"));
  EXPECT_EQ(runs(), 0);
  start();
  const auto run = begin_entry(db, a);
  ASSERT_TRUE(run) << run.error().what;
  EXPECT_EQ(get_queue_entry(db, a)->last_run, *run);
  EXPECT_EQ(state(a), EntryState::running);
  EXPECT_FALSE(begin_entry(db, a)) << "a second time";
  EXPECT_FALSE(begin_entry(db, b)) << "while the first one runs";
  EXPECT_EQ(runs(), 1);
}

TEST_F(Queue, GoesOnToTheNextEntryAndKeepsItsHistory) {
  const auto a = add("a"), b = add("b");
  start();
  const auto run = begin_entry(db, a).value();
  ASSERT_TRUE(close_run(db, run, ExitStatus::success));
  end(a, EntryState::done, true);
  EXPECT_THAT(order_of(db), ElementsAre(b));
  EXPECT_TRUE(queue().going);
  EXPECT_TRUE(begin_entry(db, b));
  std::vector<std::string> acts;
  const auto history = queue_history(db, a, 0, 100).value();
  for (const auto& act : history) acts.push_back(act.act);
  EXPECT_THAT(acts, ElementsAre("end", "begin", "start", "add"));
}

TEST_F(Queue, AFailedHeadNeedsAChoice) {
  const auto a = add("a"), b = add("b");
  start();
  ASSERT_TRUE(close_run(db, begin_entry(db, a).value(), ExitStatus::fail));
  end(a, EntryState::failed, false);
  EXPECT_FALSE(queue().going);
  EXPECT_EQ(queue().held_why, "it broke");
  const auto none = start_queue(db, HeadChoice::none, by("lab"));
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, HasSubstr("--repeat"));
  EXPECT_FALSE(start_queue(db, HeadChoice::resume, by("lab"))) << "it was not interrupted";
  start(HeadChoice::repeat);
  ASSERT_TRUE(close_run(db, begin_entry(db, a).value(), ExitStatus::fail));
  EXPECT_EQ(get_queue_entry(db, a)->attempts, 2);
  end(a, EntryState::failed, false);
  start(HeadChoice::skip);
  EXPECT_EQ(state(a), EntryState::skipped);
  EXPECT_THAT(order_of(db), ElementsAre(b));
  ASSERT_TRUE(hold_queue(db, HoldCause::person, "", by("lab")));
  EXPECT_FALSE(start_queue(db, HeadChoice::repeat, by("lab"))) << "b has not failed";
}

TEST_F(Queue, AfterACrashAnInterruptedEntryStaysAtTheHeadAndNothingGoes) {
  const auto a = add("a");
  add("b");
  start();
  const auto run = begin_entry(db, a, "paper-1").value();
  EXPECT_EQ(queue().on_rig, "paper-1");
  ASSERT_TRUE(close_orphaned_runs(db, 2));
  EXPECT_TRUE(settle_queue(db, 2).value());
  EXPECT_EQ(state(a), EntryState::interrupted);
  EXPECT_FALSE(queue().going);
  EXPECT_EQ(queue().held, HoldCause::restart);
  EXPECT_FALSE(queue().on_rig) << "whoever restarted it may have changed the specimen";
  const auto none = start_queue(db, HeadChoice::none, by("lab"));
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, HasSubstr("--resume"));
  start(HeadChoice::resume);
  EXPECT_EQ(get_queue_entry(db, a)->resumes_run, run);
  // The consent to go on does not outlive a second crash.
  EXPECT_TRUE(settle_queue(db, 3).value());
  EXPECT_EQ(state(a), EntryState::interrupted);
  EXPECT_FALSE(get_queue_entry(db, a)->resumes_run);
}

TEST_F(Queue, ARunThatHadEndedBeforeTheCrashTellsHowItsEntryDid) {
  for (const auto& [status, expected] : {std::pair(ExitStatus::success, EntryState::done),
                                         std::pair(ExitStatus::fail, EntryState::failed),
                                         std::pair(ExitStatus::abort, EntryState::failed)}) {
    const auto a = add("a");
    start();
    ASSERT_TRUE(close_run(db, begin_entry(db, a).value(), status));
    EXPECT_TRUE(settle_queue(db, 2).value());
    EXPECT_EQ(state(a), expected);
    ASSERT_TRUE(clear_queue(db, by("lab")));
  }
  EXPECT_FALSE(settle_queue(db, 3).value()) << "nothing was going";
}

TEST_F(Queue, HoldingKeepsTheFirstReason) {
  add("a");
  start();
  ASSERT_TRUE(hold_queue(db, HoldCause::limit, "too much", QueueActor()));
  ASSERT_TRUE(hold_queue(db, HoldCause::person, "by lab", by("lab")));
  EXPECT_EQ(queue().held, HoldCause::limit);
}

TEST_F(Queue, OfTenThousandEntriesNoneIsLostOrOutOfOrder) {
  const std::vector<QueuedRun> runs(10'000, queued("paper-1"));
  const auto entries = add_to_queue(db, runs, QueuePlace(), by("lab"));
  ASSERT_TRUE(entries) << entries.error().what;
  std::vector<std::int64_t> expected = *entries;
  EXPECT_EQ(order_of(db), expected);
  // Moves the last one to the front, again and again.
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(move_in_queue(db, expected.back(), at(Where::before, expected.front()), by("lab")));
    std::rotate(expected.begin(), expected.end() - 1, expected.end());
  }
  EXPECT_EQ(order_of(db), expected);
  const auto page = list_queue(db, 9'990, 500);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->size(), 10U);
  EXPECT_EQ(page->back().entry, expected.back());
  EXPECT_EQ(clear_queue(db, by("lab")).value(), 10'000);
  EXPECT_EQ(count_queue(db).value(), 0);
}

TEST_F(Queue, IsLockedAndUnlocked) {
  ASSERT_TRUE(lock_queue(db, "overnight series", by("ada", 7)));
  ASSERT_TRUE(queue().lock);
  EXPECT_EQ(queue().lock->user, "ada");
  EXPECT_EQ(queue().lock->uid, 7);
  ASSERT_TRUE(unlock_queue(db, by("ada", 7)));
  EXPECT_FALSE(queue().lock);
}

}  // namespace
}  // namespace lcrig
