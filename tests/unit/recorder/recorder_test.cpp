// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "storage/faulty_disk.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

LcrReading reading_at(std::int64_t ms, double farads) {
  LcrReading r;
  r.primary = farads;
  r.secondary = 0.004;
  r.asked = MonoTime(ms * 1ms);
  r.first_byte = r.asked + 60ms;
  r.last_byte = r.asked + 61ms;
  return r;
}

RunRow some_run() {
  RunRow row;
  row.protocol_name = "static-frame";
  row.protocol_text = "{}";
  row.specimen_name = "paper-2";
  row.probe_diameter_m = 0.004;
  row.simulated = true;
  row.started_unix_ns = 1;
  return row;
}

class RecorderTest : public testing::Test {
 protected:
  void open(Recorder::Options options) {
    auto r = Recorder::open(io_, clock_, std::move(options));
    ASSERT_TRUE(r) << r.error().what;
    recorder_ = std::move(*r);
    listener_.committed = [this](const Committed& c) { acknowledged_ += c.readings.size(); };
    listener_.fault = [this](const Error& e) { faults_.push_back(e.what); };
    recorder_->set_listener(listener_);
  }
  void open() { open(Recorder::Options(path_)); }
  std::int64_t begin() {
    auto run = run_task(io_, clock_, recorder_->begin_run(some_run()));
    EXPECT_TRUE(run) << run.error().what;
    return run.value_or(0);
  }
  void end(ExitStatus status, const std::string& reason) {
    auto r = run_task(io_, clock_, recorder_->end_run(status, reason));
    EXPECT_TRUE(r) << r.error().what;
  }
  void push_readings(int count) {
    for (int i = 0; i < count; ++i) recorder_->reading(reading_at(i, 1e-12), ReadingTag());
  }
  std::int64_t integer(const std::string& sql, const std::string& vfs = "") {
    auto db = open_read_only(path_, vfs);
    EXPECT_TRUE(db) << db.error().what;
    auto r = db->integer(sql);
    EXPECT_TRUE(r) << r.error().what;
    return r.value_or(-1);
  }
  RunListing listing(std::int64_t run) {
    auto db = open_read_only(path_);
    EXPECT_TRUE(db);
    auto r = get_run_listing(*db, run);
    EXPECT_TRUE(r) << r.error().what;
    return r.value_or(RunListing());
  }
  ChainReport chain(std::int64_t run) {
    auto db = open_read_only(path_);
    EXPECT_TRUE(db);
    auto r = verify_chain(*db, run);
    EXPECT_TRUE(r) << r.error().what;
    return r.value_or(ChainReport());
  }

  TempDir dir_;
  std::string path_ = dir_.file("a.db");
  VirtualClock clock_;  // outlives what waits in the loop
  asio::io_context io_;
  std::size_t acknowledged_ = 0;
  std::vector<std::string> faults_;
  Recorder::Listener listener_;
  std::unique_ptr<Recorder> recorder_;
};

TEST_F(RecorderTest, StoresEveryKindOfRowAndItsChainHolds) {
  open();
  const auto run = begin();
  LoadLevel level;
  level.level = 1;
  level.target_pressure_Pa = 10e3;
  recorder_->level(level);
  ReadingTag tag;
  tag.level = 1;
  tag.index = 1;
  recorder_->reading(reading_at(5, 1.84249e-12), tag);
  auto overload = reading_at(70, 0);
  overload.primary = std::nullopt;
  overload.flags = lcr_flag::kPrimaryOverload;
  recorder_->reading(overload, ReadingTag());
  FrameSample sample;
  sample.force_N = -0.0;
  recorder_->samples(std::span(&sample, 1));
  recorder_->event(RunEvent(MonoTime(9ms), EventKind::mark, "s", "hello"));
  end(ExitStatus::success, "");
  EXPECT_EQ(integer("SELECT count(*) FROM lcr_reading WHERE capacitance_F = 1.84249e-12 AND"
                    " dissipation = 0.004 AND level = 1 AND reading_index = 1"),
            1);
  EXPECT_EQ(integer("SELECT count(*) FROM lcr_reading WHERE capacitance_F IS NULL AND flags = 1"
                    " AND level IS NULL"),
            1);
  EXPECT_EQ(integer("SELECT count(*) FROM event WHERE kind = 'mark' AND detail = 'hello'"), 1);
  const auto listed = listing(run);
  EXPECT_EQ(listed.exit_status, ExitStatus::success);
  EXPECT_EQ(listed.lcr_readings, 2);
  EXPECT_EQ(listed.frame_samples, 1);
  const auto report = chain(run);
  EXPECT_TRUE(report.intact) << report.finding;
  EXPECT_TRUE(report.ended);
  EXPECT_EQ(report.rows, 7);
  EXPECT_EQ(acknowledged_, 2U);
}

