// SPDX-License-Identifier: Apache-2.0
// A run that somebody cut short or rewrote, in every way that needs only write access to the file.
// Some ways `verify` finds by itself; others it finds only with an anchor that was kept elsewhere.
#include "storage/anchor.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kRun = 1;
constexpr int kBatches = 40;  // each is one link, with an event and two samples
constexpr std::int64_t kLinks = kBatches + 2;  // including those of the run row and of the end

// A power cut need not be survived here.
Database quick(const std::string& path) {
  auto db = open_read_write(path).value();
  EXPECT_TRUE(db.execute("PRAGMA synchronous = OFF"));
  return db;
}

void add_batch(const Database& db, double force_N) {
  auto transaction = Transaction::begin(db).value();
  auto chain = ChainWriter::prepare(db).value();
  auto events = RowWriter::prepare(db, "event").value();
  auto samples = RowWriter::prepare(db, "frame_sample").value();
  auto head = chain.head(kRun).value();
  RowHash hash;
  hash.start(head.hash);
  const auto event = ++head.last_of(RunTable::event);
  events.begin(hash).add(kRun).add(event).add(event).add("mark").add("load").add("here");
  ASSERT_TRUE(events.insert());
  for (int i = 0; i < 2; ++i) {
    const auto seq = ++head.last_of(RunTable::frame_sample);
    samples.begin(hash).add(kRun).add(seq).add(seq * 20).add(seq);
    samples.add(std::optional<double>()).add(force_N).add(0.0).add(std::int64_t{0});
    ASSERT_TRUE(samples.insert());
  }
  ASSERT_TRUE(chain.append(head, hash));
  ASSERT_TRUE(transaction.commit());
}

void end_run(const Database& db) {
  RunEnd end;
  end.status = ExitStatus::interrupted;
  ASSERT_TRUE(insert_run_end(db, kRun, end));
}

void record(const Database& db) {
  ASSERT_EQ(insert_run(db, RunRow()).value_or(0), kRun);
  for (int i = 0; i < kBatches; ++i) add_batch(db, 0.5);
  end_run(db);
}

// Changes the database as somebody would who gets around the triggers.
void tamper(const Database& db, const std::string& sql) {
  const auto triggers =
      db.rows("SELECT name FROM sqlite_schema WHERE type = 'trigger'", [](const Statement& s) {
          return std::string(s.text(0));
        }).value();
  for (const auto& name : triggers) ASSERT_TRUE(db.execute("DROP TRIGGER " + name));
  ASSERT_TRUE(db.execute("PRAGMA foreign_keys = OFF"));
  const auto done = db.execute(sql);
  ASSERT_TRUE(done) << done.error().what;
}

std::string links_after(std::int64_t link) {
  return fmt::format("DELETE FROM chain WHERE seq > {};", link);
}
std::string rows_after(std::int64_t link) {
  return fmt::format(
      "DELETE FROM frame_sample WHERE seq > (SELECT frame_sample_seq FROM chain WHERE seq = {0});"
      "DELETE FROM event WHERE seq > (SELECT event_seq FROM chain WHERE seq = {0});",
      link);
}
const std::string kNoEnd = "DELETE FROM run_end;";
const std::string kNoAnchor = "DELETE FROM run_anchor;";

struct Cut {
  std::string name;
  std::function<void(const Database&)> make;
  bool only_an_anchor_finds_it = false;
};

Cut cut_by(const std::string& name, const std::string& sql) {
  return {name, [sql](const Database& db) { tamper(db, sql); }};
}

// Removes everything after link `kept`, in every combination.
void add_tails(std::int64_t kept, std::vector<Cut>& out) {
  const std::string tail = fmt::format("the last {} links", kLinks - kept);
  const std::string gone = rows_after(kept) + links_after(kept) + kNoEnd;
  out.push_back(cut_by(tail + " with their rows and the end", gone));
  out.push_back(cut_by(tail + ", rows, end and the stored anchor", gone + kNoAnchor));
  out.push_back(cut_by(tail + " but not their rows", links_after(kept) + kNoEnd + kNoAnchor));
  out.push_back(cut_by("the rows of " + tail, rows_after(kept)));
  out.push_back(cut_by("the rows of " + tail + " and the end", rows_after(kept) + kNoEnd));
  out.push_back({tail + ", then closed as after a crash", [gone](const Database& db) {
                   tamper(db, gone);
                   ASSERT_TRUE(close_orphaned_runs(db, 1));
                 }});
  out.push_back({tail + " and the stored anchor, then closed as after a crash",
                 [gone](const Database& db) {
                   tamper(db, gone + kNoAnchor);
                   ASSERT_TRUE(close_orphaned_runs(db, 1));
                 },
                 true});
  out.push_back({tail + " replaced by as many with other values and their hashes",
                 [gone, kept](const Database& db) {
                   tamper(db, gone + kNoAnchor);
                   for (auto i = kept + 1; i < kLinks; ++i) add_batch(db, 0.25);
                   end_run(db);
                 },
                 true});
}

