// SPDX-License-Identifier: Apache-2.0
// Stores a run: rows go into a bounded queue, and one writer thread commits whatever has arrived.
// At the rates of a rig every reading gets its own commit at once; in a burst commits become
// larger. In virtual time a commit takes the rows of 50 ms (in a rehearsal: 1 s), and time stands
// still until it is done, so that a slow disk or a busy computer changes nothing. Used by the
// daemon's sessions.
//
// If another program holds the database's write lock, commits wait and rows gather in memory.
//
// Faults. A commit that fails is rolled back, and its rows stay in memory. The fault is reported
// once, and later rows are queued. `end_run` frees the reserve file (disk full) or reopens the
// database (I/O error, failed fsync), stores the rows in memory, and closes the run. If rows could
// not be stored, or did not fit into the queue, the run ends as `fail`, with their number in its
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

struct CommittedReading {
  MonoTime asked;
  std::int64_t level = 0;  // as in ReadingTag
  bool counted = false;  // one of the planned readings of a `measure` step
};

// The rows that one commit made durable. Before that they must not be shown or sent to anybody.
struct Committed {
  std::int64_t run = 0;
  std::size_t levels = 0, samples = 0;
  std::vector<CommittedReading> readings;
  std::vector<RunEvent> events;
  std::optional<LcrReading> last_reading;
  std::optional<FrameSample> last_sample;
};

struct CommitStats {
  std::uint64_t commits = 0, rows = 0;
  LatencyHistogram commit;  // from BEGIN to the end of COMMIT
  LatencyHistogram queued;  // from the first queued row to the end of COMMIT
};

// To be used on the io_context's thread, which must outlive it. All callbacks run there.
class Recorder final : public RunSink {
 public:
  struct Options {
    explicit Options(std::string database_path) : path(std::move(database_path)) {}
    std::string path;
    std::string vfs;  // SQLite's VFS; empty: the operating system's
    std::size_t max_queued_rows = 200'000;  // about 40 MB
    // Reserved for the end of a run on a full disk: twice the rows of 5.5 minutes of `finally` (the
    // longest that the service allows) at 50 Hz, and the rows that waited until then.
    std::int64_t reserve_bytes = 8 << 20;
    // False for rehearsals: a commit takes the rows of 1 s, and only the end of a run waits for the
    // disk. A power cut then loses the rehearsal, but does not damage the database.
    bool sync_each_commit = true;
    // For rehearsals: the true time, which is stored beside that of their own clock.
    const Clock* true_clock = nullptr;
    // How long rows wait for another program's lock, and how often the wait is reported. A program
    // that was forgotten in an open transaction should not end a long run at once. Rows that wait
    // are lost if the power fails.
    Duration lock_patience = std::chrono::seconds(60), lock_attempt = std::chrono::seconds(5);
  };

  // Locks, migrates and opens the database, and closes orphaned runs.
  static Result<std::unique_ptr<Recorder>> open(asio::io_context& io, Clock& clock,
                                                Options options);
  ~Recorder() override;  // commits the queued rows
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Calls to the owner; each may be empty.
  struct Listener {
    std::function<void(const Committed&)> committed;
    std::function<void(const Error&)> fault;
    // Another program holds the lock of the database, and rows wait. Called after each
    // `lock_attempt`.
    std::function<void(Duration waited, std::size_t rows)> locked;
    // The file was moved, replaced or deleted during the run. Called once per run, after the commit
    // that noticed it. Rows are still written to that file and its log.
    std::function<void()> moved;
  };
  void set_listener(Listener listener) { listener_ = std::move(listener); }
  const std::vector<std::int64_t>& interrupted_runs() const { return owned_.interrupted; }

  // Returns the number of the run when its row is committed. One run at a time.
  Task<Result<std::int64_t>> begin_run(RunRow row);
  // Returns when all queued rows and the end of the run are committed; later rows are not stored.
  // The result is the stored end: `fail`, with the reason, when rows were lost.
  Task<Result<RunEnd>> end_run(ExitStatus status, std::string reason);

  // Queue rows. Outside a run they are dropped.
  void reading(const LcrReading& reading, const ReadingTag& tag) override;
  void samples(std::span<const FrameSample> samples) override;
  void level(const LoadLevel& level) override;
  void event(const RunEvent& event) override;
  Task<Result<>> flush() override;

  CommitStats stats() const;
  // For the watchdog: the number of commits and of attempts at a lock; nullopt while nothing waits.
  std::optional<std::uint64_t> beats() const;
  // The same number even when nothing waits, for a caller that waits for `end_run`.
  std::uint64_t progress() const;
  const std::string& path() const { return options_.path; }

 private:
  struct Request;
  Recorder(asio::io_context& io, Clock& clock, Options options, OwnedDatabase owned,
           BatchWriter writer);

  // Called on the io_context's thread.
  template <class Add>
  void push(std::size_t rows, Add add);
  Task<Result<>> submit(std::shared_ptr<Request> request);
  Task<> commit_soon(std::weak_ptr<int> alive);
  // Calls `read` under the mutex and returns its result.
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

  // Called on the writer thread.
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
  std::shared_ptr<int> alive_;  // lets posted callbacks see that this object is gone

  // Used on the io_context's thread.
  Listener listener_;
  Wakeup due_;  // forces the next commit in virtual time
  bool is_due_ = false;  // a commit is scheduled
  bool accepting_ = false;

  // Guarded by mutex_.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Batch incoming_;
  std::vector<std::shared_ptr<Request>> requests_;
  std::size_t queued_ = 0;  // rows in incoming_ and writing_
  std::size_t lost_ = 0;  // rows of this run that did not fit into the queue
  std::optional<Error> fault_;
  bool stop_ = false;
  std::uint64_t attempts_ = 0;  // at a lock that another program held
  CommitStats stats_;

  // Used on the writer thread.
  OwnedDatabase owned_;  // its `interrupted` never changes
  std::optional<BatchWriter> writer_;
  Batch writing_;  // taken from the queue, but not committed
  std::int64_t run_ = 0;
  bool reopen_first_ = false;  // the last failed commit was an I/O error
  std::optional<MonoTime> locked_since_;  // by another program; nullopt: the last commit succeeded
  bool moved_ = false;  // the file was moved during this run
  std::thread thread_;
};

}  // namespace lcrig