TEST_F(RecorderTest, TheRunRowIsCommittedBeforeBeginReturns) {
  open();
  const auto run = begin();
  EXPECT_EQ(integer(fmt::format("SELECT id FROM run WHERE simulated = 1 AND id = {}", run)), run);
}

TEST_F(RecorderTest, FlushReturnsAfterTheRowsAreOnDiskAndAcknowledged) {
  open();
  begin();
  push_readings(1000);
  ASSERT_TRUE(run_task(io_, clock_, recorder_->flush()));
  EXPECT_EQ(integer("SELECT count(*) FROM lcr_reading"), 1000);
  EXPECT_EQ(acknowledged_, 1000U);
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(RecorderTest, RowsOutsideARunAreNotStored) {
  open();
  push_readings(3);
  begin();
  end(ExitStatus::success, "");
  push_readings(3);
  ASSERT_TRUE(run_task(io_, clock_, recorder_->flush()));
  EXPECT_EQ(integer("SELECT count(*) FROM lcr_reading"), 0);
}

TEST_F(RecorderTest, ASecondWriterIsRefusedWithItsOwner) {
  open();
  auto second = Recorder::open(io_, clock_, Recorder::Options(path_));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy);
  EXPECT_THAT(second.error().what, HasSubstr(std::to_string(::getpid())));
  recorder_.reset();
  EXPECT_TRUE(Recorder::open(io_, clock_, Recorder::Options(path_)));
}

TEST_F(RecorderTest, ADatabaseWithASecondNameIsRefused) {
  open();
  recorder_.reset();
  const std::string other = dir_.file("other.db");
  std::filesystem::create_hard_link(path_, other);
  for (const std::string& name : {path_, other}) {
    const auto refused = Recorder::open(io_, clock_, Recorder::Options(name));
    ASSERT_FALSE(refused) << name;
    EXPECT_THAT(refused.error().what, HasSubstr("2 names (hard links)"));
  }
  std::filesystem::remove(other);
  EXPECT_TRUE(Recorder::open(io_, clock_, Recorder::Options(path_)));
}

TEST_F(RecorderTest, TheReserveIsWrittenThroughNoLink) {
  const std::string reserve = path_ + ".reserve", precious = dir_.file("precious");
  const auto link = [&](bool symbolic) {
    std::filesystem::remove(reserve);
    symbolic ? std::filesystem::create_symlink(precious, reserve)
             : std::filesystem::create_hard_link(precious, reserve);
  };
  std::ofstream(precious) << "precious";
  open();
  for (const bool symbolic : {true, false}) {
    link(symbolic);
    begin();
    EXPECT_EQ(std::filesystem::file_size(precious), 8U) << (symbolic ? "symbolic" : "hard");
    EXPECT_FALSE(std::filesystem::is_symlink(reserve));
    EXPECT_EQ(std::filesystem::file_size(reserve), 8U << 20U);
    end(ExitStatus::success, "");
    EXPECT_EQ(std::filesystem::file_size(precious), 8U) << "its end frees the reserve";
  }
}

TEST_F(RecorderTest, NoRunGoesIntoADatabaseThatWasMovedAway) {
  open();
  begin();
  end(ExitStatus::success, "");
  std::filesystem::rename(path_, dir_.file("elsewhere.db"));
  const auto refused = run_task(io_, clock_, recorder_->begin_run(some_run()));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("restart the daemon"));
}

TEST_F(RecorderTest, AnOrphanedRunIsClosedAsInterruptedAtTheNextOpen) {
  open();
  const auto run = begin();
  push_readings(2);
  recorder_.reset();  // the daemon goes without closing the run
  EXPECT_FALSE(listing(run).exit_status);
  EXPECT_EQ(listing(run).lcr_readings, 2);  // what was queued is stored all the same
  open();
  EXPECT_THAT(recorder_->interrupted_runs(), ElementsAre(run));
  EXPECT_EQ(listing(run).exit_status, ExitStatus::interrupted);
  EXPECT_EQ(get_earlier_anchor(open_read_only(path_).value(), run).value(), std::nullopt);
  EXPECT_TRUE(chain(run).intact) << chain(run).finding;
}

Task<> push_in_virtual_time(Recorder& recorder, Clock& clock, int count) {
  for (int i = 0; i < count; ++i) {
    recorder.reading(reading_at(i, 1e-12), ReadingTag());
    co_await clock.wait_for(1ms);
  }
}

