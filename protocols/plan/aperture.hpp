// SPDX-License-Identifier: Apache-2.0
// "aperture": "auto": how long the meter may take for a conversion. Used by make_plan.
#pragma once

#include <optional>
#include <string>

#include "protocols/plan/check.hpp"

namespace lcrig {

struct ApertureChoice {
  Aperture aperture = Aperture::medium;
  std::string note;
};
// The file's aperture, or for "auto" the slowest one that every `measure` and the loaded part of a
// continuous recording allow.
ApertureChoice choose_aperture(const Protocol& protocol, const Environment& environment,
                               const Rig& rig);

// Seconds that a move to `force_N` at `speed` spends between contact and target; nullopt without an
// estimate of the compression.
std::optional<double> loaded_time_s(double force_N, double speed_m_s, const Rig& rig);

}  // namespace lcrig
