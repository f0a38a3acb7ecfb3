// SPDX-License-Identifier: Apache-2.0
// Property: an accepted protocol has a plan with finite numbers, or a refusal that names the place.
#include <cmath>

#include "drivers/lcr6100/codec.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "protocols/plan/plan.hpp"
#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

Rig some_rig(bool weights) {
  Rig rig;
  rig.lcr = lcr6100::capabilities();
  rig.frame.motion = rig.frame.force_hold = !weights;
  rig.frame.weights = weights;
  rig.frame.force_channel = rig.frame.travel_channel = true;
  rig.frame.zero_force = rig.frame.zero_travel = true;
  rig.frame.force_max = Force::from_si(100);
  rig.frame.speed_max = Velocity::from_si(0.05);
  rig.frame.travel_min = Length::from_si(-0.1);
  rig.frame.travel_max = Length::from_si(0.1);
  rig.frame.sample_rate_max_Hz = 1000;
  rig.frame.deceleration = Acceleration::from_si(1);
  rig.pressure.probe_diameter_m = 4e-3;
  rig.compression_m = [](double force_N) { return 1e-5 * force_N; };
  return rig;
}

// The number of steps that a plan would visit, as far as literals show. A plan of two million steps
// takes seconds, which a fuzzer would call a hang.
double visits(const Steps& steps, const Environment& environment) {
  double sum = 0;
  for (const Step& step : steps) {
    const Loop* loop = facts_of(step).loop;
    if (!loop) {
      sum += 1;
      continue;
    }
    const std::string* variable = loop->variable();
    Environment inner = environment;
    if (variable != nullptr) inner.set(*variable, 1);
    sum += static_cast<double>(loop->passes(environment)) * visits(loop->steps, inner);
  }
  return sum;
}

void plan_it(const Protocol& protocol, const Environment& environment) {
  constexpr double kMost = 5'000;
  if (visits(protocol.steps, environment) > kMost) return;
  if (visits(protocol.finally_steps, environment) > kMost) return;
  const auto plan = make_plan(protocol, environment, some_rig(places_weights(protocol.steps)));
  if (!plan) return require_good_message(plan.error());
  require(std::isfinite(plan->duration_s) && plan->duration_s >= 0, "a duration that is none");
  require(std::isfinite(plan->peak_force_N) && std::isfinite(plan->overshoot_N), "no finite force");
  require(std::isfinite(plan->travel_min_m) && plan->travel_min_m <= plan->travel_max_m, "travel");
  require(plan->bytes > 0 && plan->lcr_readings >= 0 && plan->frame_samples >= 0, "sizes");
}

}  // namespace

void read_protocol(std::string_view input) {
  const auto protocol = parse_protocol(input, "fuzz.json");
  if (!protocol) {
    require(protocol.error().what.starts_with("fuzz.json:"), "a refusal without a place");
    return require_good_message(protocol.error());
  }
  const auto environment = bind_parameters(*protocol, {});
  require(environment.has_value(), environment ? "" : environment.error().what);
  plan_it(*protocol, *environment);
}

}  // namespace lcrig::fuzz
