// SPDX-License-Identifier: Apache-2.0
// Protocols of a few steps, planned on a rig with simple figures. For the tests of the planner.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

#include "protocols/file/parse.hpp"
#include "protocols/plan/plan.hpp"

namespace lcrig {

inline LcrCapabilities meter() {
  LcrCapabilities c;
  c.functions = {LcrFunction::CpD, LcrFunction::CpRp};
  c.frequency_min = 10.0_Hz;
  c.frequency_max = 100.0_kHz;
  c.level_min = 0.01_V;
  c.level_max = 2.0_V;
  c.bias_min = Voltage::from_si(-2);
  c.bias_max = 2.0_V;
  c.average_max = 256;
  c.conversion[0] = std::chrono::milliseconds(65);
  c.conversion[1] = std::chrono::milliseconds(120);
  c.conversion[2] = std::chrono::milliseconds(380);
  return c;
}

// A 4 mm tip on a specimen of 60 N/mm.
inline Rig frame_rig() {
  Rig rig;
  rig.lcr = meter();
  FrameCapabilities& f = rig.frame;
  f.motion = f.force_hold = f.device_stop = f.zero_force = f.zero_travel = true;
  f.force_max = 20.0_N;
  f.speed_min = Velocity::from_si(1e-8);
  f.speed_max = 10.0_mm_s;
  f.travel_min = Length::from_si(-0.1);
  f.travel_max = Length::from_si(0.1);
  f.sample_rate_max_Hz = 1000;
  f.reaction = std::chrono::milliseconds(1);
  f.deceleration = 0.05_m_s2;
  f.force_loop.emplace();
  f.force_loop->approach = 0.1_mm_s;
  f.force_loop->contact = Force::from_si(0.005);
  f.force_loop->rate_max = 10.0_N_s;
  f.force_loop->lag = std::chrono::milliseconds(10);
  f.force_loop->ripple = Force::from_si(0.002);
  f.force_loop->stiffness_max = 1000.0_N_mm;
  rig.expected_contact = Length();
  rig.frame_stiffness_N_m = 60e3;
  rig.pressure.probe_diameter_m = 4e-3;
  rig.compression_m = [](double force) { return force / 60e3; };
  return rig;
}

inline Rig weights_rig() {
  Rig rig = frame_rig();
  rig.frame = FrameCapabilities();
  rig.frame.weights = true;
  rig.frame.travel_channel = false;
  rig.compression_m = nullptr;
  return rig;
}

inline Result<Plan> plan_of(const Protocol& p, const Rig& rig,
                            const ParameterValues& overrides = {}) {
  const auto env = bind_parameters(p, overrides);
  if (!env) return fail(env.error());
  return make_plan(p, *env, rig);
}
inline Result<Plan> shipped(const std::string& name, const Rig& rig,
                            const ParameterValues& overrides = {}) {
  const auto p = load_protocol("protocols/library/" + name + ".json");
  if (!p) return fail(p.error());
  return plan_of(*p, rig, overrides);
}

// A protocol of the steps given, in a rig with motion.
inline std::string with_steps(const std::string& steps, const std::string& aperture = "fast") {
  return R"({"format":"load-protocol/1","name":"t","limits":{"force_N":[-0.2,1.5],"travel_mm":[-5,1]},
"sample":{"lcr":{"function":"Cp-D","frequency_Hz":1000,"level_V":1,"aperture":")" +
         aperture + R"("}},
"steps":[)" +
         steps + R"(],
"finally":[{"id":"clear","do":"ramp","to":{"travel_mm":-5},"speed_mm_s":1,"timeout_s":60}]})";
}
inline Result<Plan> plan_steps(const std::string& steps, const Rig& rig,
                               const std::string& aperture = "fast") {
  const auto p = parse_protocol(with_steps(steps, aperture), "t.json");
  if (!p) throw std::runtime_error(p.error().what);
  return plan_of(*p, rig);
}
inline std::string refusal(const std::string& steps, const Rig& rig,
                           const std::string& aperture = "fast") {
  const auto r = plan_steps(steps, rig, aperture);
  if (r) return "planned";
  EXPECT_EQ(r.error().code, Errc::invalid_request);
  return r.error().what;
}

}  // namespace lcrig