TEST_F(RecorderTest, VirtualTimeWaitsForTheDiskInsteadOfOverflowing) {
  Recorder::Options options(path_);
  options.max_queued_rows = 64;
  open(std::move(options));
  begin();
  bool done = false;
  asio::co_spawn(io_, push_in_virtual_time(*recorder_, clock_, 20'000),
                 [&](std::exception_ptr) { done = true; });
  EXPECT_TRUE(clock_.run(io_, [&] { return done; }));
  end(ExitStatus::success, "");
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_EQ(integer("SELECT count(*) FROM lcr_reading"), 20'000);
}

// For each commit its number of rows, and how many commits there were.
TEST_F(RecorderTest, InVirtualTimeASlowDiskChangesNoCommit) {
  std::vector<std::string> commits;
  for (const Duration delay : {0ms, 3ms}) {
    FaultyDisk disk;
    disk.set_sync_delay(delay);
    path_ = dir_.file(fmt::format("slow-{}.db", delay.count()));
    Recorder::Options options(path_);
    options.vfs = disk.name();
    clock_.run_for(io_, 1s);
    open(std::move(options));
    begin();
    bool done = false;
    asio::co_spawn(io_, push_in_virtual_time(*recorder_, clock_, 2'000),
                   [&](std::exception_ptr) { done = true; });
    EXPECT_TRUE(clock_.run(io_, [&] { return done; }));
    end(ExitStatus::success, "");
    EXPECT_EQ(clock_.pending(), 0U);
    recorder_.reset();
    auto db = open_read_only(path_).value();
    auto s = db.prepare("SELECT group_concat(lcr_reading_seq) FROM chain").value();
    ASSERT_TRUE(s.step().value());
    commits.emplace_back(s.text(0));
  }
  EXPECT_EQ(commits[1], commits[0]);
  EXPECT_THAT(commits[0], HasSubstr("50,100,150,"));
}

TEST_F(RecorderTest, AFullQueueFailsTheRunAndSaysHowMuchIsMissing) {
  Recorder::Options options(path_);
  options.max_queued_rows = 10;
  open(std::move(options));
  const auto run = begin();
  std::vector<FrameSample> burst(11);
  recorder_->samples(burst);  // more than the queue can ever hold
  push_readings(2);
  EXPECT_FALSE(run_task(io_, clock_, recorder_->flush()));
  ASSERT_EQ(faults_.size(), 1U);
  EXPECT_THAT(faults_[0], HasSubstr("too slow"));
  end(ExitStatus::success, "all done");
  EXPECT_EQ(listing(run).exit_status, ExitStatus::fail);
  EXPECT_THAT(listing(run).reason, HasSubstr("11 rows were lost"));
  EXPECT_EQ(listing(run).lcr_readings, 2);
  EXPECT_TRUE(chain(run).intact) << chain(run).finding;
}

// The kernel refuses to let a file grow: EFBIG, which SQLite reports as an I/O error.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit now = before_;
    now.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
};

TEST_F(RecorderTest, AnIoErrorIsReportedOnceAndTheEndStoresWhatWasInMemory) {
  open();
  const auto run = begin();
  {
    const FileSizeLimit limit(std::filesystem::file_size(path_ + "-wal") + 20'000);
    push_readings(1000);
    EXPECT_FALSE(run_task(io_, clock_, recorder_->flush()));
    push_readings(10);
    EXPECT_FALSE(run_task(io_, clock_, recorder_->flush()));
  }
  EXPECT_EQ(faults_.size(), 1U);
  end(ExitStatus::fail, "disk");
  EXPECT_EQ(listing(run).lcr_readings, 1010);
  EXPECT_EQ(listing(run).exit_status, ExitStatus::fail);
  EXPECT_EQ(acknowledged_, 1010U);
  EXPECT_TRUE(chain(run).intact) << chain(run).finding;
  const auto next = begin();  // the recorder is usable again
  push_readings(1);
  end(ExitStatus::success, "");
  EXPECT_EQ(listing(next).lcr_readings, 1);
}

TEST_F(RecorderTest, ARunThatCannotBeClosedIsInterruptedWhenTheDiskIsBack) {
  open();
  const auto run = begin();
  {
    const FileSizeLimit limit(4000);  // less than a page: not even a new log can begin
    push_readings(10);
    EXPECT_FALSE(run_task(io_, clock_, recorder_->end_run(ExitStatus::fail, "disk")));
    EXPECT_FALSE(run_task(io_, clock_, recorder_->begin_run(some_run())));
  }
  const auto next = begin();
  EXPECT_EQ(listing(run).exit_status, ExitStatus::interrupted);
  end(ExitStatus::success, "");
  EXPECT_EQ(listing(next).exit_status, ExitStatus::success);
}

TEST_F(RecorderTest, AFullDiskStillTakesTheEndOfTheRun) {
  const auto disk = dir_.path() / "disk";
  std::filesystem::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=16m") != 0) {
    GTEST_SKIP() << "needs the right to mount a small tmpfs";
  }
  path_ = (disk / "a.db").string();
  open();
  const auto run = begin();
  for (int i = 0; i < 200 && faults_.empty(); ++i) {
    push_readings(1000);
    static_cast<void>(run_task(io_, clock_, recorder_->flush()));
  }
  ASSERT_EQ(faults_.size(), 1U);
  EXPECT_THAT(faults_[0], HasSubstr("free some space"));
  const auto acknowledged_before_end = static_cast<std::int64_t>(acknowledged_);
  end(ExitStatus::fail, "the disk is full");
  EXPECT_EQ(listing(run).exit_status, ExitStatus::fail);
  EXPECT_GE(listing(run).lcr_readings, acknowledged_before_end);
  EXPECT_TRUE(chain(run).intact) << chain(run).finding;
  auto refused = run_task(io_, clock_, recorder_->begin_run(some_run()));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("free some space"));
  recorder_.reset();
  ::umount2(disk.c_str(), MNT_DETACH);
}

TEST(LatencyHistogram, PercentilesAreWithinOneBucket) {
  LatencyHistogram h;
  for (int us = 1; us <= 1000; ++us) h.add(us * 1us);
  EXPECT_NEAR(to_seconds(h.percentile(0.5)), 500e-6, 500e-6 / 16);
  EXPECT_NEAR(to_seconds(h.percentile(0.99)), 990e-6, 990e-6 / 16);
  EXPECT_EQ(h.max(), 1ms);
  EXPECT_EQ(h.percentile(1), 1ms);
  EXPECT_EQ(LatencyHistogram().percentile(0.5), 0ns);
}

TEST_F(RecorderTest, ADatabaseInMemoryIsLockedWrittenAndReadLikeOneOnADisk) {
  Recorder::Options options(path_);
  options.vfs = kInMemory;
  open(options);
  EXPECT_EQ(Recorder::open(io_, clock_, options).error().code, Errc::busy);
  begin();
  for (int i = 1; i <= 100; ++i) {
    push_readings(1);
    ASSERT_TRUE(run_task(io_, clock_, recorder_->flush()));
    ASSERT_EQ(integer("SELECT count(*) FROM lcr_reading", kInMemory), i);
  }
  end(ExitStatus::success, "");
  const auto report = verify_chain(open_read_only(path_, kInMemory).value(), 1);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_TRUE(report->intact) << report->finding;
  EXPECT_TRUE(report->ended);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(RecorderTest, AWriterThatHangsBeatsNoMoreAndARestingOneIsNoHang) {
  open();
  begin();
  EXPECT_FALSE(recorder_->beats()) << "nothing waits to be written";
  auto other = open_read_write(path_);
  ASSERT_TRUE(other);
  ASSERT_TRUE(other->execute("BEGIN IMMEDIATE"));  // the writer waits for it, at most 5 s
  recorder_->reading(reading_at(0, 1e-12), ReadingTag());
  const auto before = recorder_->beats();
  ASSERT_TRUE(before);
  EXPECT_EQ(recorder_->beats(), before);
  ASSERT_TRUE(other->execute("ROLLBACK"));
  end(ExitStatus::success, "");
  EXPECT_FALSE(recorder_->beats());
  EXPECT_EQ(acknowledged_, 1U);
}

TEST_F(RecorderTest, ADatabaseThatIsMovedInTheRunIsToldAndNothingOfItIsLost) {
  open();
  const auto run = begin();
  int told = 0;
  listener_.moved = [&told] { ++told; };
  recorder_->set_listener(listener_);
  const auto store = [this] {
    push_readings(1);
    EXPECT_TRUE(run_task(io_, clock_, recorder_->flush()));
  };
  store();
  EXPECT_EQ(told, 0);
  std::filesystem::rename(path_, path_ + ".moved");
  store();
  store();
  EXPECT_EQ(told, 1);
  const auto ended = run_task(io_, clock_, recorder_->end_run(ExitStatus::success, ""));
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->moved);
  const auto refused = run_task(io_, clock_, recorder_->begin_run(some_run()));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("move it back beside its log (" + path_ + "-wal)"));
  EXPECT_FALSE(open_read_write(path_)) << "it would empty the log";
  std::filesystem::rename(path_ + ".moved", path_);
  EXPECT_EQ(listing(run).lcr_readings, 3);
  EXPECT_TRUE(chain(run).intact) << chain(run).finding;
  begin();
  end(ExitStatus::success, "");
}

