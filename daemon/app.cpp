// SPDX-License-Identifier: Apache-2.0
#include "daemon/app.hpp"

#include <spdlog/spdlog.h>
#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "base/aside.hpp"
#include "base/program_version.hpp"
#include "base/text.hpp"
#include "daemon/continuation.hpp"
#include "daemon/left_motion.hpp"
#include "daemon/rig/sim.hpp"
#include "daemon/run_words.hpp"
#include "events/event_words.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "storage/anchor.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kStatusInterval = 100ms;
constexpr Duration kWorldPatience = 3s;  // many bonded layers take minutes
constexpr Duration kStopExtension = 30s;

// Events of a run that the journal shows beside its begin, its end, and instruments that were lost
// (protocols/run/losses.cpp).
bool is_for_journal(EventKind kind) {
  return kind == EventKind::limit || kind == EventKind::stop_failed || kind == EventKind::loaded;
}

}  // namespace

App::App(asio::io_context& io, Clock& clock, Config config, AppParts parts)
    : io_(io),
      clock_(clock),
      config_(std::move(config)),
      load_config_(std::move(parts.load_config)),
      notifier_(std::move(parts.notifier)),
      person_(io.get_executor()),
      sync_each_commit_(parts.sync_each_commit),
      control_options_(std::move(parts.control)),
      vfs_(std::move(parts.vfs)),
      known_(clock),
      rig_(std::move(parts.rig)),
      changed_(clock) {
  const auto executor = io.get_executor();
  if (rig_) {
    // that of a rehearsal or a test
  } else if (config_.bench) {
    rig_ = std::make_unique<SimulatedRig>(executor, clock, *config_.bench, known_, person_);
  } else {
    auto real = std::make_unique<RealRig>(executor, clock, config_, known_, person_);
    real_ = real.get();
    rig_ = std::move(real);
  }
  corrector_ = std::make_unique<Corrector>(executor, clock, *rig_, known_, config_.database, vfs_);
}

App::~App() = default;

Result<> App::open() {
  Recorder::Options options(config_.database);
  options.vfs = vfs_;
  options.sync_each_commit = sync_each_commit_;
  auto recorder = Recorder::open(io_, clock_, std::move(options));
  if (!recorder) return fail(recorder.error());
  recorder_ = std::move(*recorder);
  return {};
}

Result<> App::open_with_queue() {
  if (auto opened = open(); !opened) return opened;
  if (auto ready = open_queue(); !ready) return ready;
  spawn(heartbeat());
  spawn(run_queue());
  return {};
}

Result<> App::start() {
  if (auto opened = open(); !opened) return opened;
  for (const auto& orphan : recorder_->interrupted_runs()) {
    spdlog::warn("{}", orphan_line(orphan, stored_anchor(orphan), had_ended(orphan)));
    frame_to_make_safe_ = frame_to_make_safe_ || (real_ != nullptr && left_commanding(orphan));
  }
  look_for_resumable();
  if (auto ready = open_queue(); !ready) return ready;
  control_ = std::make_unique<ControlServer>(io_.get_executor(), clock_, *this, control_options_);
  if (auto listening = control_->listen(config_.socket); !listening) return listening;
  if (real_ != nullptr) {
    enter(Use::asking);  // no run before the frame was made safe
    spawn(probe());
    spawn(watch_ports());
  }
  spawn(heartbeat());
  spawn(run_queue());
  spawn(write_metrics());
  notifier_.ready();
  notifier_.status("idle");
  spdlog::info("lcrigd {}: database {}, socket {}", program_version(), config_.database,
               config_.socket);
  return {};
}

void App::save_wire_logs() {
  if (real_ != nullptr) real_->finish_wire_logs(2s);
}

// A daemon that cannot tell works all the same; `lcrig resume RUN` looks for itself.
void App::look_for_resumable() {
  auto db = open_read_only(config_.database);
  const RigBefore rig = real_ != nullptr ? RigBefore::still_there : RigBefore::gone;
  auto found = db ? find_resumable(*db, rig) : fail(db.error());
  if (!found) {
    spdlog::warn("which run can be resumed is not known: {}", printable(found.error().what));
    return;
  }
  resumable_ = std::move(*found);
}

void App::enter(Use use) {
  use_ = use;
  if (use == Use::idle) {
    notifier_.status("idle");
    const auto taken = reload_.take_when_idle();
    for (const auto& line : taken) spdlog::info("config: {}", line);
    if (!taken.empty()) config_changed();
  }
  changed_.notify_all();
  if (queue_ && queue_->goes()) queue_->wake();
}

// An exception that leaves a coroutine of ours is a bug: say so and die; the gateway's watchdog and
// the next start make the frame safe.
void App::spawn(Task<> task) {
  asio::co_spawn(io_, std::move(task), [](std::exception_ptr error) {
    if (error) std::rethrow_exception(error);
  });
}

