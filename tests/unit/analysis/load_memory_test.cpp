// SPDX-License-Identifier: Apache-2.0
// What an element of creep remembers, against the closed form of a ramp that is then held.
#include "analysis/load_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lcrig {
namespace {

constexpr double kRate_N_s = 0.2, kRamp_s = 5, kStart_s = 2;

double force_N(double t_s) {
  return kRate_N_s * std::clamp(t_s - kStart_s, 0.0, kRamp_s);
}

RunData ramp_and_hold() {
  RunData out;
  for (int i = 0; i <= 4000; ++i) {
    FramePoint p;
    p.t_s = i * 0.01;
    p.force_N = static_cast<float>(force_N(p.t_s));
    out.frame.push_back(p);
    ++out.frame_samples;
    if (i % 10 != 5) continue;
    RunReading r;
    r.t_s = p.t_s;
    r.force_N = p.force_N;
    r.present = 1;
    r.capacitance_F = 3e-12;
    out.readings.push_back(r);
  }
  out.duration_s = 40;
  out.rest_force_N = 0;
  return out;
}

// q' = (P - q)/time for the ramp, then decay towards the held force.
double element_N(double t_s, double time_s) {
  const double ramp_s = std::min(t_s - kStart_s, kRamp_s);
  if (ramp_s <= 0) return 0;
  const double q = kRate_N_s * (ramp_s - time_s * -std::expm1(-ramp_s / time_s));
  const double held_s = t_s - kStart_s - ramp_s, top = kRate_N_s * ramp_s;
  return top + (q - top) * std::exp(-held_s / time_s);
}

TEST(LoadMemory, FollowsARampAndItsHold) {
  const RunData run = ramp_and_hold();
  const AnalysisOptions options;
  const RunView view = look_at(run, options);
  std::vector<std::size_t> all(run.readings.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const LoadMemory memory(view, 1e5, all);
  ASSERT_GE(memory.times_s().size(), 3U);
  for (const std::size_t i : all) {
    const double t_s = run.readings[i].t_s;
    for (std::size_t k = 0; k < memory.times_s().size(); ++k) {
      EXPECT_NEAR(memory.at(i).memory_Pa[k], 1e5 * element_N(t_s, memory.times_s()[k]), 30) << t_s;
    }
  }
  // The load is within 2 % of 1 N from 6.9 s on.
  const std::size_t late = all.size() - 1;
  EXPECT_NEAR(std::pow(10, memory.at(late).held_decades) - 1, run.readings[late].t_s - 6.95, 0.2);
}

TEST(LoadMemory, WithoutAFrameNothingIsKnown) {
  RunData run = ramp_and_hold();
  run.frame.clear();
  run.frame_samples = 0;
  const AnalysisOptions options;
  const RunView view = look_at(run, options);
  const LoadMemory memory(view, 1e5, {3});
  EXPECT_TRUE(memory.times_s().empty());
  EXPECT_TRUE(memory.at(3).memory_Pa.empty());
}

}  // namespace
}  // namespace lcrig
