// SPDX-License-Identifier: Apache-2.0
// Finds when the samples of a simulated frame first contradicted the truth, the orders or
// themselves, independently of the product. From the product it takes only the numbers that the
// plan prints (`watch`), and these are what is judged. Used by the judge of lies.
#pragma once

#include <optional>

#include "tests/property/orders.hpp"
#include "tests/property/trial.hpp"

namespace lcrig::property {

// The figures as the plan prints them. The run prints them again once it knows the cell better
// (event `watch`).
struct PrintedWatch {
  PrintedWatch() = default;
  std::optional<double> frozen_force_s;
  double stall_s = 0, against_m = 0, standing_m = 0, order_travel_m = 0, order_force_N = 0;
  double reply_s = 0;
};
std::optional<PrintedWatch> printed_watch(const RigWorld& world, MonoTime at);

struct Contradiction {
  Contradiction() = default;
  MonoTime taken, first;  // when the first false sample was taken, and when it arrived
  MonoTime due;  // STOP must have been sent by then
  double true_N = 0;  // at `taken`
  double speed_m_s = 0, rate_N_s = 0;  // of the motion at that time
};
// nullopt: the lie never became visible, or not for long enough (docs/testing.md).
std::optional<Contradiction> contradiction_of(const Trial& t, const PrintedWatch& w,
                                              std::size_t lie);

}  // namespace lcrig::property
