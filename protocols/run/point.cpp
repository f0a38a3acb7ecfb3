// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/point.hpp"

#include "protocols/expand.hpp"

namespace lcrig {

Result<RunPoint> parse_run_point(std::string_view text) {
  auto point = from_json<RunPoint>(text);
  if (!point) {
    return fail(Errc::garbled, "the stored state of the run does not parse: {}",
                point.error().what);
  }
  if (point->steps_done >= 0 && point->levels >= 0) return point;
  return fail(Errc::garbled, "a state with negative counts");
}

const Step* step_at(const Protocol& protocol, Environment environment, std::int64_t steps_done) {
  StepCursor cursor(protocol.steps, environment);
  const Step* step = cursor.next();
  for (std::int64_t i = 0; i < steps_done && step != nullptr; ++i) step = cursor.next();
  return step;
}

Result<> compare_with_now(const Continuation& from, const Protocol& protocol,
                          const Environment& environment,
                          const std::optional<std::string>& origin) {
  if (!from.point.origin || origin == from.point.origin) return {};
  const Step* step = step_at(protocol, environment, from.point.steps_done);
  const bool own = step != nullptr && facts_of(*step).zeroes;
  return fail(Errc::frame_fault,
              "run {} cannot be continued: the zero of force or travel was lost or changed since "
              "then (origin {}, then it was {}{}); whether its specimen is loaded is not known: "
              "look at the rig, drive the frame away at the machine, begin a new run",
              from.run, origin.value_or("not stated"), *from.point.origin,
              own ? "; it was interrupted while it zeroed" : "");
}

std::int64_t first_step_of(const Protocol& protocol, Environment environment,
                           std::int64_t steps_done) {
  if (!places_weights(protocol.steps)) return steps_done;
  StepCursor cursor(protocol.steps, environment);
  std::int64_t begin = 0;
  for (std::int64_t i = 0; i <= steps_done; ++i) {
    const Step* step = cursor.next();
    if (step == nullptr) break;
    if (facts_of(*step).places_weight) begin = i;
  }
  return begin;
}

}  // namespace lcrig
