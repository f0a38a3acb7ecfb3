// SPDX-License-Identifier: Apache-2.0
// The corridor of the force: a sample outside it, and a prediction that was exceeded.
#include <fmt/format.h>

#include "protocols/checks/checks.hpp"
#include "protocols/rig/corridor.hpp"

namespace lcrig::checks {

Found force_falls(const RigState& rig, const Sight& sight) {
  const auto& force_N = sight.sample.force_N;
  const auto from_start = edge_from_start(rig, sight.sample.received);
  if (!force_N || !from_start) return std::nullopt;
  const bool below_start = *force_N < from_start->value();
  const bool below_peak = rig.course.fallen >= kTwice.count();
  if (!below_start && !below_peak) return std::nullopt;
  const double before_N = below_peak ? *rig.course.peak_N : rig.frame.order.force_N;
  return fmt::format(
      "the force falls while the frame presses: {:.4f} N after {:.4f} N; the load cell {}, or the "
      "specimen gave way",
      *force_N, before_N,
      below_start ? "is connected the wrong way, lost its zero" : "shows too little");
}

Found force_too_small(const RigState& rig, const Sight& sight) {
  const auto& [travel_m, force_N] = std::pair(sight.sample.travel_m, sight.sample.force_N);
  if (rig.course.pressed.too_small < kTwice.count() || !travel_m || !force_N) return std::nullopt;
  const auto edge = edge_in_contact(rig, sight.sample.received, *travel_m);
  if (!edge) return std::nullopt;
  const Contact::Least& contact = *rig.contact.least;
  return fmt::format(
      "the force does not follow the way into the specimen: {:.4f} N at {:.4f} mm beyond contact, "
      "which was {:.3g} N/mm stiff when it was found and should show {:.3g} N at least; the load "
      "cell shows too little, or the specimen gave way",
      *force_N - rig.course.pressed.zero_N, (*travel_m - contact.travel_m) * 1e3,
      contact.stiffness_N_m * 1e-3, edge->value() - rig.course.pressed.zero_N);
}

Found force_rises(const RigState& rig, const Sight& sight) {
  const auto edge = edge_of_retreat(rig, sight.sample.received);
  if (!edge || !sight.sample.force_N || *sight.sample.force_N <= edge->value()) {
    return std::nullopt;
  }
  return fmt::format(
      "the force rises against the command, which leads away from the specimen: {:.4f} N after "
      "{:.4f} N",
      *sight.sample.force_N, rig.frame.order.force_N);
}

Found prediction_exceeded(const RigState& /*rig*/, const Sight& sight) {
  if (!sight.compared || !sight.compared->exceeded) return std::nullopt;
  return to_json(sight.compared->event<EventKind::overshoot_exceeded>());
}

Found shown_late(const RigState& /*rig*/, const Sight& sight) {
  if (!sight.compared || sight.compared->exceeded) return std::nullopt;
  return to_json(sight.compared->event<EventKind::overshoot>());
}

}  // namespace lcrig::checks
