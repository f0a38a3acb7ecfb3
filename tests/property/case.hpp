// SPDX-License-Identifier: Apache-2.0
// One rig, one protocol, and what happens in the middle of its run: all that is needed to see a
// run again. As text it is a file of tests/property/cases.
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

// What somebody does, or what breaks.
struct Happening : Instant {
  enum class Kind { abort, freeze, shutdown, pause, deaf, silent, unplug };
  Happening() = default;
  Kind kind = Kind::abort;
};
std::string_view to_string(Happening::Kind kind);
bool is_of_link(Happening::Kind kind);

struct Case {
  Case() = default;
  std::string property;  // that it was made for
  std::uint64_t rig = 1;
  std::uint32_t without = 0;  // quirks that are left out
  std::optional<sim::Lie> lie;  // of what is told of the rig
  std::optional<double> gap_m;
  bool is_within = true;  // of what the rig can do, by our own arithmetic
  std::string protocol;
  std::vector<Happening> happenings;
  std::vector<Falsehood> lies;  // of the frame
  std::string fault_script;  // docs/faults.md

  sim::RandomRig make_rig() const;
};

std::string to_json_text(const Case& c);
Case parse_case(const std::string& text);  // throws

}  // namespace lcrig::property
