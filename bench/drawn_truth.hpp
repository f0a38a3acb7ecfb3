// SPDX-License-Identifier: Apache-2.0
// The true values of a rehearsed run, from what its bench drew and from the specimen's curve. No
// estimator takes part. For bench/realistic.cpp.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/analysis.hpp"
#include "model/bench_world.hpp"

namespace lcrig::worlds {

// What this rig would show without noise, drift and differences between loadings, and the
// specimen's own value.
struct Truths {
  double of_rig = 0, own = 0;
};

// True values by the name of a metric; sensitivities are called "slope 0-30 kPa". C0, noise and
// drift are always there. For levels there are also their slopes, the change to the highest level,
// the dynamic range, the repeatability and the limit of detection.
//
// `world` is that of the run. Pressures are the measured ones, because a result refers to them.
// `drawn` is the JSON that the run stored.
std::map<std::string, Truths> drawn_truths(const RunData& data, const RunAnalysis& analysis,
                                           const BenchWorld& world, const nlohmann::json& drawn);

}  // namespace lcrig::worlds
