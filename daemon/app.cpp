// SPDX-License-Identifier: Apache-2.0
#include "daemon/app.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/program_version.hpp"
#include "base/spawn.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/real.hpp"
#include "daemon/rig/sim.hpp"
#include "daemon/session.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kWorldPatience = 3s;  // many bonded layers take minutes

std::unique_ptr<InstrumentFactory> rig_of(const Config& config, asio::any_io_executor executor,
                                          Clock& clock, KnownRig& known, Operator& person) {
  if (!config.bench) return std::make_unique<RealRig>(executor, clock, config, known, person);
  return std::make_unique<SimulatedRig>(executor, clock, *config.bench, known, person);
}

}  // namespace

App::App(asio::io_context& io, Clock& clock, Config config, AppParts parts)
    : executor_(io.get_executor()),
      io_(io),
      clock_(clock),
      config_(std::move(config)),
      vfs_(std::move(parts.vfs)),
      sync_each_commit_(parts.sync_each_commit),
      true_clock_(parts.true_clock),
      notifier_(std::move(parts.notifier)),
      person_(executor_),
      known_(clock),
      rig_(parts.rig ? std::move(parts.rig) : rig_of(config_, executor_, clock, known_, person_)),
      control_(executor_, clock, *this, std::move(parts.control)),
      use_(clock),
      callers_(clock, control_, recorder_),
      writes_(executor_, clock, config_.database, callers_),
      news_(control_, notifier_, use_),
      starter_(executor_, clock,
               {config_.database, recorder_, *rig_, known_, use_, plans_, news_, writes_}),
      queue_(executor_, clock, {config_.database, vfs_, use_, starter_, plans_, callers_, news_}),
      requests_(executor_, clock,
                {config_.database, *rig_, use_, callers_, writes_, starter_, queue_}),
      meter_({executor_, clock, *rig_, known_, config_.database, vfs_},
             {use_, callers_, queue_, notifier_}),
      steering_(clock, {use_, callers_, person_, queue_, recorder_}),
      watch_(clock, {config_.database, *rig_, known_, use_, recorder_, writes_}),
      heartbeat_(clock, {recorder_, *rig_, use_, notifier_, news_}),
      metrics_(executor_, clock,
               {config_, recorder_, heartbeat_, use_, [this] { return status(); }}),
      config_taker_(executor_, clock,
                    {config_, std::move(parts.load_config), notifier_, use_, *rig_, plans_}) {
  connect();
}

App::~App() = default;

QueueHandler* App::queue() {
  return queue_.runner();
}

// Sets the callbacks by which a part calls another one that it does not know.
void App::connect() {
  RigUse::Listener listener;
  listener.idle = [this] {
    notifier_.status("idle");
    config_taker_.take_when_idle();
  };
  listener.entered = [this] { queue_.wake(); };
  use_.set_listener(std::move(listener));
  starter_.set_guard([this](const Session& session) { return queue_.may_begin(session); });
  news_.on_event([this](const RunEvent& event) {
    queue_.note(event);
    metrics_.count(event);
  });
}

Result<> App::open() {
  Recorder::Options options(config_.database);
  options.vfs = vfs_;
  options.sync_each_commit = sync_each_commit_;
  options.true_clock = true_clock_;
  return keep(Recorder::open(io_, clock_, std::move(options)), recorder_);
}

Result<> App::open_with_queue() {
  if (auto opened = open(); !opened) return opened;
  if (auto ready = queue_.open(); !ready) return ready;
  spawn(executor_, heartbeat_.run());
  spawn(executor_, queue_.run());
  return {};
}

Result<> App::start() {
  if (auto opened = open(); !opened) return opened;
  watch_.look_at_orphans();
  starter_.look_for_resumable();
  if (auto ready = queue_.open(); !ready) return ready;
  if (auto listening = control_.listen(config_.socket); !listening) return listening;
  if (rig_->is_real()) {
    use_.enter(RigUse::State::asking);  // no run begins before the frame was made safe
    spawn(executor_, watch_.ask());
    spawn(executor_, watch_.watch_ports());
  }
  spawn(executor_, heartbeat_.run());
  spawn(executor_, queue_.run());
  spawn(executor_, metrics_.write());
  notifier_.ready();
  notifier_.status("idle");
  spdlog::info("lcrigd {}: database {}, socket {}", program_version(), config_.database,
               config_.socket);
  return {};
}

Task<Result<RunOutcome>> App::run_through(PreparedRun prepared) {
  spawn(executor_, heartbeat_.run());
  auto claimed = co_await use_.claim(RigUse::State::starting);
  if (!claimed) co_return fail(claimed.error());
  auto started = co_await starter_.start(std::move(prepared));
  if (!started) co_return fail(started.error());
  const auto over = [this] { return use_.is_idle() || use_.state() == RigUse::State::stopping; };
  co_await use_.wait(over);
  co_return *use_.last_run();
}

DaemonStatus App::status() const {
  DaemonStatus s;
  s.version = program_version();
  s.database = config_.database;
  std::optional<std::int64_t> run;
  if (use_.live_run() != nullptr) {
    s.run = use_.session()->status();
    run = s.run->run;
  }
  s.correcting = use_.state() == RigUse::State::correcting;
  s.last_run = use_.last_run();
  s.resumable = starter_.resumable();
  if (const QueueRunner* queue = queue_.runner()) s.queue = queue->status();
  s.instruments = known_.states(run);
  s.socket_trouble = control_.trouble();
  return s;
}

Task<bool> App::shut_down(std::string why) {
  if (use_.is_ending()) co_return true;
  use_.end();
  if (QueueRunner* queue = queue_.runner()) queue->end();
  meter_.give_up();
  notifier_.stopping();
  const auto is_settled = [this] {
    return use_.is_idle() || use_.state() == RigUse::State::running ||
           use_.state() == RigUse::State::stopping;
  };
  bool done = false;
  do {
    const MonoTime patience = clock_.now() + kWorldPatience;
    done = co_await use_.wait(is_settled, patience);
  } while (!done && !rig_->is_computing());
  if (Run* run = use_.live_run()) {
    notifier_.extend_timeout(kStopExtension);
    run->interrupt(InterruptRequest(Interrupt::abort, why));
  }
  const auto is_over = [this] { return use_.session() == nullptr && queue_.over(); };
  co_await use_.wait(is_over);
  co_await control_.close(1s);
  // Waits for the last commit on this thread, which nothing else needs any more. The recorder's
  // last reports are made here.
  recorder_.reset();
  co_return !rig_->is_computing();
}

}  // namespace lcrig