std::vector<Cut> all_cuts() {
  std::vector<Cut> out;
  for (const std::int64_t kept : {kLinks - 2, kLinks - 11, std::int64_t{1}}) add_tails(kept, out);
  for (const auto& [name, sql] : std::vector<std::pair<std::string, std::string>>{
           {"the end alone", kNoEnd},
           {"the end with its link", links_after(kLinks - 1) + kNoEnd},
           {"the end, its link and the stored anchor",
            links_after(kLinks - 1) + kNoEnd + kNoAnchor},
           {"the whole chain", links_after(0)},
           {"the hash of the last link", "UPDATE chain SET sha256 = zeroblob(32) WHERE seq = 42"},
           {"the count of samples in the last link",
            "UPDATE chain SET frame_sample_seq = frame_sample_seq - 1 WHERE seq = 42"},
           {"the stored count", "UPDATE run_anchor SET links = links - 1"},
           {"the stored hash", "UPDATE run_anchor SET sha256 = zeroblob(32)"},
           {"a sample in the middle", "DELETE FROM frame_sample WHERE seq = 33"},
           {"a link in the middle", "DELETE FROM chain WHERE seq = 20"},
           {"a link in the middle with its rows",
            "DELETE FROM chain WHERE seq = 20; DELETE FROM frame_sample WHERE seq IN (37, 38);"
            "DELETE FROM event WHERE seq = 19"},
           {"all events", "DELETE FROM event"},
           {"the last event", "DELETE FROM event WHERE seq = 40"},
           {"the first sample", "DELETE FROM frame_sample WHERE seq = 1"},
           {"a value", "UPDATE frame_sample SET force_N = 0.25 WHERE seq = 80"},
           {"how it ended", "UPDATE run_end SET exit_status = 'success'"},
           {"the reason", "UPDATE run_end SET reason = 'all well'"},
           {"who ran it", "UPDATE run SET operator = 'somebody else'"}}) {
    out.push_back(cut_by(name, sql));
  }
  return out;
}

class Anchors : public testing::Test {
 protected:
  void SetUp() override {
    db_ = quick(path_);
    record(db_);
    anchor_ = get_anchor(db_, kRun).value().value();
  }
  Database reader() { return open_read_only(path_).value(); }
  ChainReport verified(const std::optional<Anchor>& anchor = std::nullopt) {
    return verify_chain(reader(), kRun, anchor).value();
  }

  TempDir dir_;
  std::string path_ = dir_.file("a.db");
  Database db_;
  Anchor anchor_;
};

TEST_F(Anchors, AStoredOneThatWasChangedIsNotCalledACut) {
  tamper(db_, "UPDATE run_anchor SET sha256 = zeroblob(32)");
  const auto report = verify_chain(db_, kRun).value();
  EXPECT_FALSE(report.intact);
  EXPECT_THAT(report.finding,
              HasSubstr("the anchor that was stored at the end of the run is another"));
}

TEST_F(Anchors, EveryCutIsFound) {
  db_ = Database();  // closed: the file alone is the whole database
  int found = 0, found_by_anchor = 0;
  const auto cuts = all_cuts();
  for (const Cut& cut : cuts) {
    SCOPED_TRACE(cut.name);
    const std::string copy = dir_.file("cut.db");
    for (const char* file : {"", "-wal", "-shm"}) std::filesystem::remove(copy + file);
    std::filesystem::copy_file(path_, copy);
    const auto db = quick(copy);
    ASSERT_TRUE(verify_chain(db, kRun, anchor_).value().intact);
    cut.make(db);
    const auto alone = verify_chain(db, kRun).value();
    const auto anchored = verify_chain(db, kRun, anchor_).value();
    EXPECT_EQ(alone.intact, cut.only_an_anchor_finds_it) << alone.finding;
    EXPECT_FALSE(anchored.intact);
    EXPECT_NE(anchored.finding, "");
    found += alone.intact ? 0 : 1;
    found_by_anchor += alone.intact && !anchored.intact ? 1 : 0;
  }
  std::printf("%zu cuts: %d found, %d more with the anchor\n", cuts.size(), found, found_by_anchor);
  EXPECT_EQ(found + found_by_anchor, std::ssize(cuts));
}

