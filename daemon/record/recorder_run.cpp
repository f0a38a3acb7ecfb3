// SPDX-License-Identifier: Apache-2.0
// The recorder's writer thread: the begin and end of a run, and the repair of faults.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/record/recorder.hpp"

namespace lcrig {

Result<> Recorder::sync_commits(bool each) {
  return owned_.db.execute(each ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
}

Result<std::int64_t> Recorder::begin_in_database(const RunRow& row) {
  if (owned_.db.has_moved()) {
    return fail(Errc::io,
                "{}: this file was moved, replaced or deleted while the daemon has it open, so "
                "nobody would find the run: move it back beside its log ({}), and do not restart "
                "the daemon before",
                options_.path, beside_database(options_.path, "-wal"));
  }
  if (has_fault()) {  // the previous run could not even be closed
    if (auto r = reopen(); !r) return fail(r.error());
    if (auto r = close_orphaned_runs(owned_.db, row.started_unix_ns); !r) return fail(r.error());
  }
  if (auto r = make_reserve(); !r) return fail(r.error());
  if (auto r = owned_.db.execute("PRAGMA wal_autocheckpoint = 1000"); !r) return fail(r.error());
  auto run = insert_claimed(row);
  if (!run) return run;
  run_ = *run;
  moved_ = false;
  locked_since_.reset();
  if (auto r = sync_commits(options_.sync_each_commit); !r) return fail(r.error());
  forget_rows();
  const std::lock_guard lock(mutex_);
  lost_ = 0;
  stats_ = CommitStats();
  return run;
}

void Recorder::forget_rows() {
  writing_.clear();
  const std::lock_guard lock(mutex_);
  incoming_.clear();
  queued_ = 0;
  fault_.reset();
}

// The lock of a run is taken before its row can be seen, and held until the run has ended.
Result<std::int64_t> Recorder::insert_claimed(const RunRow& row) {
  auto run = next_run_number(owned_.db);
  if (!run) return run;
  if (auto claimed = owned_.lock.begin_run(*run); !claimed) return fail(claimed.error());
  run = insert_run(owned_.db, row);
  if (!run) owned_.lock.end_run();
  return run;
}

// Stores the rows that a fault left in memory, then the remaining ones and the end. If that is
// impossible, stores the end alone, which says so. While another program holds the lock, nothing
// can be stored.
Result<> Recorder::end_in_database(RunEnd& end) {
  const bool faulted = has_fault();
  const std::size_t lost = locked([this] { return lost_; });
  if (lost > 0) {
    end.status = ExitStatus::fail;
    end.reason += fmt::format("; {} rows were lost: the disk was too slow", lost);
  }
  Result<> stored = sync_commits(true);
  if (stored) stored = store_all(end, faulted);
  if (!stored && stored.error().code != Errc::busy) stored = store_end_alone(end, stored.error());
  owned_.lock.end_run();
  if (!stored) {
    set_fault(stored.error());
    return fail(stored.error().code, "{}; the last rows of run {} and its end are not stored",
                stored.error().what, run_);
  }
  // An error does not matter: the anchor can be read from the database later.
  if (auto anchor = get_anchor(owned_.db, run_)) end.anchor = *anchor;
  end.moved = owned_.db.has_moved();
  forget_rows();
  return {};
}

// After a first failure repairs and tries once more, except for another program's lock, which has
// been waited for already.
Result<> Recorder::store_all(const RunEnd& end, bool faulted) {
  Result<> stored;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (faulted) stored = repair();
    if (stored) stored = store_rest(end);
    if (stored || faulted || stored.error().code == Errc::busy) break;
    faulted = true;
  }
  return stored;
}

// Stores the batch that failed first by itself, so that it is recognised if its COMMIT had reached
// the disk. Then stores all later rows with the end.
Result<> Recorder::store_rest(const RunEnd& end) {
  if (writing_.rows() > 0) {
    if (auto r = commit(writing_, nullptr); !r) return r;
    writing_.clear();
  }
  {
    const std::lock_guard lock(mutex_);
    std::swap(incoming_, writing_);
  }
  return commit(writing_, &end);
}

Result<> Recorder::store_end_alone(RunEnd& end, const Error& why) {
  if (auto r = repair(); !r) return r;
  const std::size_t unstored = locked([this] { return queued_; });
  end.status = ExitStatus::fail;
  end.reason += fmt::format("; the last {} rows could not be stored: {}", unstored, why.what);
  return commit(Batch(), &end);
}

// On a full disk frees the reserve. After an I/O error opens a new connection, which recovers from
// the log on the disk: after a failed write or fsync the old one's view of the file cannot be
// trusted.
Result<> Recorder::repair() {
  free_reserve();
  if (reopen_first_) {
    reopen_first_ = false;
    if (auto r = reopen(); !r) return r;
  }
  // Prevents a checkpoint, which would use the freed space for the main file. The end goes into the
  // log.
  return owned_.db.execute("PRAGMA wal_autocheckpoint = 0");
}

Result<> Recorder::reopen() {
  std::optional<Sha256> failed;
  if (writer_) failed = writer_->failed_attempt();
  writer_.reset();
  owned_.db = Database();
  auto db = open_read_write(options_.path, options_.vfs);
  if (!db) return fail(db.error());
  if (auto r = wait_for_locks(*db, options_.lock_attempt); !r) return r;
  owned_.db = std::move(*db);
  auto writer = BatchWriter::prepare(owned_.db);
  if (!writer) return fail(writer.error());
  writer_.emplace(std::move(*writer));
  writer_->set_failed_attempt(failed);
  return {};
}

// An existing file of that name is from a run that was cut off, or a link that somebody placed
// there. It is removed, so that nothing is written through a link.
Result<> Recorder::make_reserve() const {
  const std::string file = options_.path + ".reserve";
  free_reserve();
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (fd < 0) return fail(Errc::io, "{}: {}", file, std::strerror(errno));
  const int error = ::posix_fallocate(fd, 0, options_.reserve_bytes);
  ::close(fd);
  if (error == 0) return {};
  free_reserve();
  return fail(Errc::io, "{}: {}: a run needs at least {} free bytes; free some space on this disk",
              file, std::strerror(error), options_.reserve_bytes);
}

void Recorder::free_reserve() const {
  ::unlink((options_.path + ".reserve").c_str());
}

}  // namespace lcrig
