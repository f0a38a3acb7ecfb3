// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/progress_keeper.hpp"

namespace lcrig {

ProgressKeeper::ProgressKeeper(const RunSetup& setup) {
  progress_.run = setup.run;
  progress_.protocol = setup.protocol.name;
  progress_.specimen = setup.specimen;
  progress_.planned_s = setup.planned.total_s;
  progress_.left_s = setup.planned.total_s;
}

void ProgressKeeper::enter_repeat(std::int64_t repeat, std::int64_t repeats) {
  progress_.repeat = repeat;
  progress_.repeats = repeats;
}

void ProgressKeeper::enter_step(const Step& step) {
  progress_.step_id = step.id;
  progress_.step_kind = kind_of(step);
}

}  // namespace lcrig
