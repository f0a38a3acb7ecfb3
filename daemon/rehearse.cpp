// SPDX-License-Identifier: Apache-2.0
#include "daemon/rehearse.hpp"

#include <boost/asio/co_spawn.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "daemon/rig/surroundings.hpp"
#include "daemon/session.hpp"
#include "drivers/faults/player.hpp"
#include "model/specimen_file.hpp"
#include "storage/run_summary.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

Result<Bench> bench_of(const std::string& name, const std::string& text) {
  return text.empty() ? find_bench(name) : parse_bench(text, name);
}

SessionRequest session_request(const RehearseRequest& request) {
  SessionRequest out;
  out.protocol_name = request.protocol_name;
  out.protocol_text = request.protocol_text;
  out.parameters = request.parameters;
  out.specimen_name = request.specimen_name;
  out.specimen_text = request.specimen_text;
  out.operator_name = request.operator_name;
  out.note = request.note;
  return out;
}

// A whole world of its own: loop, clock, recorder, instruments.
class Rehearsal {
 public:
  explicit Rehearsal(const RehearseRequest& request) : request_(request) {}

  Result<RehearseResult> run() {
    const RealClock wall;
    const MonoTime begin = wall.now();
    if (auto built = build(); !built) return fail(built.error());
    const bool ended = clock_.run(io_, [this] { return show() && outcome_.has_value(); });
    if (error_) std::rethrow_exception(error_);
    if (!ended) return fail(Errc::bug, "the rehearsal waits for something that never comes");
    if (!*outcome_) return fail(outcome_->error());
    auto result = summarise(**outcome_);
    if (result) result->wall_s = to_seconds(wall.now() - begin);
    return result;
  }

 private:
  Result<> build() {
    auto prepared = prepare_run(session_request(request_));
    if (!prepared) return fail(prepared.error());
    auto instruments = make_instruments(*prepared);
    if (!instruments) return fail(instruments.error());
    if (auto ready = prepare_faults(**instruments, !prepared->places_weights); !ready) return ready;
    Recorder::Options options(request_.db_path);
    if (surroundings_) options.vfs = surroundings_->disk().name();
    auto recorder = Recorder::open(io_, clock_, std::move(options));
    if (!recorder) return fail(recorder.error());
    recorder_ = std::move(*recorder);
    session_ = std::make_unique<Session>(io_.get_executor(), clock_, *recorder_,
                                         std::move(*instruments), std::move(*prepared));
    session_->on_step([this](const RunProgress& s) {
      const bool finishing = s.state == RunState::finishing;
      if (player_) player_->enter_step(s.step_id, s.step_kind, finishing);
    });
    asio::co_spawn(io_, play(), [this](std::exception_ptr error) { error_ = error; });
    return {};
  }

  Result<> prepare_faults(Instruments& instruments, bool has_frame) {
    if (request_.faults_text.empty()) return {};
    auto script = parse_fault_script(request_.faults_text, request_.faults_name);
    if (!script) return fail(script.error());
    if (replay_directory(request_.bench)) {
      return fail(Errc::invalid_request, "--faults needs a simulated bench; a replay has none");
    }
    FaultStage stage;
    stage.has_frame = has_frame;
    if (auto fits = check_stage(*script, stage); !fits) return fits;
    surroundings_ = std::make_unique<VirtualSurroundings>(clock_);
    const auto told = [this](MonoTime at, const std::string& text) { note_fault(at, text); };
    player_ = std::make_unique<FaultPlayer>(io_.get_executor(), clock_, *instruments.door(),
                                            surroundings_.get(), std::move(*script), told);
    return {};
  }

  // What happens before the run row exists is written as soon as it does.
  void note_fault(MonoTime at, const std::string& text) {
    const bool over = text.ends_with(": over");
    if (!over) ++faults_;
    const std::string step = run_ != 0 ? session_->run()->progress().step_id : "";
    RunEvent event(at, EventKind::injected, step, "fault injected: " + text);
    if (run_ == 0) {
      early_faults_.push_back(std::move(event));
    } else {
      recorder_->event(event);
    }
  }

  void begin_faults() {
    if (!player_) return;
    for (const RunEvent& event : early_faults_) recorder_->event(event);
    early_faults_.clear();
    player_->begin();
  }

  Task<> end_faults() {
    if (!player_) co_return;
    player_->stop();
    while (!player_->is_idle()) co_await clock_.wait_for(1ms);
  }

