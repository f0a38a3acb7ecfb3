// SPDX-License-Identifier: Apache-2.0
#include "daemon/session.hpp"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "daemon/record/room.hpp"
#include "daemon/rig/bench_door.hpp"
#include "daemon/rig/instruments.hpp"
#include "model/specimen_file.hpp"
#include "model/specimen_stiffness.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "protocols/plan/rig_forecast.hpp"
#include "protocols/run/run.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

using nlohmann::json;
using namespace std::chrono_literals;

namespace {

// Checks the texts that come besides the files. The parsers limit the files themselves.
Result<> check_words(const RunRequest& request) {
  const std::pair<std::string_view, std::string_view> names[] = {
      {"protocol", request.protocol_name},
      {"specimen", request.specimen_name},
      {"operator", request.operator_name}};
  for (const auto& [what, text] : names) {
    if (auto good = check_text(what, text, kNameMax); !good) return good;
  }
  return check_text("note", request.note, kNoteMax);
}

PlannedTimes planned_times(const Plan& plan) {
  PlannedTimes out;
  out.total_s = plan.duration_s;
  for (const PlannedStep& step : plan.steps) {
    out.step_s[step.id] = step.total_s / static_cast<double>(step.times);
    if (step.in_finally) out.finally_s += step.total_s;
  }
  return out;
}

}  // namespace

double largest_force_N(const Protocol& protocol, const Environment& environment) {
  constexpr double kNobodyPresses_N = 1;
  return protocol.limits.force_max ? environment.get(*protocol.limits.force_max) : kNobodyPresses_N;
}

Result<PreparedRun> prepare_run(RunRequest request) {
  if (auto good = check_words(request); !good) return fail(good.error());
  PreparedRun out;
  auto read = keep(parse_protocol(request.protocol_text, request.protocol_name), out.protocol);
  if (read) read = keep(bind_parameters(out.protocol, request.parameters), out.environment);
  if (read && !request.specimen_text.empty()) {
    read = keep(parse_specimen(request.specimen_text, request.specimen_name), out.specimen);
  }
  if (!read) return fail(read.error());
  out.places_weights = places_weights(out.protocol.steps);
  out.max_force_N = largest_force_N(out.protocol, out.environment);
  out.request = std::move(request);
  return out;
}

InstrumentsRequest instruments_for(const PreparedRun& run) {
  InstrumentsRequest out;
  if (run.specimen) out.specimen = &*run.specimen;
  out.weights = run.places_weights;
  out.max_force_N = run.max_force_N;
  return out;
}

Rig describe_rig(Instruments& instruments) {
  const InstrumentsInfo& info = instruments.info();
  Rig rig;
  rig.lcr = instruments.meter().capabilities();
  rig.frame = instruments.frame().capabilities();
  rig.frame_differences = instruments.frame().differences();
  rig.pressure.probe_diameter_m = info.fixture.probe_diameter_m;
  rig.gravity_m_s2 = info.fixture.local_gravity_m_s2;
  rig.specimen_least_m = info.specimen_least_m;
  rig.specimen_free_m = info.specimen_free_m;
  rig.frame_stiffness_N_m = info.frame.stiffness_N_m;
  if (info.frame.start_gap_m) rig.start_gap = Length::from_si(*info.frame.start_gap_m);
  rig.compression_m = info.compression_m;
  rig.expected_contact = info.expected_contact;
  return rig;
}

Session::Session(asio::any_io_executor executor, Clock& clock, Recorder& recorder,
                 std::unique_ptr<Instruments> instruments, PreparedRun prepared)
    : executor_(std::move(executor)),
      clock_(clock),
      recorder_(recorder),
      instruments_(std::move(instruments)),
      prepared_(std::move(prepared)),
      commands_(commands_frame(prepared_.protocol) || prepared_.places_weights) {}

Session::~Session() = default;

// A simulated bench has a model of the specimen; for a real rig only the specimen's file is known.
void add_specimen(Rig& rig, const PreparedRun& run) {
  if (!run.specimen) return;
  put_disc(*run.specimen, rig.pressure);
  if (rig.compression_m) return;
  rig.specimen_least_m = least_shortening(*run.specimen);
  rig.specimen_free_m = free_shortening(*run.specimen);
  const Force most = Force::from_si(std::max(run.max_force_N, 1e-3));
  rig.compression_m = expected_compression(*run.specimen, most, rig.frame_stiffness_N_m);
}

Task<Result<>> Session::plan() {
  const auto job = [this] {
    add_specimen(rig_, prepared_);
    if (rig_.frame.motion) forecast_ = make_forecast(rig_);
    return make_plan(prepared_.protocol, prepared_.environment, rig_);
  };
  auto plan = co_await run_aside(executor_, clock_, job);
  co_return keep(std::move(plan), plan_);
}

