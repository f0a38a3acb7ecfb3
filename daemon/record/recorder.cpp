// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/recorder.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

#include "base/as_result.hpp"

namespace lcrig {

namespace {

// Interval between commits in virtual time. Each commit makes one thread wait for the other.
constexpr Duration kVirtualCommitInterval = std::chrono::milliseconds(50);
constexpr Duration kRehearsalCommitInterval = std::chrono::seconds(1);

}  // namespace

// A request that a coroutine waits for. The writer thread fills in the result and then signals.
struct Recorder::Request {
  enum class Kind { begin, flush, end };
  Request(asio::io_context& io, Kind k) : kind(k), done(io, 1) {}
  Kind kind;
  RunRow row;
  RunEnd end;
  Result<std::int64_t> result = fail(Errc::bug, "recorder: not served");
  asio::experimental::channel<void(boost::system::error_code)> done;
};

Result<std::unique_ptr<Recorder>> Recorder::open(asio::io_context& io, Clock& clock,
                                                 Options options) {
  auto owned = open_as_owner(options.path, clock.unix_ns(), options.vfs);
  if (!owned) return fail(owned.error());
  if (auto r = wait_for_locks(owned->db, options.lock_attempt); !r) return fail(r.error());
  auto writer = BatchWriter::prepare(owned->db);
  if (!writer) return fail(writer.error());
  return std::unique_ptr<Recorder>(
      new Recorder(io, clock, std::move(options), std::move(*owned), std::move(*writer)));
}

Recorder::Recorder(asio::io_context& io, Clock& clock, Options options, OwnedDatabase owned,
                   BatchWriter writer)
    : io_(io),
      clock_(clock),
      virtual_(dynamic_cast<VirtualClock*>(&clock)),
      options_(std::move(options)),
      alive_(std::make_shared<int>(0)),
      owned_(std::move(owned)),
      writer_(std::move(writer)) {
  thread_ = std::thread([this] { write_loop(); });
}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  free_reserve();
}

CommitStats Recorder::stats() const {
  return locked([this] { return stats_; });
}

std::optional<std::uint64_t> Recorder::beats() const {
  const std::lock_guard lock(mutex_);
  if (queued_ == 0 && requests_.empty()) return std::nullopt;
  if (fault_) return std::nullopt;  // reported already; the run ends because of it
  return stats_.commits + attempts_;
}

std::uint64_t Recorder::progress() const {
  return locked([this] { return stats_.commits + attempts_; });
}

// Calls the listener on the io_context's thread, unless the recorder is gone by then.
template <class Call, class... Args>
void Recorder::tell(Call Listener::* call, Args... args) {
  asio::post(io_, [this, alive = std::weak_ptr<int>(alive_), call, ... args = std::move(args)] {
    if (!alive.expired() && listener_.*call) (listener_.*call)(args...);
  });
}

template <class Add>
void Recorder::push(std::size_t rows, Add add) {
  if (!accepting_ || rows == 0) return;
  bool overflow = false;
  std::size_t queued = 0;
  {
    const std::lock_guard lock(mutex_);
    if (queued_ + rows > options_.max_queued_rows) {
      lost_ += rows;
      overflow = !fault_;
    } else {
      if (!incoming_.oldest) incoming_.oldest = RealClock().now();
      add(incoming_);
      queued_ += rows;
    }
    queued = fault_ ? 0 : queued_;
  }
  if (overflow) {
    set_fault(Error(Errc::io, fmt::format("{}: the disk is too slow: {} rows wait to be written; "
                                          "stop other programs that use it, or use another disk",
                                          options_.path, options_.max_queued_rows)));
  }
  if (virtual_ == nullptr) return wake_.notify_one();
  if (queued > 0 && !std::exchange(is_due_, true)) {
    asio::co_spawn(io_, commit_soon(alive_), [](std::exception_ptr bug) {
      if (bug) std::rethrow_exception(bug);
    });
  }
  if (2 * queued > options_.max_queued_rows) due_.notify();
}

// In virtual time only: has the writer thread take the rows, and waits for it.
Task<> Recorder::commit_soon(std::weak_ptr<int> alive) {
  const MonoTime due = clock_.now() + (options_.sync_each_commit ? kVirtualCommitInterval
                                                                 : kRehearsalCommitInterval);
  co_await clock_.wait_until(due, due_);
  if (alive.expired()) co_return;
  is_due_ = false;
  if (!accepting_) co_return;
  const auto committed = co_await flush();
  static_cast<void>(committed);  // a fault reports itself
}

void Recorder::reading(const LcrReading& reading, const ReadingTag& tag) {
  push(1, [&](Batch& b) { b.readings.push_back(Batch::TaggedReading{reading, tag}); });
}
void Recorder::samples(std::span<const FrameSample> rows) {
  push(rows.size(), [&](Batch& b) { b.samples.insert(b.samples.end(), rows.begin(), rows.end()); });
}
void Recorder::level(const LoadLevel& level) {
  push(1, [&](Batch& b) { b.levels.push_back(level); });
}
void Recorder::event(const RunEvent& event) {
  push(1, [&](Batch& b) { b.events.push_back(event); });
}

Task<Result<>> Recorder::submit(std::shared_ptr<Request> request) {
  std::optional<VirtualClock::Hold> hold;
  if (virtual_ != nullptr) hold.emplace(*virtual_);
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back(request);
  }
  wake_.notify_one();
  auto r = co_await request->done.async_receive(kAsResult);
  if (std::get<0>(r)) co_return fail(Errc::aborted, "{}: no longer waited for", options_.path);
  if (!request->result) co_return fail(request->result.error());
  co_return Result<>();
}