class LockedRecorder : public RecorderTest {
 protected:
  void begin_with(Duration patience) {
    Recorder::Options options(path_);
    options.lock_attempt = 20ms;
    options.lock_patience = patience;
    open(options);
    run_ = begin();
    auto other = open_read_write(path_);
    ASSERT_TRUE(other) << other.error().what;
    other_ = std::move(*other);
    ASSERT_TRUE(other_.execute("BEGIN IMMEDIATE"));
  }
  Result<> flush() { return run_task(io_, clock_, recorder_->flush()); }

  Database other_;
  std::int64_t run_ = 0;
};

TEST_F(LockedRecorder, RowsWaitUntilTheOtherProgramLetsGo) {
  begin_with(60s);
  std::vector<std::size_t> waiting;
  listener_.locked = [&](Duration, std::size_t rows) {
    waiting.push_back(rows);
    if (waiting.size() == 3) {
      EXPECT_TRUE(other_.execute("ROLLBACK"));
    }
  };
  recorder_->set_listener(listener_);
  push_readings(7);
  EXPECT_TRUE(flush());
  EXPECT_THAT(waiting, ElementsAre(7U, 7U, 7U));
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_EQ(acknowledged_, 7U);
  end(ExitStatus::success, "");
  EXPECT_EQ(listing(run_).exit_status, ExitStatus::success);
  EXPECT_EQ(listing(run_).lcr_readings, 7);
}

