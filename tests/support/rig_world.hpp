// SPDX-License-Identifier: Apache-2.0
// A whole session on a random rig in virtual time, planned as on a real rig. It records the truth
// and can act in the middle of the run. For the property tests.
#pragma once

#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/rig/drill.hpp"
#include "daemon/session.hpp"
#include "drivers/faults/player.hpp"
#include "drivers/memory_pipe.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"
#include "tests/support/replayed.hpp"
#include "tests/support/rig_instruments.hpp"
#include "tests/support/rig_witness.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {

// A motion that stopped at a force, as the run reported it.
struct Overshoot {
  Overshoot() = default;
  MonoTime at;
  double threshold_N = 0, predicted_N = 0, observed_N = 0;
  bool exceeded = false;
};

// The stiffness that a run measured at a contact, and the true stiffness there.
struct MeasuredStiffness {
  MeasuredStiffness() = default;
  double at_most_N_m = 0, true_N_m = 0;  // true: force over the travel since the touch
};

class RigWorld {
 public:
  // Something that happens at an instant: `after_s` after the start, after this part of the planned
  // time, or `after_s` after the n-th step, the n-th change of the drive (from 0) or `finally`
  // began.
  struct Act {
    enum class When { time, part, step, drive, finally };
    When when = When::time;
    std::size_t n = 0;
    double after_s = 0;  // with `part`: a share from 0 to 1
    std::function<void(RigWorld&)> act;
    double lasts_s = 0;  // after this time `undo` is called, if set
    std::function<void(RigWorld&)> undo;
  };
  struct Acted {
    MonoTime at;
    bool prepared = false, moving = false, finishing = false;  // state at that instant
  };

  RigWorld(sim::RandomRig rig, std::string protocol_text)
      : rig_(std::move(rig)), text_(std::move(protocol_text)) {}
  ~RigWorld() { player_.reset(); }

  // Set these before `run`.
  ParameterValues parameters;
  std::vector<Act> acts;
  std::string fault_script;
  double longest_s = 4000;  // a longer run is aborted
  bool plan_only = false;
  bool is_witnessed = false;  // `witness` records

  // Valid after `run`. How far the run came:
  std::optional<Error> refused;  // why the run did not begin
  std::optional<RunResult> result;
  std::optional<Plan> plan;
  std::vector<RunEvent> events;
  std::vector<Overshoot> overshoots;
  std::vector<MeasuredStiffness> stiffnesses;
  // Counted until the plan was refused or the run began.
  std::int64_t hellos = 0, commands = 0, motions = 0, stops = 0;
  // The truth:
  Extremes all, since;  // `since`: from the last scene().watch_anew
  bool stood = false, was_idle = false;
  double last_N = 0, outside_m = 0;  // force at the end; largest distance beyond the travel limits
  std::vector<TruthScene::Change> changes;  // of the drive
  std::vector<bool> was_finishing;  // for each change
  std::size_t changes_at_end = 0;  // number of changes at the end of the run
  std::vector<Acted> acted;
  bool too_long = false;
  bool is_clean = false;  // nothing was left waiting
  std::string replay_differs;  // how the watch judges the stored run another time
  RigWitness witness;
  MonoTime over_at;

  void run() {
    auto prepared = prepare();
    if (!prepared) {
      refused = prepared.error();
      is_clean = stood = true;
      return;
    }
    if (auto made = make(std::move(*prepared)); !made) throw std::runtime_error(made.error().what);
    spawn(play());
    clock.run(io, [this] { return over_ && clock.pending() == 0; });
    player_.reset();
    if (fault_script.empty() && result) judge_again();
    recorder_.reset();
    io.restart();
    io.poll();
    is_clean = over_ && clock.pending() == 0 && io.stopped();
  }

  Run* live() { return session_ ? session_->run() : nullptr; }
  TruthScene& scene() { return instruments_->scene(); }
  FaultBench& bench() { return *instruments_->door(); }
  const sim::RandomRig& rig() const { return rig_; }
  bool is_finishing() {
    return over_ || (live() != nullptr && live()->progress().state == RunState::finishing);
  }
  std::string database() const { return dir_.file("t.db"); }
  std::vector<std::int64_t> faults_happened() const {
    return player_ ? player_->happened() : std::vector<std::int64_t>();
  }

  // Interrupts the run as a person or SIGTERM would; also while it is being prepared.
  void interrupt(Interrupt kind, const std::string& why) {
    if (Run* r = live()) {
      r->interrupt(InterruptRequest(kind, why));
    } else {
      stopped_early_ = why;
    }
  }

  // A pause that was requested during preparation begins with the first step. Before that there is
  // nothing to resume, so this keeps trying.
  void resume() { spawn(resume_once_paused()); }

  VirtualClock clock;
  asio::io_context io{1};
  std::vector<std::int64_t> happened;  // how often each fault of the script happened

 private:
  void judge_again() {
    const auto db = open_read_only(database(), kInMemory);
    replay_differs = db ? replay_difference(*db, 1) : db.error().what;
  }

