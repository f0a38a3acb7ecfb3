// SPDX-License-Identifier: Apache-2.0
#include "daemon/session.hpp"

#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "base/text.hpp"
#include "daemon/aside.hpp"
#include "model/specimen_file.hpp"
#include "protocols/parse.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

std::string capabilities_json(const FrameCapabilities& c) {
  const json out{{"motion", c.motion},
                 {"force_hold", c.force_hold},
                 {"device_stop", c.device_stop},
                 {"weights", c.weights},
                 {"force_max_N", c.force_max.si()},
                 {"speed_max_m_s", c.speed_max.si()},
                 {"travel_min_m", c.travel_min.si()},
                 {"travel_max_m", c.travel_max.si()},
                 {"reaction_s", to_seconds(c.reaction)},
                 {"deceleration_m_s2", c.deceleration.si()}};
  return out.dump();
}

std::string limits_json(const BoundLimits& l) {
  json out{{"force_min_N", l.force_min_N}, {"force_max_N", l.force_max_N}};
  if (l.travel_min_m) out["travel_min_m"] = *l.travel_min_m;
  if (l.travel_max_m) out["travel_max_m"] = *l.travel_max_m;
  if (l.speed_max_m_s) out["speed_max_m_s"] = *l.speed_max_m_s;
  return out.dump();
}

// Parameters as they were bound, SI.
std::string parameters_json(const Environment& environment) {
  json out = json::object();
  for (const auto& [name, value] : environment.values()) out[name + " (SI)"] = value;
  return out.dump();
}

ExitStatus exit_status(const std::string& word) {
  if (word == "success") return ExitStatus::success;
  return word == "abort" ? ExitStatus::abort : ExitStatus::fail;
}

}  // namespace

namespace {

// The parsers limit the files; these come with them.
Result<> check_words(const SessionRequest& request) {
  const std::pair<std::string_view, std::string_view> names[] = {
      {"protocol", request.protocol_name},
      {"specimen", request.specimen_name},
      {"operator", request.operator_name}};
  for (const auto& [what, text] : names) {
    if (auto good = check_text(what, text, kNameMax); !good) return good;
  }
  return check_text("note", request.note, kNoteMax);
}

}  // namespace

Result<PreparedRun> prepare_run(SessionRequest request) {
  if (auto good = check_words(request); !good) return fail(good.error());
  PreparedRun out;
  auto protocol = parse_protocol(request.protocol_text, request.protocol_name);
  if (!protocol) return fail(protocol.error());
  out.protocol = std::move(*protocol);
  auto environment = bind_parameters(out.protocol, request.parameters);
  if (!environment) return fail(environment.error());
  out.environment = std::move(*environment);
  if (!request.specimen_text.empty()) {
    auto specimen = parse_specimen(request.specimen_text, request.specimen_name);
    if (!specimen) return fail(specimen.error());
    out.specimen = std::move(*specimen);
  }
  out.places_weights = places_weights(out.protocol.steps);
  out.max_force_N = out.environment.get(out.protocol.limits.force_max);
  out.request = std::move(request);
  return out;
}

Rig describe_rig(Instruments& instruments) {
  const InstrumentsInfo& info = instruments.info();
  Rig rig;
  rig.lcr = instruments.meter().capabilities();
  rig.frame = instruments.frame().capabilities();
  rig.probe_area = Area::from_si(info.fixture.probe_area_m2().value_or(0));
  rig.gravity_m_s2 = info.fixture.local_gravity_m_s2;
  rig.compression_m = info.compression_m;
  rig.contact_travel = info.contact_travel;
  return rig;
}

Session::Session(asio::any_io_executor executor, Clock& clock, Recorder& recorder,
                 std::unique_ptr<Instruments> instruments, PreparedRun prepared)
    : executor_(std::move(executor)),
      clock_(clock),
      recorder_(recorder),
      instruments_(std::move(instruments)),
      prepared_(std::move(prepared)) {}

Task<Result<>> Session::identify() {
  auto meter = co_await instruments_->meter().identify();
  if (!meter) co_return fail(meter.error());
  meter_identity_ = std::move(*meter);
  auto frame = co_await instruments_->frame().identify();
  if (!frame) co_return fail(frame.error());
  frame_identity_ = std::move(*frame);
  co_return Result<>();
}

Task<Result<>> Session::plan() {
  if (!instruments_->info().fixture.probe_area_m2() && aims_at_pressure(prepared_.protocol.steps)) {
    co_return fail(Errc::invalid_request,
                   "{}: aims at a pressure, but the area of the probe tip is not known: set "
                   "fixture.probe_diameter_mm in the bench or config file",
                   prepared_.protocol.name);
  }
  const Rig rig = describe_rig(*instruments_);
  const auto job = [&] { return make_plan(prepared_.protocol, prepared_.environment, rig); };
  auto plan = co_await run_aside(executor_, clock_, job);
  if (!plan) co_return fail(plan.error());
  plan_ = std::move(*plan);
  co_return Result<>();
}