TEST_F(LockedRecorder, ALockThatIsForgottenEndsTheRunAndItsRowsAreStoredWhenItGoes) {
  begin_with(100ms);
  push_readings(7);
  EXPECT_FALSE(flush());
  ASSERT_EQ(faults_.size(), 1U);
  EXPECT_THAT(faults_[0], HasSubstr("another program holds it"));
  push_readings(3);
  ASSERT_TRUE(other_.execute("ROLLBACK"));
  end(ExitStatus::fail, faults_[0]);
  EXPECT_EQ(listing(run_).lcr_readings, 10);
  EXPECT_TRUE(chain(run_).intact) << chain(run_).finding;
}

// The watchdog counts the progress: the end of a run waits for a lock as long as its rows do.
TEST_F(LockedRecorder, TheEndOfARunMovesOnWhileItWaits) {
  begin_with(60s);
  push_readings(7);
  std::vector<std::uint64_t> progress{recorder_->progress()};
  listener_.locked = [&](Duration, std::size_t) {
    progress.push_back(recorder_->progress());
    if (progress.size() == 4) {
      EXPECT_TRUE(other_.execute("ROLLBACK"));
    }
  };
  recorder_->set_listener(listener_);
  end(ExitStatus::success, "");
  ASSERT_GE(progress.size(), 4U);
  for (std::size_t i = 1; i < progress.size(); ++i) EXPECT_GT(progress[i], progress[i - 1]);
  EXPECT_EQ(listing(run_).lcr_readings, 7);
  EXPECT_EQ(listing(run_).exit_status, ExitStatus::success);
}

TEST_F(LockedRecorder, TheTimeOfALockIsCountedFromItsBeginningAlsoAtTheEnd) {
  begin_with(100ms);
  push_readings(7);
  std::vector<Duration> waited;
  listener_.locked = [&](Duration since, std::size_t) { waited.push_back(since); };
  recorder_->set_listener(listener_);
  EXPECT_FALSE(flush());
  const auto in_the_run = waited.size();
  ASSERT_GT(in_the_run, 0U);
  EXPECT_FALSE(run_task(io_, clock_, recorder_->end_run(ExitStatus::fail, "")));
  ASSERT_GT(waited.size(), in_the_run);
  EXPECT_TRUE(std::ranges::is_sorted(waited));
}

TEST_F(LockedRecorder, AnEndThatCannotBeStoredIsToldAndTheNextRunClosesIt) {
  begin_with(100ms);
  push_readings(7);
  const auto ended = run_task(io_, clock_, recorder_->end_run(ExitStatus::success, ""));
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, Errc::busy);
  EXPECT_THAT(ended.error().what, HasSubstr("are not stored"));
  ASSERT_TRUE(other_.execute("ROLLBACK"));
  begin();
  EXPECT_EQ(listing(run_).exit_status, ExitStatus::interrupted);
}

}  // namespace
}  // namespace lcrig
