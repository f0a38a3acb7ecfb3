// SPDX-License-Identifier: Apache-2.0
#include "daemon/app.hpp"

#include <spdlog/spdlog.h>
#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "base/text.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kStatusInterval = 100ms;
constexpr Duration kTolerableLag = 200ms;
constexpr Duration kWorldPatience = 3s;  // many bonded layers take minutes
constexpr const char* kNotAsked = "not asked: an idle daemon leaves the frame alone";

}  // namespace

App::App(asio::io_context& io, Clock& clock, Config config)
    : io_(io), clock_(clock), config_(std::move(config)), person_(io.get_executor()) {}

App::~App() = default;

Result<> App::start() {
  auto recorder = Recorder::open(io_, clock_, Recorder::Options(config_.database));
  if (!recorder) return fail(recorder.error());
  recorder_ = std::move(*recorder);
  for (const auto& orphan : recorder_->interrupted_runs()) {
    spdlog::warn(
        "run {} had not ended when the last daemon died: closed as interrupted; look whether its "
        "specimen is still loaded (lcrig runs show {})",
        orphan, orphan);
    frame_to_make_safe_ = frame_to_make_safe_ || left_commanding(orphan);
  }
  control_ = std::make_unique<ControlServer>(io_.get_executor(), clock_, *this);
  if (auto listening = control_->listen(config_.socket); !listening) return listening;
  name_instruments();
  frame_to_make_safe_ = frame_to_make_safe_ && !config_.bench;
  preparing_ = !config_.bench;  // no run before the frame was made safe
  spawn(probe());
  spawn(heartbeat());
  notifier_.ready();
  notifier_.status("idle");
  spdlog::info("lcrigd {}: database {}, socket {}", LCRIG_VERSION, config_.database,
               config_.socket);
  return {};
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
    const Run* run = live_run();
    if (run == nullptr) return std::nullopt;
    return run->beats();
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

// Status to watchers and systemd, and the watchdog, from the thread that does the work.
Task<> App::heartbeat() {
  watch_parts();
  LoopLag lag(kTolerableLag);
  MonoTime watchdog_due = clock_.now();
  const Duration watchdog = notifier_.watchdog_interval().value_or(1h);
  while (!shutting_down_ || session_) {
    publish();
    const bool working = is_working();
    if (clock_.now() >= watchdog_due && working) {
      notifier_.watchdog();
      watchdog_due = clock_.now() + watchdog;
    }
    const MonoTime due = clock_.now() + std::min(kStatusInterval, watchdog);
    co_await clock_.wait_until(due);
    if (const auto late = lag.note(due, clock_.now())) tell_lag(*late);
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

// What `status` calls the instruments before they were asked.
void App::name_instruments() {
  meter_state_.name = "lcr";
  frame_state_.name = "frame";
  meter_state_.port = config_.bench ? "sim" : config_.meter_port;
  frame_state_.port = config_.bench ? "sim" : config_.frame_port;
  if (!config_.bench && config_.frame_driver == FrameDriver::dead_weight) {
    frame_state_.port = "dead weights";
  }
  meter_state_.state = config_.bench ? "ready" : "unknown";
  frame_state_.state = config_.bench ? "ready" : kNotAsked;
}

// A protocol that cannot be read any more counts as one that commands.
bool App::left_commanding(std::int64_t run) const {
  auto db = open_read_only(config_.database);
  if (!db) return true;
  const auto row = get_run(*db, run);
  if (!row) return true;
  const auto protocol = parse_protocol(row->protocol_text, row->protocol_name);
  return !protocol || commands_frame(*protocol);
}

// Makes the frame safe if a crash left it in the middle of a run; then asks the meter who it is
// whenever nothing runs. The frame is not asked: it belongs to whoever works with it. An absent
// instrument is a state, not a failure.
Task<> App::probe() {
  if (config_.bench) co_return;
  while (!shutting_down_) {
    preparing_ = true;
    if (frame_to_make_safe_) co_await make_frame_safe();
    co_await probe_meter();
    preparing_ = false;
    const bool ready = meter_state_.state == "ready" && !frame_to_make_safe_;
    const Duration pause = ready ? 60s : 10s;
    co_await clock_.wait_for(pause);
    while (preparing_ || session_) co_await clock_.wait_for(100ms);
  }
}

// A dead daemon may have left it moving: STOP comes first, whatever else is wrong on this rig, and
// also with a gateway that answers no greeting.
Task<> App::make_frame_safe() {
  auto frame = co_await open_real_frame(io_.get_executor(), clock_, config_, person_);
  if (!frame) {
    frame_state_.state = "absent: " + frame.error().what;
    co_return;
  }
  auto stopped = co_await (*frame)->stop();
  auto identity = co_await (*frame)->identify();
  frame_state_.identity = identity ? identity->text : "";
  frame_state_.state = identity ? "ready" : "absent: " + identity.error().what;
  if (identity) stopped = co_await (*frame)->stop();
  if (identity && !stopped) frame_state_.state = "fault: " + stopped.error().what;
  if (stopped) {
    frame_to_make_safe_ = false;
    note_interrupted("lcrigd was restarted: the frame confirmed standstill");
  }
  (*frame)->close();
}

// Nothing at the frame changes by it.
Task<> App::look_at_frame() {
  auto frame = co_await open_real_frame(io_.get_executor(), clock_, config_, person_);
  if (!frame) {
    frame_state_.state = "absent: " + frame.error().what;
    co_return;
  }
  auto identity = co_await (*frame)->observe(0);
  frame_state_.identity = identity ? identity->text : "";
  if (identity) {
    frame_state_.state = "ready";
  } else if (identity.error().code == Errc::unsupported) {
    frame_state_.state = "cannot be asked without commanding it: " + identity.error().what;
  } else {
    frame_state_.state = "absent: " + identity.error().what;
  }
  (*frame)->close();
}

void App::note_interrupted(const std::string& text) {
  if (recorder_->interrupted_runs().empty()) return;
  spdlog::info("{}", text);
  auto db = open_read_write(config_.database);
  if (!db) return spdlog::warn("{}", printable(db.error().what));
  for (const std::int64_t run : recorder_->interrupted_runs()) {
    auto noted = add_run_note(*db, run, "lcrigd", text, clock_.unix_ns());
    if (!noted) spdlog::warn("run {}: {}", run, printable(noted.error().what));
  }
}

Task<> App::probe_meter() {
  auto meter = co_await open_real_meter(clock_, config_);
  if (!meter) {
    meter_state_.state = "absent: " + meter.error().what;
    co_return;
  }
  auto identity = co_await (*meter)->identify();
  meter_state_.identity = identity ? identity->text : "";
  meter_state_.state = identity ? "ready" : "absent: " + identity.error().what;
  (*meter)->close();
}

void App::publish() {
  if (!live_run()) return;
  control_->publish_status(session_->status());
}

void App::publish_event(const RunEvent& event) {
  RunEventNote note;
  note.run = live_run() != nullptr ? live_run()->progress().run : 0;
  note.event = event;
  control_->publish_event(note);
}

Run* App::live_run() const {
  return session_ ? session_->run() : nullptr;
}

Task<> App::run_to_its_end() {
  notifier_.status(fmt::format("run {} {}", session_->run()->progress().run,
                               session_->run()->progress().protocol));
  const MonoTime begin = clock_.now();
  const RunResult result = co_await session_->execute();
  const RunStatus last = session_->status();
  co_await session_->close();
  RunEnded ended;
  ended.run = last.run;
  ended.exit_status = result.exit_status;
  ended.reason = result.reason;
  ended.code = result.code;
  ended.lcr_readings = last.lcr_readings;
  ended.measure_readings = last.measure_readings;
  ended.frame_samples = last.frame_samples;
  ended.duration_s = to_seconds(clock_.now() - begin);
  ended.wall_s = ended.duration_s;
  publish();
  session_.reset();
  last_run_ = ended;
  control_->publish_run_ended(ended);
  notifier_.status("idle");
  spdlog::info("run {} ended: {} {}", ended.run, to_string(ended.exit_status),
               printable(ended.reason));
}

DaemonStatus App::status() const {
  DaemonStatus s;
  s.version = LCRIG_VERSION;
  s.database = config_.database;
  if (live_run() != nullptr) s.run = session_->status();
  s.last_run = last_run_;
  s.instruments = {meter_state_, frame_state_};
  return s;
}

Task<bool> App::shut_down(std::string why) {
  if (std::exchange(shutting_down_, true)) co_return true;
  notifier_.stopping();
  const MonoTime patience = clock_.now() + kWorldPatience;
  while (preparing_ && !(building_world_ && clock_.now() >= patience)) {
    co_await clock_.wait_for(10ms);
  }
  if (Run* run = live_run()) run->interrupt(InterruptRequest(Interrupt::abort, why));
  while (session_) co_await clock_.wait_for(10ms);
  co_await control_->close(1s);
  recorder_.reset();
  co_return !building_world_;
}

}  // namespace lcrig