  Result<std::unique_ptr<Instruments>> make_instruments(const PreparedRun& prepared) {
    if (const auto directory = replay_directory(request_.bench)) {
      return make_replay_instruments(io_.get_executor(), clock_, *directory);
    }
    if (!prepared.specimen) {
      return fail(Errc::invalid_request, "a simulated bench needs a specimen: --specimen S");
    }
    auto bench = bench_of(request_.bench, request_.bench_text);
    if (!bench) return fail(bench.error());
    SimRequest sim;
    sim.bench = std::move(*bench);
    sim.specimen = *prepared.specimen;
    if (request_.seed) sim.seed = static_cast<std::int64_t>(*request_.seed);
    sim.weights = prepared.places_weights;
    sim.max_force_N = prepared.max_force_N;
    return make_sim_instruments(io_.get_executor(), clock_, sim);
  }

  Task<> play() {
    auto run = co_await session_->open();
    Result<RunResult> outcome;
    if (run) {
      run_ = *run;
      begin_faults();
      RunResult ended = co_await session_->execute();
      outcome = std::move(ended);
    } else {
      outcome = fail(run.error());
    }
    co_await end_faults();
    co_await session_->close();
    outcome_ = std::move(outcome);
  }

  // Shows the status now and then; never ends the pump by itself.
  bool show() {
    if (!request_.progress || session_->run() == nullptr) return true;
    const MonoTime now = wall_.now();
    if (now < next_show_ && !outcome_) return true;
    next_show_ = now + 50ms;
    request_.progress(session_->status());
    return true;
  }

  Result<RehearseResult> summarise(const RunResult& ended) {
    RehearseResult out;
    out.run = run_;
    out.exit_status = ended.exit_status;
    out.code = ended.code;
    out.reason = ended.reason;
    out.db_path = request_.db_path;
    out.faults = faults_;
    recorder_.reset();
    auto db = open_read_only(request_.db_path);
    if (!db) return fail(db.error());
    auto summary = summarise_run(*db, run_);
    if (!summary) return fail(summary.error());
    out.lcr_readings = summary->lcr_readings;
    out.measure_readings = summary->measure_readings;
    out.frame_samples = summary->frame_samples;
    out.duration_s = summary->duration_s.value_or(0);
    out.peak_force_N = summary->peak_force_N;
    if (summary->c0_F) out.c0_pF = *summary->c0_F * 1e12;
    if (summary->delta_at_peak_F) out.delta_C_fF_at_peak = *summary->delta_at_peak_F * 1e15;
    return out;
  }

  const RehearseRequest& request_;
  RealClock wall_;
  VirtualClock clock_;
  asio::io_context io_{1};
  std::unique_ptr<VirtualSurroundings> surroundings_;  // of a rehearsal with faults
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<FaultPlayer> player_;
  std::vector<RunEvent> early_faults_;
  std::int64_t run_ = 0, faults_ = 0;
  std::optional<Result<RunResult>> outcome_;
  std::exception_ptr error_;
  MonoTime next_show_{};
};

}  // namespace

Result<RehearseResult> rehearse(const RehearseRequest& request) {
  Rehearsal rehearsal(request);
  return rehearsal.run();
}

namespace {

Task<Result<Rig>> identified_rig(Instruments& instruments) {
  auto meter = co_await instruments.meter().identify();
  Result<Rig> rig;
  if (!meter) {
    rig = fail(meter.error());
  } else if (auto frame = co_await instruments.frame().observe(0); !frame) {
    rig = fail(frame.error());
  } else {
    rig = describe_rig(instruments);
  }
  co_await instruments.close();
  co_return rig;
}

}  // namespace

Result<Rig> bench_rig(const BenchRequest& request) {
  const bool known = !request.specimen_text.empty();
  auto specimen = known ? parse_specimen(request.specimen_text, request.specimen_name)
                        : parse_specimen(shipped_specimens().front().text, "shipped specimen");
  if (!specimen) return fail(specimen.error());
  auto bench = bench_of(request.bench, request.bench_text);
  if (!bench) return fail(bench.error());
  const InstrumentNoise noise{bench->plant.capacitance_noise_F, bench->plant.force_noise_N};
  SimRequest sim;
  sim.bench = std::move(*bench);
  sim.specimen = std::move(*specimen);
  sim.weights = request.weights;
  VirtualClock clock;
  asio::io_context io(1);
  auto instruments = make_sim_instruments(io.get_executor(), clock, sim);
  if (!instruments) return fail(instruments.error());
  std::optional<Result<Rig>> rig;
  asio::co_spawn(io, identified_rig(**instruments),
                 [&rig](std::exception_ptr error, Result<Rig> r) {
                   if (error) std::rethrow_exception(error);
                   rig = std::move(r);
                 });
  clock.run(io, [&rig] { return rig.has_value(); });
  if (!rig) return fail(Errc::bug, "the simulated instruments did not answer");
  if (*rig && !request.bench.starts_with("replay:")) (*rig)->noise = noise;
  if (*rig && !known) (*rig)->compression_m = (*rig)->specimen_least_m = {};
  return std::move(*rig);
}

}  // namespace lcrig
