// SPDX-License-Identifier: Apache-2.0
// What a person states about a frame (config file, docs/config-file.md), together with what its
// gateway states in CAPS. Where both state a value, the worse one counts. Used by the daemon.
#pragma once

#include <string>
#include <vector>

#include "drivers/load_frame.hpp"

namespace lcrig {

struct StatedFrame {
  std::optional<ForceClass> force_class;
  std::optional<ForceLoop> force_loop;
  std::optional<Length> travel_step;
  std::optional<Force> force_step;
  std::optional<Duration> filter;
  std::optional<Length> play;
};

struct CountedCapabilities {
  FrameCapabilities capabilities;
  std::vector<std::string> differences;  // a sentence with both values for each one that differs
};
CountedCapabilities count_the_worse(FrameCapabilities by_gateway, const StatedFrame& by_person);

// Keys of the config file for what neither states, where no default has a source
// (docs/config-file.md).
std::vector<std::string> missing_statements(const FrameCapabilities& counted);

}  // namespace lcrig
