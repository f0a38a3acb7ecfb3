// SPDX-License-Identifier: Apache-2.0
// A sine in the readings that no specimen makes: the meter's beat with the mains. Private to
// analysis/.
#pragma once

#include <optional>
#include <string>

#include "analysis/metrics.hpp"

namespace lcrig {

// Looks in the stretches in which the load rests: the baseline, the levels, the later halves of
// rests. Of each only what differs from its mean counts, and of levels and rests only what is
// neither alike in all of them nor proportional to the capacitance of the level, so that creep and
// recovery are no sine. nullopt: there is none, or the run is too short or too long to tell.
std::optional<Hum> find_hum(const RunView& view, const Rests& rests,
                            const MeasuredLevels& measured);

// The run with the sine subtracted from every reading.
RunData without(const Hum& hum, const RunData& data);

std::string note_on(const Hum& hum);

}  // namespace lcrig
