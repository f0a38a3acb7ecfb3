// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/run_parts.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/either.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/steps/progress.hpp"

namespace lcrig {

namespace {

RigFacts facts_of(const RunSetup& s) {
  return {s.commands, s.limits, s.frame_rate_Hz, s.cell, s.frame.capabilities()};
}

FrameWatch::Hooks watch_hooks(const RunSetup& s, const EventLog& log, InterruptQueue& interrupts) {
  FrameWatch::Hooks hooks;
  hooks.now = [&s] { return s.clock.now(); };
  hooks.store = [&log](const WatchInputEvent& e) { log.event(e); };
  hooks.tolerances = [&log](const Tolerances& t) {
    log.event(EventKind::watch, to_json(t).dump());
  };
  hooks.broken = [&interrupts](std::string why) {
    interrupts.ask(InterruptRequest(Interrupt::fault, Error(Errc::bug, std::move(why))));
  };
  return hooks;
}

}  // namespace

RunParts::RunParts(asio::any_io_executor executor, RunSetup& s, const Environment& v,
                   std::function<void()> look, Sampler::Hooks sampled)
    : setup(s),
      values(v),
      still(s.moves()),
      progress(s, still),
      log(s.clock, s.sink),
      interrupts(executor, s.clock, log, std::move(look)),
      watch_owner(
          std::make_unique<FrameWatch>(facts_of(s), s.forecast, watch_hooks(s, log, interrupts))),
      watch(*watch_owner),
      rig(watch.rig()),
      meter(s, log, rig),
      drive(s, log, interrupts, watch, meter, still),
      response(s, log, interrupts, watch, drive),
      motions(s, log, watch, meter, drive),
      labels(v, s.pressure, s.gravity_m_s2),
      sampler(executor, s.clock, s.lcr, MeterState(s.lcr_settings, s.corrections),
              std::move(sampled)),
      questions(executor, log),
      stops(v, log) {}
RunParts::~RunParts() = default;

Task<ProgressKeeper::Shown> RunParts::wait_as(RunState state) {
  std::optional<ProgressKeeper::Shown> stopping;
  if (!still.holds()) stopping.emplace(progress.show<RunState::stopping>());
  const Stands proof = co_await drive.stand_still();
  stopping.reset();
  auto waiting = progress.show(state, proof);
  if (setup.on_stop) setup.on_stop();
  co_return std::move(waiting);
}

Task<Result<ProgressKeeper::Shown>> RunParts::wait_for_person(MonoTime until) {
  auto waiting = wait_as(RunState::waiting_for_operator);
  auto first = co_await either(std::move(waiting), setup.clock.wait_until(until));
  if (first.index() == 0) co_return std::move(std::get<0>(first));
  co_return fail(Errc::not_standing,
                 "step {}: nobody was asked, because standstill of the frame was not confirmed in "
                 "the time of the step: use the E-stop",
                 log.step_id());
}

RunPoint RunParts::point() const {
  RunPoint p;
  p.steps_done = progress.steps_done();
  labels.write_to(p);
  p.contact_travel_m = rig.contact.travel_m;
  p.travel_m = rig.frame.seen.travel_m;
  p.zeroed = rig.frame.seen.zeroed;
  p.zeros_N = rig.cell.zeros_N;
  p.origin = setup.frame.origin();
  return p;
}

Result<double> travel_of(const Target& target, const RunParts& run) {
  const double value = run.values.get(target.value);
  if (target.kind == TargetKind::travel) return value;
  const auto& contact_m = run.rig.contact.travel_m;
  if (!contact_m) {
    return fail(Errc::invalid_request,
                "step {}: a gap, and the place of contact is not known: find the contact first, or "
                "state the gap (set_gap)",
                run.log.step_id());
  }
  return *contact_m - value;
}

Task<Result<>> move_to_place(const Target& to, const Number& speed, TimeLimit limit,
                             RunParts& run) {
  auto travel_m = travel_of(to, run);
  if (!travel_m) co_return fail(travel_m.error());
  co_return co_await run.motions.to_travel(*travel_m, run.get(speed), limit);
}

Task<Result<>> wait_out(double duration_s, RunParts& run, TimeSpent& time) {
  Clock& clock = run.setup.clock;
  const MonoTime end = time.begin(clock.now(), from_seconds(duration_s));
  if (end > clock.now()) co_await clock.wait_until(end);
  co_return Result<>();
}

}  // namespace lcrig
