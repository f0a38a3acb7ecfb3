// SPDX-License-Identifier: Apache-2.0
#include "drivers/wire_log_writer.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kPatienceAtTheEnd = 2s;

// 0, or the errno of the failed write.
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

std::string_view what_to_do(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR: return "make the folder, or correct `wire_log_directory` in the config file";
    case EACCES:
    case EPERM:
    case EROFS:
      return "let the user of lcrigd write there (under systemd also ReadWritePaths=), or correct "
             "`wire_log_directory` in the config file";
    case ENOSPC:
    case EDQUOT: return "make room on that disk";
    default: return "look at that disk, or correct `wire_log_directory` in the config file";
  }
}

}  // namespace

// Remembers which troubles were reported, so that the next opened port does not report them again.
// Used by the writer's thread only, except for the flags.
class WireLogWriter::Told {
 public:
  std::atomic<bool> forget = false;
  // Nobody waits for the thread any more. The process may be ending and its journal gone, so
  // nothing is reported.
  std::atomic<bool> left_alone = false;
  void warn(const std::string& path, const std::string& whose, std::string_view what, int error) {
    if (left_alone) return;
    if (forget.exchange(false)) errors_.clear();
    int& last = errors_[whose];
    if (std::exchange(last, error) == error) return;
    spdlog::warn("{}: the wire log cannot be {} ({}); {} goes on without a wire log: {}", path,
                 what, std::generic_category().message(error), whose, what_to_do(error));
  }
  void works(const std::string& whose) { errors_.erase(whose); }

 private:
  std::map<std::string, int> errors_;  // last reported errno of each instrument
};

// Used by the writer's thread only. `path` and `whose` never change.
struct WireLogWriter::Log {
  Log(std::string p, std::string w) : path(std::move(p)), whose(std::move(w)) {}
  ~Log() {
    if (fd >= 0) ::close(fd);
  }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void open(Create create, Told& told) {
    fd = create(path);
    if (fd < 0) told.warn(path, whose, "created", errno);
  }
  // A full disk must not stop an experiment, so the log just ends with a warning.
  void write(std::string_view text, Told& told) {
    if (fd < 0 || text.empty()) return;
    const int error = write_all(fd, text);
    if (error == 0) return told.works(whose);
    told.warn(path, whose, "written any more", error);
    ::close(std::exchange(fd, -1));
  }
  void sync() const {
    if (fd >= 0) ::fsync(fd);
  }

  const std::string path, whose;
  int fd = -1;
};

struct WireLogWriter::Job {
  enum class Kind { open, text, close, sync };
  Kind kind = Kind::text;
  std::shared_ptr<Log> log;  // none for `sync`, which concerns all logs
  std::string text;
};

struct WireLogWriter::Queue {
  explicit Queue(Options o) : options(o) {}

  // False: the queue is full. Only text is ever refused.
  bool push(Job job) {
    {
      const std::lock_guard lock(mutex);
      const std::size_t bytes = job.text.size();
      if (job.kind == Job::Kind::text && waiting_bytes + bytes > options.max_waiting_bytes) {
        return false;
      }
      waiting_bytes += bytes;
      add(std::move(job));
    }
    wake.notify_one();
    return true;
  }
  // Joins texts for the same log, so that a slow disk gets few large writes.
  void add(Job job) {
    const auto same = [&job](const Job& other) {
      return other.kind == Job::Kind::text && other.log == job.log;
    };
    const auto waiting = std::ranges::find_if(jobs, same);
    if (job.kind == Job::Kind::text && waiting != jobs.end()) {
      waiting->text += job.text;
    } else {
      jobs.push_back(std::move(job));
    }
  }
  // Waits for jobs. False: the queue is empty and has been stopped.
  bool take(std::vector<Job>& out) {
    std::unique_lock lock(mutex);
    wake.wait(lock, [this] { return stop || !jobs.empty(); });
    out.swap(jobs);
    working = !out.empty();
    return working;
  }
  void finish(std::size_t bytes) {
    {
      const std::lock_guard lock(mutex);
      waiting_bytes -= bytes;
      working = false;
    }
    idle.notify_all();
  }

