// SPDX-License-Identifier: Apache-2.0
// Chooses the aperture for "aperture": "auto" by how long a conversion may take. Used by make_plan.
#pragma once

#include <optional>
#include <string>

#include "protocols/plan/check.hpp"

namespace lcrig {

struct ApertureChoice {
  Aperture aperture = Aperture::medium;
  std::string note;
};
// The aperture of the file; for "auto" the slowest one that allows every `measure` step and enough
// readings in the loaded part of a continuous recording.
ApertureChoice choose_aperture(const Protocol& protocol, const Environment& environment,
                               const Rig& rig);

// Seconds that a move to `force_N` spends between contact and target; nullopt without an estimate
// of the compression.
std::optional<double> loaded_time_s(double force_N, double speed_m_s, const Rig& rig);

}  // namespace lcrig