  Recorder::Options recorder_options() {
    Recorder::Options options(database());
    // A script may break the disk, so the run then needs a real one.
    options.vfs = fault_script.empty() ? kInMemory : surroundings_.disk().name();
    return options;
  }

  Result<PreparedRun> prepare() {
    RunRequest request;
    request.protocol_name = "random";
    request.protocol_text = text_;
    request.parameters = parameters;
    request.specimen_name = "random";
    request.specimen_text = rig_.specimen_text;
    return prepare_run(std::move(request));
  }

  Result<> make(PreparedRun prepared) {
    limits_of(prepared);
    auto instruments = std::make_unique<RigInstruments>(
        io.get_executor(), clock, rig_, make_memory_pipe,
        [this](std::string_view line) { hear(line); },
        [this](std::string_view line) { hear_back(line); });
    if (auto built = instruments->build(); !built) return built;
    instruments_ = instruments.get();
    if (is_witnessed) {
      instruments_->door()->frame_sim()->watch = [this](MonoTime t, const FrameSample& s) {
        const Plant& truth = instruments_->truth();
        witness.take(t, s, truth.force_N(t), truth.travel_m(t));
      };
    }
    auto recorder = Recorder::open(io, clock, recorder_options());
    if (!recorder) return fail(recorder.error());
    recorder_ = std::move(*recorder);
    session_ = std::make_unique<Session>(io.get_executor(), clock, *recorder_,
                                         std::move(instruments), std::move(prepared));
    Session::Listener listener;
    listener.events = [this](const std::vector<RunEvent>& more) {
      for (const RunEvent& e : more) take(e);
    };
    listener.goes_on = [this]() -> Result<> {
      if (!stopped_early_) return {};
      return fail(Errc::aborted, "stopped while it was being prepared ({})", *stopped_early_);
    };
    listener.step = [this](const RunProgress& p) { enter_step(p); };
    session_->set_listener(std::move(listener));
    scene().on_change = [this](const TruthScene::Change&) {
      was_finishing.push_back(is_finishing());
      begin_acts(Act::When::drive);
    };
    scene().on_look = [this](MonoTime t) { look(t); };
    if (fault_script.empty()) return {};
    auto script = parse_fault_script(fault_script, "script");
    if (!script) return fail(script.error());
    player_ =
        std::make_unique<FaultPlayer>(io.get_executor(), clock, bench(), &surroundings_,
                                      std::move(*script), [](MonoTime, const std::string&) {});
    return {};
  }

  void limits_of(const PreparedRun& prepared) {
    FrameCapabilities none;
    const auto limits = bind_limits(prepared.protocol, prepared.environment, none);
    if (limits) limits_ = *limits;
  }

  void spawn(Task<> task) {
    asio::co_spawn(io, std::move(task), [](std::exception_ptr e) {
      if (e) std::rethrow_exception(e);
    });
  }

  Task<> play() {
    spawn(watch_time());
    begin_acts(Act::When::time);
    Result<> opened;
    if (plan_only) {
      auto seen = co_await session_->preview();
      if (!seen) opened = fail(seen.error());
      if (seen) plan = *seen;
    } else {
      auto number = co_await session_->open();
      if (!number) opened = fail(number.error());
    }
    if (opened && !plan_only) {
      begun_ = true;
      plan = session_->planned();
      if (player_) player_->begin();
      begin_acts(Act::When::part);
      RunResult r = co_await session_->execute();
      result = std::move(r);
    } else if (!opened) {
      refused = opened.error();
    }
    conclude();
    co_await session_->close();
    changes = scene().changes;
    instruments_ = nullptr;
  }

  void conclude() {
    const MonoTime now = clock.now();
    scene().look(now);
    all = scene().all;
    since = scene().since;
    stood = scene().stands(now);
    last_N = scene().force_N(now);
    changes_at_end = scene().changes.size();
    over_at = now;
    over_ = true;
    if (player_) {
      happened = player_->happened();
      player_->stop();
    }
    for (const auto& w : waiting_) w->notify();
  }

  void begin_acts(Act::When when) {
    const bool counted = when == Act::When::step || when == Act::When::drive;
    std::size_t& n = when == Act::When::step ? steps_ : drives_;
    if (over_) return;
    for (Act& a : acts) {
      if (a.when == when && (!counted || a.n == n)) spawn(wait_and_act(a));
    }
    if (counted) ++n;
  }

  // Waits, but not beyond the end of the run. False when the run is over.
  Task<bool> wait_in_run(Duration d) {
    const MonoTime due = clock.now() + d;
    waiting_.push_back(std::make_unique<Wakeup>());
    Wakeup& wakeup = *waiting_.back();
    while (!over_ && clock.now() < due) co_await clock.wait_until(due, wakeup);
    co_return !over_;
  }

