// SPDX-License-Identifier: Apache-2.0
// When what a simulated frame showed first contradicted the truth, what was ordered, or itself: by
// our own eyes, from what was witnessed. The only numbers of the product in it are those that its
// plan prints (`watch`), and they are what is judged.
#pragma once

#include <optional>

#include "tests/property/orders.hpp"
#include "tests/property/trial.hpp"

namespace lcrig::property {

// As the plan prints it, and the run again whenever it knows the cell better (event `watch`).
struct PrintedWatch {
  PrintedWatch() = default;
  std::optional<double> frozen_force_s;
  double stall_s = 0, against_m = 0, standing_m = 0, order_travel_m = 0, order_force_N = 0;
  double reply_s = 0;
};
std::optional<PrintedWatch> printed_watch(const RigWorld& world, MonoTime at);

struct Contradiction {
  Contradiction() = default;
  MonoTime taken, first;  // the first sample that is not true: when it was taken, when it arrived
  MonoTime due;  // by then STOP must be on its way
  double true_N = 0;  // when it was taken
  double speed_m_s = 0, rate_N_s = 0;  // in force
};
// nullopt: it showed nowhere, or not for long enough; docs/testing.md
std::optional<Contradiction> contradiction_of(const Trial& t, const PrintedWatch& w,
                                              std::size_t lie);

}  // namespace lcrig::property