  const Options options;
  Told told;
  std::mutex mutex;  // guards all members below; never held while the disk works
  std::condition_variable wake, idle;
  std::vector<Job> jobs;
  std::size_t waiting_bytes = 0;  // in `jobs`, and in the batch being written
  bool working = false, stop = false;
};

int WireLogWriter::create_exclusively(const std::string& path) {
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

WireLogWriter::WireLogWriter(Options options)
    : queue_(std::make_shared<Queue>(options)), thread_([queue = queue_] { work(queue); }) {}

WireLogWriter::~WireLogWriter() {
  const bool all_written = finish(kPatienceAtTheEnd);
  {
    const std::lock_guard lock(queue_->mutex);
    queue_->stop = true;
  }
  queue_->wake.notify_one();
  if (all_written) {
    thread_.join();
    return;
  }
  spdlog::warn("the disk of the wire logs does not answer; their last entries are not stored");
  queue_->told.left_alone = true;
  thread_.detach();
}

std::unique_ptr<WireLogWriter::File> WireLogWriter::create(std::string path, std::string whose) {
  auto log = std::make_shared<Log>(std::move(path), std::move(whose));
  return std::make_unique<File>(queue_, std::move(log));
}

void WireLogWriter::remind() {
  queue_->told.forget = true;
}

bool WireLogWriter::finish(Duration patience) {
  queue_->push(Job{Job::Kind::sync, nullptr, {}});
  std::unique_lock lock(queue_->mutex);
  return queue_->idle.wait_for(lock, patience,
                               [this] { return queue_->jobs.empty() && !queue_->working; });
}

// Performs one job. `open` are the logs that are open.
void WireLogWriter::perform(const Job& job, Queue& queue, std::vector<std::shared_ptr<Log>>& open) {
  if (job.kind == Job::Kind::open) {
    job.log->open(queue.options.create, queue.told);
    open.push_back(job.log);
  }
  if (job.log) job.log->write(job.text, queue.told);
  if (job.kind == Job::Kind::close) {
    job.log->sync();
    std::erase(open, job.log);
  }
  if (job.kind == Job::Kind::sync) {
    for (const auto& log : open) log->sync();
  }
}

// Blocks all signals, which the other threads handle. SIGPIPE is among them, so a log on a pipe
// without a reader gives an ordinary error.
void WireLogWriter::work(const std::shared_ptr<Queue>& queue) {
  sigset_t all;
  sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
  std::vector<std::shared_ptr<Log>> open;
  std::vector<Job> jobs;
  while (queue->take(jobs)) {
    std::size_t bytes = 0;
    for (const Job& job : jobs) {
      perform(job, *queue, open);
      bytes += job.text.size();
    }
    jobs.clear();
    queue->finish(bytes);
  }
}

WireLogWriter::File::File(std::shared_ptr<Queue> queue, std::shared_ptr<Log> log)
    : queue_(std::move(queue)), log_(std::move(log)) {
  queue_->push(Job{Job::Kind::open, log_, {}});
}

WireLogWriter::File::~File() {
  queue_->push(Job{Job::Kind::close, log_, remark()});
  if (all_left_out_ == 0) return;
  spdlog::warn("{}: {} entries of the wire log were left out: the disk was too slow", log_->path,
               all_left_out_);
}

std::string WireLogWriter::File::remark() const {
  if (left_out_ == 0) return {};
  return fmt::format("# {} entries are missing here: the disk was too slow\n", left_out_);
}

void WireLogWriter::File::add(std::string_view text) {
  if (queue_->push(Job{Job::Kind::text, log_, remark().append(text)})) {
    left_out_ = 0;
    return;
  }
  ++left_out_;
  if (all_left_out_++ > 0) return;
  spdlog::warn("{}: the disk is too slow for the wire log; entries are left out", log_->path);
}

}  // namespace lcrig
