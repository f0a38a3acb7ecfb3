// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/rest_meter.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "protocols/rig/rest_measurement.hpp"
#include "protocols/rig/rig_state.hpp"
#include "protocols/run/event_log.hpp"
#include "protocols/run/setup.hpp"

namespace lcrig {

using namespace std::chrono_literals;

RestMeter::RestMeter(const RunSetup& setup, const EventLog& log, const RigState& rig)
    : setup_(setup), log_(log), rig_(rig) {}
RestMeter::~RestMeter() = default;

void RestMeter::add(std::span<const FrameSample> samples) {
  samples_ += std::ssize(samples);
  if (open_) open_->add(samples);
}

Result<double> RestMeter::present_force_N() const {
  const auto& force_N = rig_.frame.force_N;
  const Duration age = setup_.clock.now() - rig_.frame.force_at;
  const Duration most = stale_after(setup_.frame_rate_Hz);
  if (force_N && age <= most) return *force_N;
  if (!force_N) return fail(Errc::no_reply, "step {}: {}", log_.step_id(), no_force());
  return fail(
      Errc::no_reply,
      "step {}: the last known force, {:.4f} N, is {:.1f} s old: nobody knows which way leads "
      "to less",
      log_.step_id(), *force_N, to_seconds(age));
}

std::string_view RestMeter::no_force() const {
  return rig_.frame.overloaded
             ? "the load is beyond the range of the load cell: unload at the machine, then "
               "look at the specimen and the cell"
             : "the frame sends no force";
}

Task<Result<RestMeasurement>> RestMeter::measure(Duration at_least) {
  open_ = std::make_unique<RestMeasurement>(samples_);
  const MonoTime begin = setup_.clock.now();
  const auto enough = [&] { return open_->forces() >= kRestSamples.count(); };
  co_await setup_.clock.wait_for(at_least);
  while (!enough() && setup_.clock.now() - begin < kDriftTime_s.duration())
    co_await setup_.clock.wait_for(50ms);
  RestMeasurement rest = *std::exchange(open_, nullptr);
  noise_N_ = rest.scatter_N();
  if (rest.forces() == 0) {
    const std::string& step = log_.step_id();
    co_return fail(Errc::no_reply, "{}{}", step.empty() ? step : "step " + step + ": ", no_force());
  }
  co_return rest;
}

Task<Result<RestMeasurement>> RestMeter::measure_alive() {
  auto rest = co_await measure(kRestTime);
  if (rest && !rest->is_alive()) rest = co_await measure(kDriftTime_s.duration());
  if (!rest || rest->is_alive()) co_return rest;
  co_return fail(Errc::refused,
                 "step {}: the load cell shows {:.4f} N in all of {} samples: it is frozen or not "
                 "connected, and nothing is approached with it",
                 log_.step_id(), rest->force_N(), rest->forces());
}

Task<Result<>> RestMeter::await_samples(bool feels) {
  const double period_s = 1 / setup_.frame_rate_Hz;
  const MonoTime begin = setup_.clock.now();
  const MonoTime limit = begin + std::max<Duration>(2s, from_seconds(3 * period_s));
  const std::int64_t before = samples_;
  const auto heard = [&] { return samples_ > before && (!feels || rig_.frame.force_at > begin); };
  while (!heard() && setup_.clock.now() < limit) co_await setup_.clock.wait_for(20ms);
  const bool needed = setup_.frame.capabilities().motion;
  if (samples_ == before && needed) co_return fail(Errc::no_reply, "the frame sends no samples");
  if (!heard() && needed) co_return fail(Errc::no_reply, "{}", no_force());
  co_return Result<>();
}

}  // namespace lcrig
