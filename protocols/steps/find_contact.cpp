// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/find_contact.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/clock.hpp"
#include "base/text.hpp"
#include "protocols/contact/contact_search.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_motion.hpp"

namespace lcrig {

namespace {

constexpr Range kBackOff{0, 1};  // m
constexpr Range kWays{0, 10, true};

// The way to the end of the limits or of the machine; the machine's whole range if the present
// travel is unknown.
double window_m(const PlannedRig& rig) {
  const FrameCapabilities& caps = rig.frame();
  const double machine = caps.travel_max.si();
  const double end = std::min(rig.limits().travel_max_m.value_or(machine), machine);
  const bool known = rig.known().start_travel || rig.known().expected_contact;
  return known ? std::max(0.0, end - rig.travel_m()) : machine - caps.travel_min.si();
}

// Refuses a threshold that noise alone can reach.
void check_threshold(const Number& force, const PlannedRig& rig, StepPlan& out) {
  const double noise = force_noise_N(rig.known()).value_or(0), rise = rig.get(force);
  const double least = kNoiseSigmas * noise;
  if (!exceeds(least, rise)) return;
  out.refuse(
      Refusal(fmt::format("contact at {:.3g} N, but the load cell scatters by {:.3g} N (standard "
                          "deviation) while it rests: at least {:.3g} N, {:.0f} times that",
                          rise, noise, least, kNoiseSigmas.value),
              at_least(force, 1.05 * least, rig.asked())));
}

}  // namespace

FindContactStep FindContactStep::parse(const StepReader& r) {
  FindContactStep out;
  out.speed = r.required("speed", Dimension::speed, kSpeeds);
  out.force = r.required("force", Dimension::force, kPositiveForces);
  out.back_off = r.required("back_off", Dimension::length, kBackOff);
  out.timeout = r.timeout();
  out.within = r.optional("within", Dimension::length, kWays);
  out.overshoot = r.optional("overshoot", Dimension::force, kPositiveForces);
  out.slow_down = r.json.optional_boolean("slow_down").value_or(false);
  return out;
}

double FindContactStep::search_speed_m_s(const Environment& env, const Forecast& forecast,
                                         double room_N, double slowest_m_s) const {
  const double v = env.get(speed), rise = env.get(force);
  if (!slow_down) return v;
  const double fastest = forecast.fastest_m_s(rise, rise + 0.5 * room_N);
  return std::max(std::min(v, fastest), std::min(v, slowest_m_s));
}

StepPlan FindContactStep::plan(PlannedRig& rig) const {
  StepPlan out;
  PlannedMotion motion(rig, timeout, out);
  check_threshold(force, rig, out);
  rig.use_speed(speed, out);
  const double rise = rig.get(force), back = rig.get(back_off), most = rig.get(speed);
  const double v = search_speed_m_s(rig.environment(), rig.forecast(),
                                    rig.limits().force_max_N - rise, rig.frame().speed_min.si());
  if (v < most) add_remark(out.note, fmt::format("slowed down to {:.3g} mm/s", v * 1e3));
  const double approach = std::max(0.0, rig.contact_m() - rig.travel_m());
  if (rig.contact() == PlannedRig::Contact::unknown && approach > 0) {
    add_remark(out.note, fmt::format("assumes a gap of {:.3g} mm", approach * 1e3));
  }
  double longest = std::min(window_m(rig), v * rig.get(timeout));
  if (within) longest = std::min(longest, rig.get(*within));
  add_remark(out.note, fmt::format("searches at most {:.4g} mm", longest * 1e3));
  out.seconds = approach / v + back / most + kSearchStop_s;
  rig.begin_search();
  rig.go_to_force(rise, &force, out);
  motion.search(approach);
  motion.slow_to(v);
  motion.check_stop(rise, speed, overshoot);
  motion.check_timeout();
  rig.find_contact(rise, v);
  rig.go_to_travel(rig.travel_at(rise), nullptr, out);
  rig.go_to_travel(rig.contact_m() - back, nullptr, out);
  rig.unload();
  return out;
}

Task<Result<>> FindContactStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  ContactSearch contact(run, *this);
  co_return co_await contact.find(progress.start_travel_m);
}

}  // namespace lcrig