  Task<> wait_and_act(Act& act) {
    const double unit_s = act.when == Act::When::part ? plan->duration_s : 1;
    const Duration after = from_seconds(act.after_s * unit_s);
    const bool in_time = co_await wait_in_run(after);
    if (!in_time) co_return;
    Acted a;
    a.at = clock.now();
    a.prepared = begun_;
    a.moving = !scene().stands(a.at);
    a.finishing = is_finishing();
    acted.push_back(a);
    act.act(*this);
    if (!act.undo) co_return;
    const Duration lasts = from_seconds(act.lasts_s);
    const bool still = co_await wait_in_run(lasts);
    if (still) act.undo(*this);
  }

  Task<> resume_once_paused() {
    while (live() != nullptr && !live()->resume()) {
      const bool still = co_await wait_in_run(std::chrono::milliseconds(100));
      if (!still) co_return;
    }
  }

  Task<> watch_time() {
    const Duration longest = from_seconds(longest_s);
    const bool still_there = co_await wait_in_run(longest);
    if (!still_there) co_return;
    too_long = true;
    interrupt(Interrupt::abort, "it takes too long");
  }

  void enter_step(const RunProgress& p) {
    if (player_) player_->enter_step(p.step_id, p.step_kind, p.state == RunState::finishing);
    begin_acts(Act::When::step);
    if (p.state == RunState::finishing && !std::exchange(in_finally_, true)) {
      begin_acts(Act::When::finally);
    }
  }

  void hear_back(std::string_view line) {
    if (is_witnessed) witness.hear(clock.now(), line, false);
  }
  void hear(std::string_view line) {
    if (is_witnessed) witness.hear(clock.now(), line, true);
    if (line == "STOP") ++stops;
    if (begun_) return;
    if (line.starts_with("HELLO")) ++hellos;
    if (!line.starts_with("#")) return;
    ++commands;
    const auto word = line.substr(std::min(line.find(' ') + 1, line.size()));
    for (const char* motion : {"MOVE ", "MOVEF ", "RAMPF ", "HOLD ", "ZERO ", "LIMITS "}) {
      if (word.starts_with(motion)) ++motions;
    }
  }

  void take(const RunEvent& e) {
    events.push_back(e);
    if (e.kind == EventKind::contact) {
      rest_N_ = nlohmann::json::parse(e.detail).at("rest_force_N");
    }
    if (e.kind == EventKind::stiffness) take_stiffness(nlohmann::json::parse(e.detail));
    const bool exceeded = e.kind == EventKind::overshoot_exceeded;
    if (!exceeded && e.kind != EventKind::overshoot) return;
    const auto detail = nlohmann::json::parse(e.detail);
    Overshoot o;
    o.at = e.t;
    o.threshold_N = detail.at("threshold_N");
    o.predicted_N = detail.at("predicted_N");
    o.observed_N = detail.at("observed_N");
    o.exceeded = exceeded;
    overshoots.push_back(o);
  }

  void take_stiffness(const nlohmann::json& detail) {
    if (detail.at("at_most_N_m").is_null()) return;
    const Plant& truth = instruments_->truth();
    MeasuredStiffness m;
    m.at_most_N_m = detail.at("at_most_N_m");
    const double force_N = detail.at("force_N").get<double>() - rest_N_;
    m.true_N_m = force_N / (truth.travel_at_force_m(force_N) - truth.config().contact_travel_m);
    stiffnesses.push_back(m);
  }

  // Compares the travel with the limits, which are windows in the machine's own travel. A travel
  // that was outside when a window began counts only if it goes farther out.
  void look(MonoTime t) {
    const double travel = instruments_->truth().travel_m(t);
    const double zero = instruments_->door()->frame_sim()->travel_zero_m();
    const auto contact = live() != nullptr ? live()->contact_travel_m() : std::nullopt;
    BoundLimits window = limits_;
    if (contact) window.place_contact(*contact);
    if (!window.travel_min_m) return;
    const double low = *window.travel_min_m + zero, high = *window.travel_max_m + zero;
    if (!window_ || window_->first != low || window_->second != high) {
      window_.emplace(low, high);
      allowed_outside_m_ = std::max({0.0, low - travel, travel - high});
    }
    const double outside = std::max({0.0, low - travel, travel - high});
    outside_m = std::max(outside_m, outside - allowed_outside_m_);
  }

  sim::RandomRig rig_;
  std::string text_;
  TempDir dir_;
  VirtualSurroundings surroundings_{clock};
  std::unique_ptr<Recorder> recorder_;
  RigInstruments* instruments_ = nullptr;
  std::unique_ptr<Session> session_;
  std::unique_ptr<FaultPlayer> player_;
  std::vector<std::unique_ptr<Wakeup>> waiting_;
  std::optional<std::string> stopped_early_;
  BoundLimits limits_;
  std::optional<std::pair<double, double>> window_;
  double allowed_outside_m_ = 0;
  double rest_N_ = 0;  // force of the cell without contact
  bool begun_ = false, over_ = false, in_finally_ = false;
  std::size_t steps_ = 0, drives_ = 0;
};

}  // namespace lcrig