// Checks the plan again with the place of contact that was found, before anything is pressed.
Task<Result<>> Session::check_at_contact(double start_travel_m, double contact_travel_m) {
  Rig rig = rig_;
  rig.start_travel = Length::from_si(start_travel_m);
  rig.found_contact = Length::from_si(contact_travel_m);
  const auto job = [&] { return check_protocol(prepared_.protocol, prepared_.environment, rig); };
  co_return co_await run_aside(executor_, clock_, job);
}

Task<Result<Plan>> Session::preview() {
  auto done = co_await identify();
  if (done) done = co_await look();
  if (done) done = co_await plan();
  if (!done) co_return fail(done.error());
  co_return plan_;
}

bool Session::simulated() const {
  return instruments_->info().simulated || frame_identity_.simulated || meter_identity_.simulated;
}

// Updates what is shown from stored rows only.
void Session::acknowledge(const Committed& c) {
  RunRecord& s = acknowledged_;
  counts_.add(c);
  take_counts();
  s.frame_samples += static_cast<std::int64_t>(c.samples);
  if (known_ != nullptr && !c.readings.empty()) known_->heard(Instrument::lcr);
  if (known_ != nullptr && c.samples > 0) known_->heard(Instrument::frame);
  if (c.last_reading) {
    s.capacitance_F = c.last_reading->primary;
    s.secondary = c.last_reading->secondary;
  }
  if (c.last_sample) {
    s.force_N = c.last_sample->force_N;
    s.travel_m = c.last_sample->travel_m;
    const auto area_m2 = plan_.pressure.area_m2();
    s.pressure_Pa.reset();
    s.pressure_on = plan_.pressure.on;
    if (s.force_N && area_m2) s.pressure_Pa = *s.force_N / *area_m2;
  }
  if (listener_.events) listener_.events(c.events);
}

void Session::take_counts() {
  acknowledged_.lcr_readings = counts_.readings();
  acknowledged_.measure_readings = counts_.of_levels();
  acknowledged_.unproven_readings = counts_.unproven();
}

Result<> Session::compare_origin() {
  if (!prepared_.continues || !commands_) return {};
  auto same = compare_with_now(*prepared_.continues, prepared_.protocol, prepared_.environment,
                               instruments_->frame().origin());
  if (!same) lost_run_ = prepared_.continues->run;
  return same;
}

// Aside, because a network disk may take seconds to answer.
Task<Result<>> Session::require_room_for_plan() {
  const auto job = [this] { return require_room(recorder_.path(), plan_.bytes); };
  co_return co_await run_aside(executor_, clock_, job);
}

// Sends the settings last, because readings follow them.
Task<Result<>> Session::set_up_meter() {
  LcrMeter& meter = instruments_->meter();
  Result<> done;
  if (instruments_->info().tells_corrections) {
    auto on = co_await meter.corrections();
    done = keep(std::move(on), corrections_);
  }
  if (done) {
    auto configured = co_await meter.configure(plan_.lcr);
    done = keep(std::move(configured), settings_);
  }
  if (!done) learn(Instrument::lcr, fail(done.error()));
  co_return done;
}

Task<Result<std::int64_t>> Session::open() {
  auto planned = co_await preview();
  if (!planned) co_return fail(planned.error());
  Result<> going = compare_origin();
  if (going) going = co_await require_room_for_plan();
  if (going && listener_.goes_on) going = listener_.goes_on();
  if (going) going = co_await take_command();
  if (!going) co_return fail(going.error());
  going = co_await set_up_meter();
  if (going) going = co_await compare_at_rest();
  if (going && listener_.goes_on) going = listener_.goes_on();
  if (!going) co_return fail(going.error());
  auto row = make_row();
  auto number = co_await recorder_.begin_run(std::move(row));
  if (!number) co_return fail(number.error());
  run_ = std::make_unique<Run>(executor_, make_setup(*number));
  recorder_.set_listener(recorder_listener());
  instruments_->begin_run(recorder_);
  learn_of_run(*number);
  co_return *number;
}

Recorder::Listener Session::recorder_listener() {
  Recorder::Listener out;
  out.committed = [this](const Committed& c) { acknowledge(c); };
  out.fault = [this](const Error& e) { run_->interrupt(InterruptRequest(Interrupt::fault, e)); };
  out.locked = [this](Duration waited, std::size_t rows) { tell_locked(waited, rows); };
  out.moved = [this] { tell_moved(); };
  return out;
}

