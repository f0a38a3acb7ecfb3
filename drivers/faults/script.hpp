// SPDX-License-Identifier: Apache-2.0
// The fault script `faults/1`, which says what goes wrong on a simulated bench and when. Played by
// FaultPlayer. Described in docs/faults.md; the schema is schema/faults.schema.json.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "drivers/faults/kinds.hpp"

namespace lcrig {

struct Fault {
  const FaultKind* kind = nullptr;  // set in every parsed script
  std::string where;  // "FILE:LINE:COLUMN /faults/0", for messages

  // When, in seconds of the rig's clock since the start of the run (or of lcrig-sim) or of a step.
  std::optional<double> at_s;
  std::optional<std::string> in_step;  // id or kind of a step, or "finally"
  double after_s = 0;
  std::optional<double> every_s, for_s;
  std::optional<std::int64_t> every, times;
  std::optional<double> probability;

  // Parameters. docs/faults.md says which fault takes which.
  double delay_s = 0, factor = 1, byte_probability = 0, jump_s = 0, force_N = 0, step_s = 0;
  double rate_N_s = 0, speed_um_s = 0;
  std::int64_t samples = 1;
  std::string text, identity, code = "not_ready";
  PanelKey setting{};
  std::string to;
  bool other_port = false, forgets_zero = false, origin_changes = false;

  bool is(FaultShape shape) const { return kind->shape == shape; }
  bool has_window() const { return at_s || in_step; }
};

struct FaultScript {
  std::string name, text;
  std::uint64_t seed = 1;  // for probabilities
  std::vector<Fault> faults;
};

// Errors: invalid_request with file position and JSON pointer.
Result<FaultScript> parse_fault_script(std::string_view text, const std::string& name);
Result<FaultScript> load_fault_script(const std::string& path);  // also io

// What the bench that plays the script consists of.
struct FaultStage {
  bool has_frame = true;  // false: dead weights
  bool knows_steps = true;  // the script may name steps; false: lcrig-sim
  bool has_surroundings = true;  // disk, wall clock, memory, operator; false: lcrig-sim
};
// Errors: invalid_request, naming the first fault that cannot happen on this bench.
Result<> check_stage(const FaultScript& script, const FaultStage& stage);

// One line for logs and events: "meter reply_late, delay_s 1.5".
std::string describe(const Fault& fault);

}  // namespace lcrig
