// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/run_parts.hpp"

#include <algorithm>
#include <utility>

#include "base/either.hpp"

namespace lcrig {

namespace {

// A moving frame is stopped when samples are missing for three periods, but at least for two
// batches of the link (100 ms each) with their jitter.
Duration stale_after(double rate_Hz) {
  return std::max<Duration>(from_seconds(3.0 / rate_Hz), std::chrono::milliseconds(500));
}

}  // namespace

RunParts::RunParts(asio::any_io_executor executor, RunSetup& s, const Environment& v,
                   std::function<void()> look, Sampler::Hooks sampled)
    : setup(s),
      values(v),
      pressing(s.pressing ? &*s.pressing : nullptr),
      still(s.moves()),
      progress(s, still),
      log(s.clock, s.sink),
      interrupts(executor, s.clock, log, std::move(look)),
      guard(s.limits, stale_after(s.frame_rate_Hz), s.cell),
      view(s, log),
      truth(s, log, guard, pressing, view),
      contact(s, v, guard, truth),
      drive(s, log, interrupts, guard, truth, contact, still),
      distrust(s, log, interrupts, guard, pressing, truth, contact, drive),
      motions(s, log, guard, pressing, view, truth, contact, drive),
      labels(v, s.pressure, s.gravity_m_s2),
      sampler(executor, s.clock, s.lcr, MeterState(s.lcr_settings, s.corrections),
              std::move(sampled)),
      questions(executor, log),
      stops(v, log) {}

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
  p.contact_travel_m = contact.travel_m();
  p.travel_m = view.travel_m();
  p.zeroed = view.memory().zeroed;
  p.zeros_N = view.zeros_N();
  p.origin = setup.frame.origin();
  return p;
}

Task<Result<>> move_to_place(const Target& to, const Number& speed, TimeLimit limit,
                             RunParts& run) {
  auto travel_m = run.contact.travel_of(to, run.log.step_id());
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
