// SPDX-License-Identifier: Apache-2.0
// Stores a run: rows go into a bounded queue, one writer thread commits whatever has arrived. At
// the rates of a rig every reading gets its own commit at once; under a burst commits grow by
// themselves. In virtual time a commit takes what arrived in 50 ms (a rehearsal: 1 s), and time
// stands still until it is done: a slow disk or a busy computer changes nothing.
//
// Another program that holds the database's write lock is waited for, while rows gather in memory.
//
// Faults. A commit that fails is rolled back and its rows stay in memory; the fault is reported
// once, later rows are queued behind. `end_run` frees the reserve file (disk full) or reopens the
// database (I/O error, failed fsync), stores what is in memory, and closes the run. Rows that could
// not be stored, or were more than the queue holds, make the run `fail` and are counted in its
// reason.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "daemon/record/batch.hpp"
#include "daemon/record/database.hpp"
#include "daemon/record/latency.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// The rows that one commit made durable. Only from here on may they be shown or sent to anybody.
struct Committed {
  std::int64_t run = 0;
  std::size_t levels = 0, readings = 0, samples = 0;
  std::size_t measure_readings = 0;  // readings that a `measure` step counted
  std::vector<RunEvent> events;
  std::optional<LcrReading> last_reading;
  std::optional<FrameSample> last_sample;
};

struct CommitStats {
  std::uint64_t commits = 0, rows = 0;
  LatencyHistogram commit;  // BEGIN to the end of COMMIT
  LatencyHistogram queued;  // first row queued to the end of COMMIT
};

// Used from the io_context's thread, which must outlive it. All callbacks run there.
class Recorder final : public RunSink {
 public:
  struct Options {
    explicit Options(std::string database_path) : path(std::move(database_path)) {}
    std::string path;
    std::string vfs;  // of SQLite; empty: the operating system's
    std::size_t max_queued_rows = 200'000;  // about 40 MB
    // Kept for the end of a run on a disk that is full: 5.5 minutes of `finally`, as long as the
    // service may take for it, at 50 Hz, twice over; and what waited until then.
    std::int64_t reserve_bytes = 8 << 20;
    // False, for rehearsals: a commit takes what arrived in 1 s, and only the end of a run waits
    // for the disk. A power cut costs the rehearsal, not the database.
    bool sync_each_commit = true;
    // How long rows wait for another program's lock, and how often that is told meanwhile. A
    // program that is forgotten with an open transaction must not end a run of hours at once; what
    // waits is lost if the power goes.
    Duration lock_patience = std::chrono::seconds(60), lock_attempt = std::chrono::seconds(5);
  };

  // Locks, migrates and opens the database and closes orphaned runs.
  static Result<std::unique_ptr<Recorder>> open(asio::io_context& io, Clock& clock,
                                                Options options);
  ~Recorder() override;  // commits what is queued
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Calls to the owner; each may be empty.
  struct Listener {
    std::function<void(const Committed&)> committed;
    std::function<void(const Error&)> fault;
    // Another program holds the lock of the database, and rows wait. Told after each
    // `lock_attempt`.
    std::function<void(Duration waited, std::size_t rows)> locked;
    // The file was moved, replaced or deleted in the run. Told once for each run, after the commit
    // that noticed it; rows are still written to the file and to its log.
    std::function<void()> moved;
  };
  void set_listener(Listener listener) { listener_ = std::move(listener); }
  const std::vector<std::int64_t>& interrupted_runs() const { return owned_.interrupted; }

  // The run row is committed when it returns the run's number. One run at a time.
  Task<Result<std::int64_t>> begin_run(RunRow row);
  // Everything queued and the run's end are committed when it returns; later rows are not stored.
  // The end as it was stored: `fail`, with the reason, when rows were lost.
  Task<Result<RunEnd>> end_run(ExitStatus status, std::string reason);

  // Rows outside a run are not stored.
  void reading(const LcrReading& reading, const ReadingTag& tag) override;
  void samples(std::span<const FrameSample> samples) override;
  void level(const LoadLevel& level) override;
  void event(const RunEvent& event) override;
  Task<Result<>> flush() override;

  CommitStats stats() const;
  // For the watchdog: commits and attempts at a lock so far; nullopt while nothing waits to be
  // committed.
  std::optional<std::uint64_t> beats() const;
  // The same count, also when nothing waits: for a caller that waits for `end_run`.
  std::uint64_t progress() const;
  const std::string& path() const { return options_.path; }

 private:
  struct Request;
  Recorder(asio::io_context& io, Clock& clock, Options options, OwnedDatabase owned,
           BatchWriter writer);

  // io_context's thread
  template <class Add>
  void push(std::size_t rows, Add add);
  Task<Result<>> submit(std::shared_ptr<Request> request);
  Task<> commit_soon(std::weak_ptr<int> alive);
  // What `read` finds under the mutex.
  template <class Read>
  auto locked(Read read) const {
    const std::lock_guard lock(mutex_);
    return read();
  }
  bool has_fault() const {
    return locked([this] { return fault_.has_value(); });
  }
  void forget_rows();
  template <class Call, class... Args>
  void tell(Call Listener::* call, Args... args);

  // writer thread
  void write_loop();
  bool take(std::vector<std::shared_ptr<Request>>& requests);
  void commit_taken();
  Result<> commit(const Batch& batch, const RunEnd* end);
  Result<> commit_once(const Batch& batch, const RunEnd* end);
  void tell_locked(Duration waited);
  void look_whether_moved();
  void set_fault(Error error);
  void serve(Request& request);
  Result<std::int64_t> begin_in_database(const RunRow& row);
  Result<std::int64_t> insert_claimed(const RunRow& row);
  Result<> end_in_database(RunEnd& end);
  Result<> store_rest(const RunEnd& end);
  Result<> store_all(const RunEnd& end, bool faulted);
  Result<> store_end_alone(RunEnd& end, const Error& why);
  Result<> repair();
  Result<> reopen();
  Result<> sync_commits(bool each);
  Result<> make_reserve() const;
  void free_reserve() const;

  asio::io_context& io_;
  Clock& clock_;
  VirtualClock* virtual_;
  Options options_;
  std::shared_ptr<int> alive_;  // callbacks that are still posted when this is gone do nothing

  // io_context's thread
  Listener listener_;
  Wakeup due_;  // of the next commit in virtual time
  bool is_due_ = false;  // there will be one
  bool accepting_ = false;

  // Under mutex_.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Batch incoming_;
  std::vector<std::shared_ptr<Request>> requests_;
  std::size_t queued_ = 0;  // rows in incoming_ and writing_
  std::size_t lost_ = 0;  // rows beyond the bound, of this run
  std::optional<Error> fault_;
  bool stop_ = false;
  std::uint64_t attempts_ = 0;  // at a lock that another program held
  CommitStats stats_;

  // writer thread
  OwnedDatabase owned_;  // its `interrupted` never changes
  std::optional<BatchWriter> writer_;
  Batch writing_;  // taken from the queue, not committed yet
  std::int64_t run_ = 0;
  bool reopen_first_ = false;  // the last failed commit was an I/O error
  std::optional<MonoTime> locked_since_;  // by another program; nullopt: the last commit was done
  bool moved_ = false;  // the file, in this run
  std::thread thread_;
};

}  // namespace lcrig