TEST_F(Anchors, AreThoseOfTheEndWhateverNotesCameLater) {
  EXPECT_EQ(anchor_.links, kLinks);
  EXPECT_EQ(verified().head, anchor_);
  ASSERT_TRUE(add_run_note(db_, kRun, "ann", "dusty", 5));
  EXPECT_EQ(get_anchor(db_, kRun).value(), anchor_);
  const auto later = verified(anchor_);
  EXPECT_TRUE(later.intact) << later.finding;
  EXPECT_EQ(later.head.links, kLinks + 1);
  tamper(db_, links_after(kLinks) + "DELETE FROM run_note");
  EXPECT_TRUE(verified(anchor_).intact);
  EXPECT_THAT(verified(later.head).finding, HasSubstr("that of 43 links, but there are 42"));
}

// Whatever else was cut away with the end, the anchor that was stored with the end reveals it.
TEST_F(Anchors, TellOfADeletedEndWhenTheRunIsClosedAgain) {
  EXPECT_EQ(get_earlier_anchor(db_, kRun).value(), std::nullopt);
  db_ = Database();
  for (const auto& [name, sql] : std::vector<std::pair<std::string, std::string>>{
           {"the end alone", kNoEnd},
           {"the end and its link", links_after(kLinks - 1) + kNoEnd},
           {"11 links, their rows and the end", rows_after(31) + links_after(31) + kNoEnd}}) {
    SCOPED_TRACE(name);
    const std::string copy = dir_.file("cut.db");
    for (const char* file : {"", "-wal", "-shm"}) std::filesystem::remove(copy + file);
    std::filesystem::copy_file(path_, copy);
    const auto db = quick(copy);
    tamper(db, sql);
    ASSERT_TRUE(close_orphaned_runs(db, 1));
    EXPECT_EQ(get_earlier_anchor(db, kRun).value(), anchor_);
    EXPECT_EQ(get_anchor(db, kRun).value(), anchor_) << "it is kept";
    EXPECT_THAT(get_run_listing(db, kRun).value().reason,
                HasSubstr("had ended with 42 links, and its end was deleted"));
  }
}

TEST_F(Anchors, AreReadAsTheyAreWritten) {
  const std::string text = to_string(anchor_);
  EXPECT_EQ(parse_anchor(text).value(), anchor_);
  const std::string hash = text.substr(3);
  for (const auto& [wrong, why] : std::vector<std::pair<std::string, std::string>>{
           {"", "no colon"},
           {hash, "no colon"},
           {":" + hash, "no number from 1 on"},
           {"0:" + hash, "no number from 1 on"},
           {"-3:" + hash, "no number from 1 on"},
           {"4x:" + hash, "no number from 1 on"},
           {"42:", "0 digits"},
           {"42:" + hash.substr(1), "63 digits"},
           {"42:" + hash + " ", "65 digits"},
           {"42:g" + hash.substr(1), "no hex digit"}}) {
    const auto parsed = parse_anchor(wrong);
    ASSERT_FALSE(parsed) << wrong;
    EXPECT_THAT(parsed.error().what, HasSubstr(why)) << wrong;
    EXPECT_THAT(parsed.error().what, HasSubstr("64 hex digits"));
  }
}

TEST(OldRuns, DoNotMissTheAnchorsThatThereWereNotYet) {
  constexpr int kSchemaBeforeAnchors = 2;
  const TempDir dir;
  Anchor anchor;
  {
    const auto old = support::database_before_uuids(dir.file("a.db"), kSchemaBeforeAnchors);
    anchor.hash = support::end_old_run(old, kRun, support::insert_old_run(old, kRun));
    anchor.links = 2;
    EXPECT_TRUE(verify_chain(old, kRun).value().intact) << verify_chain(old, kRun).value().finding;
  }
  const auto db = open_read_write(dir.file("a.db")).value();
  EXPECT_EQ(get_anchor(db, kRun).value(), std::nullopt);
  ASSERT_TRUE(add_run_note(db, kRun, "ann", "old", 5));
  const auto chain = verify_chain(db, kRun, anchor).value();
  EXPECT_TRUE(chain.intact) << chain.finding;
  EXPECT_EQ(get_anchor(db, kRun).value(), std::nullopt) << "a note is no end";
}