RunRow Session::make_row() const {
  const InstrumentsInfo& info = instruments_->info();
  const SessionRequest& request = prepared_.request;
  RunRow row;
  row.protocol_name = prepared_.protocol.name;
  row.protocol_text = request.protocol_text;
  row.parameters_json = parameters_json(prepared_.environment);
  row.specimen_name = request.specimen_name;
  row.specimen_text = request.specimen_text;
  row.probe_diameter_m = info.fixture.probe_diameter_m;
  row.lcr_identity = meter_identity_.text;
  row.frame_identity = frame_identity_.text;
  const Duration conversion = instruments_->meter().capabilities().conversion_time(settings_);
  row.lcr_settings_json = to_json_text(settings_, conversion);
  row.frame_capabilities_json = capabilities_json(instruments_->frame().capabilities());
  row.frame_limits_json = limits_json(plan_.limits);
  row.bench_name = info.bench_name;
  row.bench_text = info.bench_text;
  row.simulated = info.simulated;
  row.seed = info.seed;
  row.model_level = info.model_level;
  row.model_error_json = info.model_json;
  row.operator_name = request.operator_name;
  row.note = request.note;
  row.started_unix_ns = clock_.unix_ns();
  row.started = clock_.now();
  row.boot_id = read_boot_id();
  return row;
}

// Nothing is shown before it is stored.
void Session::acknowledge(const Committed& c) {
  RunRecord& s = acknowledged_;
  s.lcr_readings += static_cast<std::int64_t>(c.readings);
  s.measure_readings += static_cast<std::int64_t>(c.measure_readings);
  s.frame_samples += static_cast<std::int64_t>(c.samples);
  if (c.last_reading) {
    s.capacitance_F = c.last_reading->primary;
    s.secondary = c.last_reading->secondary;
  }
  if (c.last_sample) {
    s.force_N = c.last_sample->force_N;
    s.travel_m = c.last_sample->travel_m;
    const auto area_m2 = instruments_->info().fixture.probe_area_m2();
    s.pressure_Pa.reset();
    if (s.force_N && area_m2) s.pressure_Pa = *s.force_N / *area_m2;
  }
  // A level that is begun anew counts once.
  for (const RunEvent& event : c.events) {
    if (event.kind != "level_abandoned") continue;
    const json detail = json::parse(event.detail, nullptr, false);
    if (detail.is_object()) s.measure_readings -= detail.value("readings", std::int64_t{0});
  }
  if (on_events_) on_events_(c.events);
}

Task<Result<std::int64_t>> Session::open() {
  auto identified = co_await identify();
  if (!identified) co_return fail(identified.error());
  auto planned = co_await plan();
  if (!planned) co_return fail(planned.error());
  auto configured = co_await instruments_->meter().configure(plan_.lcr);
  if (!configured) co_return fail(configured.error());
  settings_ = std::move(*configured);
  auto row = make_row();
  auto number = co_await recorder_.begin_run(std::move(row));
  if (!number) co_return fail(number.error());
  const InstrumentsInfo& info = instruments_->info();
  RunSetup setup(clock_, instruments_->meter(), instruments_->frame(), recorder_,
                 prepared_.protocol);
  setup.environment = prepared_.environment;
  setup.limits = plan_.limits;
  setup.lcr_settings = settings_;
  setup.probe_area_m2 = info.fixture.probe_area_m2();
  setup.gravity_m_s2 = info.fixture.local_gravity_m_s2;
  setup.planned_s = plan_.duration_s;
  setup.run = *number;
  setup.specimen = prepared_.request.specimen_name;
  setup.person = &instruments_->person();
  setup.continues = prepared_.continues;
  setup.on_step = on_step_;
  run_ = std::make_unique<Run>(executor_, std::move(setup));
  recorder_.on_committed([this](const Committed& c) { acknowledge(c); });
  recorder_.on_fault(
      [this](const Error& e) { run_->interrupt(InterruptRequest(Interrupt::fault, e)); });
  co_return *number;
}

Task<RunResult> Session::execute() {
  RunResult result = co_await run_->execute();
  std::string reason = result.reason;
  auto closed = co_await recorder_.end_run(exit_status(result.exit_status), std::move(reason));
  recorder_.on_fault({});
  recorder_.on_committed({});
  if (!closed) {
    result.exit_status = "fail";
    result.code = closed.error().code;
    result.reason += (result.reason.empty() ? "" : "; ") + closed.error().what;
  } else if (to_string(closed->status) != result.exit_status) {  // rows were lost at the end
    result.exit_status = to_string(closed->status);
    result.code = Errc::io;
    result.reason = closed->reason;
  }
  co_return result;
}

Task<> Session::close() {
  co_await instruments_->close();
}

RunStatus Session::status() const {
  RunStatus s(run_ ? run_->progress() : RunProgress(), acknowledged_);
  s.prompt = instruments_->person().prompt();
  const auto contact = run_ ? run_->contact_travel_m() : std::nullopt;
  if (contact && s.travel_m) s.gap_m = *contact - *s.travel_m;
  return s;
}

}  // namespace lcrig
