// SPDX-License-Identifier: Apache-2.0
// Draws runs of specimens whose modulus is known, for the coverage of `lcrig model fit`. The laws,
// the creep and the hysteresis are written down here in closed form; nothing of model/ or analysis/
// takes part in the truth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/run_data.hpp"
#include "model/level.hpp"

namespace lcrig::fit_worlds {

enum class Law {
  neo_hookean,  // incompressible, free: P = mu (1/stretch^2 - stretch)
  spring,  // the layers shorten by P/E
};
enum class CreepKind { none, logarithmic, exponential };

struct FitWorld {
  std::string name;
  Law law = Law::neo_hookean;
  bool exact = false;  // the law holds: nothing may be refused
  CreepKind creep = CreepKind::none;
  double creep_limit = 0;  // of the load, in all of the run; drawn from 0 to this
  double hysteresis_limit = 0;  // of the span, in the middle; drawn from 0 to this
  double thickness_limit = 0;  // of the soft layers, relative; drawn within +-
  double noise_fF = 0.44;  // of one reading
  double slope_sd = 0;  // between repeats
  double gain_limit = 0;  // of the meter
  double drift_fF_h = 0;
  bool both_ways = false;  // levels up and down; otherwise up only
};

// What the specimen is, and what is told of it.
struct FitDraw {
  RunData data;
  Specimen specimen;  // as its file says
  LevelSettings settings;
  // Where the branches differ, it is drawn whether the loading branch or the middle of both obeys
  // the law with this modulus.
  double mu_Pa = 0;
  std::string drawn;  // in words
};
FitDraw draw(const FitWorld& world, std::uint64_t seed);

std::vector<FitWorld> fit_worlds();

}  // namespace lcrig::fit_worlds
