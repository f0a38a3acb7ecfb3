// SPDX-License-Identifier: Apache-2.0
#include "daemon/rehearse.hpp"

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "daemon/rehearsal.hpp"
#include "daemon/rig/drill.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/sim.hpp"
#include "daemon/session.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/run_summary.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

std::string answer_remark(std::string_view step, const AnswerEvent& answer) {
  const auto source = parse_word<AnswerSource>(answer.source);
  AnswerValue value = true;
  if (answer.number) value = *answer.number;
  if (answer.text) value = *answer.text;
  return fmt::format("step {} was answered \"{}\": {}", step,
                     answer_words(value, answer.unit.value_or("")),
                     source == AnswerSource::file ? "from the file of answers"
                     : source == AnswerSource::made_up
                         ? "made up, for the protocol has no default and --answers says nothing"
                         : "the default of the protocol");
}

class RunRehearsal final : public Rehearsal {
 public:
  explicit RunRehearsal(const RehearseRequest& request)
      : Rehearsal(request.progress), request_(request) {}
  ~RunRehearsal() override { app_.reset(); }  // before the drill, which its instruments use
  RunRehearsal(const RunRehearsal&) = delete;
  RunRehearsal& operator=(const RunRehearsal&) = delete;

  Result<RehearseResult> run() {
    const MonoTime begin = wall_.now();
    if (auto read = keep(prepare_run(request_), prepared_); !read) return fail(read.error());
    if (auto made = make_app(); !made) return fail(made.error());
    if (auto played = play(); !played) return fail(played.error());
    if (!outcome_) return fail(outcome_.error());
    auto result = summarise();
    if (result) result->wall_s = to_seconds(wall_.now() - begin);
    return result;
  }

 private:
  Result<> make_app() {
    if (!request_.faults_text.empty()) {
      auto drill = FaultDrill::make(clock_, request_.faults_text, request_.faults_name);
      if (auto made = keep(std::move(drill), drill_); !made) return made;
    }
    // Made before the database, so that a mistake leaves no database behind.
    if (auto made = keep(make_instruments(prepared_), instruments_); !made) return made;
    AppParts parts;
    parts.rig = std::make_unique<RehearsalRig>(
        [this](const InstrumentsRequest&) { return std::move(instruments_); });
    if (drill_) parts.vfs = drill_->disk();
    parts.sync_each_commit = drill_ != nullptr;  // a drill may let the disk fail
    parts.true_clock = &wall_;
    Config config;
    config.database = request_.db_path;
    app_ = std::make_unique<App>(io_, clock_, std::move(config), std::move(parts));
    return app_->open();
  }

  Result<std::unique_ptr<Instruments>> make_instruments(const PreparedRun& prepared) {
    auto sim = sim_request(request_, instruments_for(prepared));
    if (!sim) return fail(sim.error());
    if (sim->replay && drill_) {
      return fail(Errc::invalid_request, "--faults needs a simulated bench; a replay has none");
    }
    if (sim->replay && !request_.answers_text.empty()) {
      return fail(Errc::invalid_request, "--answers needs a simulated bench; a replay has none");
    }
    sim->drill = drill_.get();
    if (!request_.answers_text.empty()) {
      auto answers = parse_answers(request_.answers_text, request_.answers_name, prepared.protocol,
                                   prepared.environment);
      if (auto r = keep(std::move(answers), sim->answers); !r) return fail(r.error());
    }
    return make_sim_instruments(io_.get_executor(), clock_, *sim);
  }

  Task<> act() override {
    auto outcome = co_await app_->run_through(std::move(prepared_));
    outcome_ = std::move(outcome);
  }