// Longer than any honest wait: the runner wakes four times a second, but closes a run with bounded
// waits (STOP 2 s, a last conversion 5 s, a frame that vanished 5 s); a commit waits 5 s for a
// lock.
constexpr Duration kRunnerPatience = 20s;
constexpr Duration kSamplerPatience = 1s;  // beyond the longest exchange
constexpr Duration kRecorderPatience = 10s;

void App::watch_parts() {
  using Beats = std::optional<std::uint64_t>;
  liveness_.watch("the runner", kRunnerPatience, [this]() -> Beats {
    if (live_run() == nullptr) return std::nullopt;
    return session_->beats();
  });
  liveness_.watch("the sampler", kSamplerPatience, [this]() -> Beats {
    const Run* run = live_run();
    if (run == nullptr) return std::nullopt;
    return run->sampler().overdue(clock_.now());
  });
  liveness_.watch("the recorder", kRecorderPatience, [this] { return recorder_->beats(); });
}

// A part that hangs is told once; the run is stopped while it still can be.
bool App::is_working() {
  auto stuck = liveness_.check(clock_.now());
  if (stuck.empty() == stuck_.empty()) {
    stuck_ = std::move(stuck);
    return stuck_.empty();
  }
  stuck_ = std::move(stuck);
  if (stuck_.empty()) {
    spdlog::info("every part moves again");
    return true;
  }
  spdlog::critical("{}; systemd's watchdog is not fed any more", stuck_.front());
  notifier_.status("stuck: " + stuck_.front());
  if (Run* run = live_run()) {
    run->interrupt(InterruptRequest(Interrupt::fault, Error(Errc::bug, stuck_.front())));
  }
  return false;
}

// Updates the line that `systemctl status` shows. A stop may take as long as `finally` does, while
// all parts move.
void App::tell_service(bool working) {
  if (live_run() != nullptr) notifier_.status(service_line(session_->status()));
  if (rig_->is_reckoning()) notifier_.status("reckons the simulated specimen");
  if (shutting_down_ && session_ && working) notifier_.extend_timeout(kStopExtension);
}

// Status to watchers and systemd, and the watchdog, from the thread that does the work.
Task<> App::heartbeat() {
  watch_parts();
  MonoTime watchdog_due = clock_.now(), second_due = watchdog_due;
  const Duration watchdog = notifier_.watchdog_interval().value_or(1h);
  while (!shutting_down_ || session_) {
    publish();
    const bool working = is_working();
    if (clock_.now() >= second_due) {
      second_due = clock_.now() + 1s;
      tell_service(working);
    }
    if (clock_.now() >= watchdog_due && working) {
      notifier_.watchdog();
      watchdog_due = clock_.now() + watchdog;
    }
    const MonoTime due = clock_.now() + std::min(kStatusInterval, watchdog);
    co_await clock_.wait_until(due);
    if (const auto late = lag_.note(due, clock_.now())) tell_lag(*late);
  }
}

// At most one in ten seconds: a machine that swaps is late all the time.
void App::tell_lag(Duration late) {
  const MonoTime now = clock_.now();
  if (now - lag_told_ < 10s && lag_told_ != MonoTime()) return;
  lag_told_ = now;
  const std::string text = fmt::format("the event loop was {:.0f} ms late", to_seconds(late) * 1e3);
  spdlog::warn("{}", text);
  if (live_run() == nullptr) return;
  recorder_->event(RunEvent(now, EventKind::lag, "", text));
}

std::string App::stored_anchor(std::int64_t run) const {
  const auto db = open_read_only(config_.database);
  if (!db) return {};
  const auto anchor = get_anchor(*db, run);
  return anchor && *anchor ? to_string(**anchor) : std::string();
}

bool App::had_ended(std::int64_t orphan) const {
  const auto db = open_read_only(config_.database);
  if (!db) return false;
  const auto earlier = get_earlier_anchor(*db, orphan);
  return earlier && *earlier;
}

bool App::left_commanding(std::int64_t run) const {
  auto db = open_read_only(config_.database);
  if (!db) return true;
  return commanded_frame(*db, run);
}

bool App::frame_may_be_left() const {
  constexpr Duration kPatience = 1s;  // of a disk
  return real_ != nullptr && may_have_left_motion(config_.database, kPatience);
}

Task<> App::make_frame_safe() {
  spdlog::warn("a run may have been cut off: the frame is stopped before the database is opened");
  frame_was_made_safe_ = co_await real_->make_frame_safe();
  if (frame_was_made_safe_) spdlog::info("the frame confirmed standstill");
}