RunSetup Session::make_setup(std::int64_t run) {
  const InstrumentsInfo& info = instruments_->info();
  RunSetup setup(clock_, instruments_->meter(), instruments_->frame(), recorder_,
                 prepared_.protocol);
  setup.environment = prepared_.environment;
  setup.limits = plan_.limits;
  setup.commands = commands_;
  setup.frame_rate_Hz = plan_.frame_rate_Hz;
  setup.cell = rig_.frame.cell();
  setup.forecast = forecast_;
  setup.start_gap_m = info.frame.start_gap_m;
  json planned = to_json(plan_);
  planned.erase("steps");
  setup.plan_json = planned.dump();
  setup.check_at_contact = [this](double start_m, double contact_m) {
    return check_at_contact(start_m, contact_m);
  };
  setup.lcr_settings = settings_;
  setup.corrections = corrections_;
  setup.pressure = plan_.pressure;
  setup.gravity_m_s2 = info.fixture.local_gravity_m_s2;
  setup.planned = planned_times(plan_);
  setup.run = run;
  setup.specimen = prepared_.request.specimen_name;
  setup.person = &instruments_->person();
  setup.respondent = instruments_->respondent();
  setup.continues = prepared_.continues;
  setup.on_step = [this](const RunProgress& progress) {
    instruments_->enter_step(progress);
    if (listener_.step) listener_.step(progress);
  };
  setup.on_loss = [this](Instrument which, const Error* lost) { on_loss(which, lost); };
  setup.on_stop = listener_.stop;
  return setup;
}

// Warns at once; the event is stored when the lock is free again.
void Session::tell_locked(Duration waited, std::size_t rows) {
  const std::string text = fmt::format(
      "{}: another program has held the database's write lock for {:.0f} s; {} rows of this run "
      "wait in memory: end its transaction (`fuser {}` says which program it is)",
      recorder_.path(), to_seconds(waited), rows, recorder_.path());
  spdlog::warn("{}", text);
  recorder_.event(RunEvent(clock_.now(), EventKind::database_locked, "", text));
}

std::string Session::moved_words() const {
  return fmt::format(
      "{}: this file was moved, replaced or deleted in the run: move it back beside its log ({}) "
      "before the daemon ends or is restarted, because the log holds what is in no other file",
      recorder_.path(), beside_database(recorder_.path(), "-wal"));
}

void Session::tell_moved() {
  const std::string text = moved_words();
  spdlog::error("{}", text);
  recorder_.event(RunEvent(clock_.now(), EventKind::database_moved, "", text));
}

// Beyond the table of a simulated specimen the results are not physics. The true force decides,
// because a cell with errors may show another.
void Session::note_extrapolation() {
  const auto solved_N = instruments_->info().solved_to_N;
  if (!solved_N || instruments_->door() == nullptr) return;
  const Plant* plant = instruments_->door()->plant();
  if (plant == nullptr) return;
  const double peak_N = plant->peak_answered_N(clock_.now());
  if (peak_N <= *solved_N * (1 + 1e-6)) return;  // allows for rounding
  recorder_.event(RunEvent(
      clock_.now(), EventKind::extrapolated, "",
      fmt::format("the bench went to {:.4g} N, but its specimen is computed up to {:.4g} N only: "
                  "from there on thickness and capacitance follow a straight line",
                  peak_N, *solved_N)));
}

Task<RunResult> Session::execute() {
  RunResult result = co_await run_->execute();
  if (result.code == Errc::not_standing) {
    learn(Instrument::frame,
          fail(Errc::not_standing, "{}", alarm_words(Standstill::not_confirmed)));
  } else if (result.code == Errc::frame_fault) {
    learn(Instrument::frame, fail(*result.code, "{}", result.reason));
  }
  note_extrapolation();
  std::string reason = result.reason;
  ending_ = true;
  auto closed = co_await recorder_.end_run(result.exit_status, std::move(reason));
  recorder_.set_listener(Recorder::Listener());
  counts_.close();
  take_counts();
  if (closed && closed->anchor) anchor_ = to_string(*closed->anchor);
  if (!closed) {
    result.exit_status = ExitStatus::fail;
    result.code = closed.error().code;
    result.reason += (result.reason.empty() ? "" : "; ") + closed.error().what;
  } else if (closed->status != result.exit_status) {  // rows were lost at the end
    result.exit_status = closed->status;
    result.code = Errc::io;
    result.reason = closed->reason;
  }
  if (closed && closed->moved) {
    result.reason += (result.reason.empty() ? "" : "; ") + moved_words();
  }
  co_return result;
}

// The end of a run may wait for another program's lock as long as any commit.
std::optional<std::uint64_t> Session::beats() const {
  if (!run_) return std::nullopt;
  return ending_ ? recorder_.progress() : run_->beats();
}

Task<bool> Session::stop_until_it_stands(std::function<bool()> gives_up) {
  const bool stands = co_await run_->stop_until_it_stands(std::move(gives_up));
  if (stands) learn(Instrument::frame, frame_identity_);
  co_return stands;
}

Task<> Session::close() {
  co_await instruments_->close();
}

RunStatus Session::status() const {
  RunStatus s(run_ ? run_->progress() : RunProgress(), acknowledged_);
  s.simulated = simulated();
  s.prompt = instruments_->person().prompt();
  if (run_ && run_->question()) {
    const OpenQuestion& open = *run_->question();
    s.prompt = prompt_words(open.question);
    s.question = open;
    if (open.until) s.question_left_s = to_seconds(*open.until - clock_.now());
  }
  const auto contact = run_ ? run_->contact_travel_m() : std::nullopt;
  if (contact && s.travel_m) s.gap_m = *contact - *s.travel_m;
  return s;
}

}  // namespace lcrig
