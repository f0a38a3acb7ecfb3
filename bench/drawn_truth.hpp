// SPDX-License-Identifier: Apache-2.0
// Truths of a rehearsed run from what its bench drew and from the specimen's curve, without any
// estimator. For bench/realistic.cpp.
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

// By the name of a metric; sensitivities as "slope 0-30 kPa". Always C0, noise and drift. Of levels
// also their slopes, the change to the highest of them, the dynamic range, the repeatability and
// the limit of detection.
//
// `world` is that of the run; its pressures are taken as they were measured, because a result
// refers to them. `drawn` is the JSON that the run stored.
std::map<std::string, Truths> drawn_truths(const RunData& data, const RunAnalysis& analysis,
                                           const BenchWorld& world, const nlohmann::json& drawn);

}  // namespace lcrig::worlds