// Makes the frame safe if a crash left it in the middle of a run; then asks the meter who it is
// whenever nothing runs. The frame is not asked, because other people may be working with it.
Task<> App::probe() {
  const auto is_idle = [this] { return use_ == Use::idle || shutting_down_; };
  bool ready = false;
  // Also when somebody else found it not ready any more.
  const auto is_due = [this, &ready] {
    return shutting_down_ || !known_.is_known(Instrument::lcr) ||
           (ready && !known_.is_ready(Instrument::lcr));
  };
  while (!shutting_down_) {
    enter(Use::asking);
    if (frame_to_make_safe_) {
      const bool safe = frame_was_made_safe_ || co_await real_->make_frame_safe();
      frame_to_make_safe_ = !safe;
      auto interrupted = recorder_->interrupted_runs();
      if (safe) {
        co_await note_runs(std::move(interrupted),
                           "lcrigd was restarted: the frame confirmed standstill");
      }
    }
    co_await real_->ask_meter();
    enter(Use::idle);
    ready = known_.is_ready(Instrument::lcr) && !frame_to_make_safe_;
    const MonoTime next = clock_.now() + (ready ? 60s : 10s);
    co_await changed_.wait(is_due, next);
    co_await changed_.wait(is_idle);
  }
}

// Not in a run, which notices by itself. A look that never ends keeps neither the watchdog from
// being fed nor the daemon from ending.
Task<> App::watch_ports() {
  const auto is_over = [this] { return shutting_down_; };
  while (!shutting_down_) {
    if (live_run() == nullptr) {
      const bool changed = co_await real_->watch_ports();
      if (changed) changed_.notify_all();
    }
    const MonoTime next = clock_.now() + 1s;
    co_await changed_.wait(is_over, next);
  }
}

// Beside the loop: another program may hold the database for seconds.
Task<> App::note_runs(std::vector<std::int64_t> runs, std::string text) {
  if (runs.empty()) co_return;
  for (const std::int64_t run : runs) spdlog::info("run {}: {}", run, text);
  const std::int64_t now = clock_.unix_ns();
  const auto note = [this, &runs, &text, now]() -> Result<> {
    auto db = open_read_write(config_.database);
    if (!db) return fail(db.error());
    Result<> all;
    for (const std::int64_t run : runs) {
      if (auto noted = add_run_note(*db, run, "lcrigd", text, now); !noted) all = noted;
    }
    return all;
  };
  auto noted = co_await run_aside(io_.get_executor(), clock_, note);
  if (!noted) spdlog::warn("{}", printable(noted.error().what));
}

void App::publish() {
  if (!control_ || live_run() == nullptr) return;
  control_->publish_status(session_->status());
}

void App::publish_event(const RunEvent& event) {
  hazards_.take(hazard_of(event.kind));
  ++events_[std::string(to_string(event.kind.kind()))];
  if (!control_) return;
  RunEventNote note;
  note.run = live_run() != nullptr ? live_run()->progress().run : 0;
  if (is_for_journal(event.kind.kind())) {
    spdlog::warn("run {}: {}: {}", note.run, event.kind.word(),
                 printable(event_words(event.detail)));
  }
  note.event = event;
  control_->publish_event(note);
}

Task<> App::run_to_its_end() {
  notifier_.status(service_line(session_->status()));
  const MonoTime begin = clock_.now();
  const RunResult result = co_await session_->execute();
  const RunStatus last = session_->status();
  co_await session_->close();
  RunOutcome ended;
  ended.run = last.run;
  ended.exit_status = result.exit_status;
  ended.reason = result.reason;
  ended.code = result.code;
  ended.stands = result.stands;
  ended.simulated = last.simulated;
  ended.lcr_readings = last.lcr_readings;
  ended.measure_readings = last.measure_readings;
  ended.frame_samples = last.frame_samples;
  ended.duration_s = to_seconds(clock_.now() - begin);
  ended.wall_s = ended.duration_s;
  ended.anchor = session_->anchor();
  publish();
  session_.reset();
  last_run_ = ended;
  enter(Use::idle);
  if (control_) control_->publish_run_ended(ended);
  spdlog::info("{}", ended_line(ended));
}

DaemonStatus App::status() const {
  DaemonStatus s;
  s.version = program_version();
  s.database = config_.database;
  if (live_run() != nullptr) s.run = session_->status();
  s.last_run = last_run_;
  s.resumable = resumable_;
  if (queue_) s.queue = queue_->status();
  std::optional<std::int64_t> run;
  if (s.run) run = s.run->run;
  s.instruments = known_.states(run);
  return s;
}

Task<bool> App::shut_down(std::string why) {
  if (std::exchange(shutting_down_, true)) co_return true;
  changed_.notify_all();
  if (queue_) queue_->end();
  corrector_->give_up();
  notifier_.stopping();
  const auto settled = [this] { return is_settled(); };
  bool done = false;
  do {
    const MonoTime patience = clock_.now() + kWorldPatience;
    done = co_await changed_.wait(settled, patience);
  } while (!done && !rig_->is_reckoning());
  if (Run* run = live_run()) {
    notifier_.extend_timeout(kStopExtension);
    run->interrupt(InterruptRequest(Interrupt::abort, why));
  }
  const auto over = [this] { return session_ == nullptr && (!queue_ || queue_->over()); };
  co_await changed_.wait(over);
  if (control_) co_await control_->close(1s);
  // Waits for the last commit on this thread, which nothing else needs any more. What the recorder
  // reports is reported here.
  recorder_.reset();
  co_return !rig_->is_reckoning();
}

}  // namespace lcrig