TEST(OpenRuns, AreIntactOnlyWhileTheyAreRecorded) {
  TempDir dir;
  const std::string path = dir.file("a.db");
  const auto db = open_read_write(path).value();
  const auto status = [&] { return std::string(status_of(get_run_listing(db, kRun).value())); };
  ASSERT_TRUE(insert_run(db, RunRow()));
  EXPECT_EQ(status(), "cut off");
  EXPECT_THAT(verify_chain(db, kRun).value().finding, HasSubstr("its end was deleted"));
  {
    auto lock = WriterLock::acquire(path).value();
    EXPECT_TRUE(has_writer(path).value());
    EXPECT_EQ(status(), "cut off") << "a daemon is there, but records nothing";
    ASSERT_TRUE(lock.begin_run(kRun + 1));
    EXPECT_FALSE(verify_chain(db, kRun).value().intact) << "it records another one";
    lock.end_run();
    ASSERT_TRUE(lock.begin_run(kRun));
    const auto report = verify_chain(db, kRun).value();
    EXPECT_TRUE(report.intact) << report.finding;
    EXPECT_TRUE(report.goes_on);
    EXPECT_EQ(status(), "running");
    EXPECT_EQ(status_of(list_runs(db).value().at(0)), "running");
  }
  EXPECT_FALSE(has_writer(path).value()) << "the kernel gave the locks back";
  EXPECT_EQ(status(), "cut off");
  EXPECT_EQ(status_of(list_runs(db).value().at(0)), "cut off");
}

TEST(WriterLocks, AreAskedForWithoutCreatingOrTakingThem) {
  TempDir dir;
  const std::string path = dir.file("a.db");
  EXPECT_FALSE(has_writer(path).value());
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
  const auto lock = WriterLock::acquire(path).value();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(has_writer(path).value());
  EXPECT_FALSE(WriterLock::acquire(path));
  std::filesystem::create_symlink(path, dir.file("link.db"));
  ASSERT_TRUE(open_read_write(path));
  EXPECT_TRUE(has_writer(dir.file("link.db")).value()) << "the same database";
  EXPECT_FALSE(WriterLock::acquire(dir.file("link.db")));
}

// Whoever can read the database can also read FILE.lock, and lock it.
TEST(WriterLocks, AreNotHeldUpByALockOfAReader) {
  const TempDir dir;
  const std::string path = dir.file("a.db");
  struct flock shared{};
  shared.l_type = F_RDLCK;
  const auto read_lock = [&] { return ::open((path + ".lock").c_str(), O_RDONLY | O_CLOEXEC); };
  static_cast<void>(WriterLock::acquire(path).value());
  const int before = read_lock();
  ASSERT_EQ(::fcntl(before, F_OFD_SETLK, &shared), 0);
  EXPECT_FALSE(has_writer(path).value()) << "he only reads";
  auto lock = WriterLock::acquire(path);
  ASSERT_TRUE(lock) << lock.error().what;
  const int after = read_lock();
  EXPECT_NE(::fcntl(after, F_OFD_SETLK, &shared), 0);
  EXPECT_TRUE(lock->begin_run(kRun));
  EXPECT_TRUE(is_being_recorded(path, kRun).value());
  EXPECT_FALSE(is_being_recorded(path, 10 * kRun).value());
  lock->end_run();
  EXPECT_FALSE(is_being_recorded(path, kRun).value());
  ::close(before);
  ::close(after);
}

TEST(WriterLocks, NobodyButTheOwnerCanOpenTheOneThatExcludesOthers) {
  const TempDir dir;
  const std::string path = dir.file("a.db");
  const auto lock = WriterLock::acquire(path).value();
  struct stat file{};
  ASSERT_EQ(::stat((path + ".writer").c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777U, 0600U);
}

}  // namespace
}  // namespace lcrig
