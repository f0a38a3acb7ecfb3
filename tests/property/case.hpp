// SPDX-License-Identifier: Apache-2.0
// One rig, one protocol, and what happens in the middle of its run: enough to repeat a run exactly.
// The files of tests/property/cases are cases as text. Used by all property tests.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/property/dice.hpp"
#include "tests/property/falsehood.hpp"
#include "tests/support/rig_world.hpp"
#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

// An interruption by somebody, or a fault of the link.
struct Happening : Instant {
  // after_...: a stop that waits for the end of what is in progress.
  enum class Kind {
    abort,
    freeze,
    shutdown,
    pause,
    deaf,
    silent,
    unplug,
    after_step,
    after_level,
    after_cycle,
    after_repeat
  };
  Happening() = default;
  Kind kind = Kind::abort;
};
std::string_view to_string(Happening::Kind kind);
bool is_of_link(Happening::Kind kind);

struct Case {
  Case() = default;
  std::string property;  // the property it was made for
  std::uint64_t rig = 1;
  std::uint32_t without = 0;  // sim::RandomRig quirks that are left out
  std::optional<sim::Lie> lie;  // lie about the facts that are told of the rig
  std::optional<double> gap_m;
  bool is_within = true;  // our own arithmetic says that the rig can carry it out
  std::string protocol;
  std::vector<Happening> happenings;
  std::vector<Falsehood> lies;  // told by the frame
  std::string fault_script;  // docs/faults.md

  sim::RandomRig make_rig() const;
};

std::string to_json_text(const Case& c);
Case parse_case(const std::string& text);  // throws

}  // namespace lcrig::property