Task<Result<std::int64_t>> Recorder::begin_run(RunRow row) {
  if (accepting_) co_return fail(Errc::busy, "{}: another run is going on", options_.path);
  auto request = std::make_shared<Request>(io_, Request::Kind::begin);
  request->row = std::move(row);
  if (options_.true_clock != nullptr) request->row.made_unix_ns = options_.true_clock->unix_ns();
  auto done = co_await submit(request);
  if (!done) co_return fail(done.error());
  accepting_ = true;
  co_return request->result;
}

Task<Result<>> Recorder::flush() {
  auto request = std::make_shared<Request>(io_, Request::Kind::flush);
  co_return co_await submit(request);
}

Task<Result<RunEnd>> Recorder::end_run(ExitStatus status, std::string reason) {
  if (!accepting_) co_return fail(Errc::bug, "{}: no run to end", options_.path);
  accepting_ = false;
  if (is_due_) due_.notify();
  auto request = std::make_shared<Request>(io_, Request::Kind::end);
  request->end.status = status;
  request->end.reason = std::move(reason);
  request->end.ended = clock_.now();
  request->end.ended_unix_ns = clock_.unix_ns();
  auto done = co_await submit(request);
  if (!done) co_return fail(done.error());
  co_return request->end;
}

// The functions from here on run on the writer thread.

void Recorder::write_loop() {
  std::vector<std::shared_ptr<Request>> requests;
  while (take(requests)) {
    if (writing_.rows() > 0) commit_taken();
    for (auto& request : requests) {
      serve(*request);
      asio::post(io_, [request] { request->done.try_send(boost::system::error_code()); });
    }
    requests.clear();
  }
}

// Waits for work and takes all of it. After a fault, rows stay queued for end_run.
bool Recorder::take(std::vector<std::shared_ptr<Request>>& requests) {
  std::unique_lock lock(mutex_);
  const auto rows_ready = [this] { return !fault_ && incoming_.rows() > 0; };
  const auto may_take = [&] { return virtual_ == nullptr && rows_ready(); };
  wake_.wait(lock, [&] { return stop_ || !requests_.empty() || may_take(); });
  if (requests_.empty() && !rows_ready()) return false;
  requests.swap(requests_);
  if (rows_ready()) std::swap(incoming_, writing_);
  return true;
}

void Recorder::commit_taken() {
  if (has_fault()) return;
  if (auto r = commit(writing_, nullptr); !r) {
    set_fault(r.error());
  } else {
    writing_.clear();
  }
}

// Commits, and waits as long as another program holds the lock.
Result<> Recorder::commit(const Batch& batch, const RunEnd* end) {
  const MonoTime begin = RealClock().now();
  while (true) {
    auto r = commit_once(batch, end);
    if (!r && r.error().code == Errc::busy) {
      if (!locked_since_) locked_since_ = begin;
    } else {
      locked_since_.reset();
      return r;
    }
    const MonoTime now = RealClock().now();
    tell_locked(now - *locked_since_);
    if (now - begin >= options_.lock_patience) {
      return fail(Errc::busy, "{}; rows of this run have waited for it for {:.0f} s",
                  r.error().what, to_seconds(now - *locked_since_));
    }
  }
}

void Recorder::tell_locked(Duration waited) {
  const std::size_t rows = locked([this] { return ++attempts_, queued_; });
  tell(&Listener::locked, waited, rows);
}

void Recorder::look_whether_moved() {
  if (moved_ || !owned_.db.has_moved()) return;
  moved_ = true;
  tell(&Listener::moved);
}

Result<> Recorder::commit_once(const Batch& batch, const RunEnd* end) {
  const MonoTime begin = RealClock().now();
  if (auto r = writer_->write(owned_.db, run_, batch, end); !r) {
    reopen_first_ = owned_.db.needs_reopening();
    return r;
  }
  const MonoTime done = RealClock().now();
  Committed summary;
  summary.run = run_;
  summary.levels = batch.levels.size();
  summary.events = batch.events;
  summary.samples = batch.samples.size();
  summary.readings.reserve(batch.readings.size());
  for (const auto& [reading, tag] : batch.readings) {
    summary.readings.push_back({reading.asked, tag.level, tag.index > 0});
  }
  if (!batch.readings.empty()) summary.last_reading = batch.readings.back().reading;
  if (!batch.samples.empty()) summary.last_sample = batch.samples.back();
  {
    const std::lock_guard lock(mutex_);
    queued_ -= batch.rows();
    ++stats_.commits;
    stats_.rows += batch.rows();
    stats_.commit.add(done - begin);
    if (batch.oldest) stats_.queued.add(done - *batch.oldest);
  }
  if (batch.rows() > 0) tell(&Listener::committed, std::move(summary));
  look_whether_moved();
  return {};
}

// Called from either thread. Reports only the first fault.
void Recorder::set_fault(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (fault_) return;
    fault_ = error;
  }
  tell(&Listener::fault, std::move(error));
}

void Recorder::serve(Request& request) {
  switch (request.kind) {
    case Request::Kind::begin: request.result = begin_in_database(request.row); return;
    case Request::Kind::end: {
      auto r = end_in_database(request.end);
      if (r) request.result = run_;
      if (!r) request.result = fail(r.error());
      return;
    }
    case Request::Kind::flush: {
      const std::lock_guard lock(mutex_);
      if (fault_) request.result = fail(*fault_);
      if (!fault_) request.result = run_;
      return;
    }
  }
}

}  // namespace lcrig