  // Reads the result from the stored rows.
  Result<RehearseResult> summarise() {
    RehearseResult out;
    static_cast<RunOutcome&>(out) = *outcome_;
    out.db_path = request_.db_path;
    if (drill_) out.faults = drill_->happened();
    auto db = open_read_only(request_.db_path);
    if (!db) return fail(db.error());
    auto summary = summarise_run(*db, out.run);
    if (!summary) return fail(summary.error());
    out.lcr_readings = summary->lcr_readings;
    out.measure_readings = summary->measure_readings;
    out.unproven_readings = summary->unproven_readings;
    out.frame_samples = summary->frame_samples;
    out.duration_s = summary->duration_s.value_or(0);
    out.peak_force_N = summary->peak_force_N;
    auto remarks =
        db->rows<std::string>("SELECT detail FROM event WHERE run_id = ? AND kind = ? ORDER BY seq",
                              out.run, EventKind::extrapolated);
    if (auto r = keep(std::move(remarks), out.remarks); !r) return fail(r.error());
    if (auto answered = add_answers(*db, out); !answered) return fail(answered.error());
    if (summary->c0_F) out.c0_pF = *summary->c0_F * 1e12;
    if (summary->delta_at_peak_F) out.delta_C_fF_at_peak = *summary->delta_at_peak_F * 1e15;
    return out;
  }

  // Adds the first answer to each question, and who gave it.
  static Result<> add_answers(const Database& db, RehearseResult& out) {
    const auto read = [&out](const Statement& row) {
      const auto answer = from_json<AnswerEvent>(row.text(1));
      if (answer) out.remarks.push_back(answer_remark(row.text(0), *answer));
    };
    return db.each(
        "SELECT step_id, detail, min(seq) FROM event WHERE run_id = ? AND kind = ? GROUP BY "
        "step_id "
        "ORDER BY 3",
        read, out.run, EventKind::answer);
  }

  const RehearseRequest& request_;
  PreparedRun prepared_;
  std::unique_ptr<FaultDrill> drill_;
  std::unique_ptr<Instruments> instruments_;
  Result<RunOutcome> outcome_;
};

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

Result<RehearseResult> rehearse(const RehearseRequest& request) {
  RunRehearsal rehearsal(request);
  return rehearsal.run();
}

Result<Rig> bench_rig(const BenchRequest& request) {
  const bool known = !request.specimen_text.empty();
  auto specimen = known ? parse_specimen(request.specimen_text, request.specimen_name)
                        : parse_specimen(shipped_specimens().front().text, "shipped specimen");
  if (!specimen) return fail(specimen.error());
  if (!known) specimen->top = Top::plate;  // it only stands in: any probe may press it
  InstrumentsRequest wanted;
  wanted.specimen = &*specimen;
  wanted.weights = request.weights;
  const auto sim = sim_request(request, wanted);
  if (!sim) return fail(sim.error());
  InstrumentNoise noise;
  noise.capacitance_F = sim->bench.plant.capacitance_noise_F;
  noise.force_N = sim->bench.plant.force_noise_N;
  // The noise of FAST is known from recordings of an LCR-6100; a bench file may state the others.
  for (const std::size_t i : {1U, 2U}) {
    noise.guessed[i] = noise.capacitance_F[i] == PlantConfig().capacitance_noise_F[i];
  }
  VirtualClock clock;
  asio::io_context io(1);
  auto instruments = make_sim_instruments(io.get_executor(), clock, *sim);
  if (!instruments) return fail(instruments.error());
  std::optional<Result<Rig>> rig;
  asio::co_spawn(io, identified_rig(**instruments),
                 [&rig](std::exception_ptr error, Result<Rig> r) {
                   if (error) std::rethrow_exception(error);
                   rig = std::move(r);
                 });
  clock.run(io, [&rig] { return rig.has_value(); });
  if (!rig) return fail(Errc::bug, "the simulated instruments did not answer");
  if (*rig && !sim->replay) (*rig)->noise = noise;
  if (*rig && known) put_disc(*specimen, (*rig)->pressure);
  if (*rig && !known) {
    (*rig)->compression_m = (*rig)->specimen_least_m = (*rig)->specimen_free_m = {};
  }
  return std::move(*rig);
}

}  // namespace lcrig
