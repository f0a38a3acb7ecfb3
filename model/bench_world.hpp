// SPDX-License-Identifier: Apache-2.0
// The world behind a simulated bench: one specimen under a probe, which all instruments of the
// bench share. The simulated daemon, lcrig-sim and two benchmarks use it.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "model/auto_level.hpp"
#include "model/bench_errors.hpp"
#include "model/plant.hpp"
#include "model/response.hpp"

namespace lcrig {

class BenchWorld {
 public:
  // Tabulates the specimen from 0 to max_force at the cheapest level whose relative error in delta
  // C is within `tolerance`, and mounts it according to `mounting`. With `scope` the bench has the
  // errors of a real one, drawn from the mounting's seed. Lasting errors are drawn from `rig_seed`,
  // if there is one. Errors: as choose_level and make_response; the probe presses only a part of
  // the disc (nullopt: the diameter is not known).
  static Result<std::unique_ptr<BenchWorld>> make(const Specimen& specimen,
                                                  std::optional<double> probe_diameter_m,
                                                  double tolerance, Force max_force,
                                                  PlantConfig mounting,
                                                  std::optional<ErrorScope> scope = {},
                                                  std::optional<std::uint64_t> rig_seed = {});

  Plant& plant() { return plant_; }
  const Plant& plant() const { return plant_; }
  // What the meter is shown at that instant: the plant's values with the errors of the bench.
  Electrical electrical(MonoTime t);
  const std::optional<BenchErrors>& errors() const { return errors_; }
  const LevelChoice& level() const { return level_; }
  const TabulatedResponse& response() const { return *response_; }
  // Drive travel beyond contact, m, that produces a force. The function may outlive the world.
  std::function<double(double force_N)> compression_m() const;

 private:
  BenchWorld(LevelChoice level, std::shared_ptr<const TabulatedResponse> response,
             PlantConfig mounting, std::optional<BenchErrors> errors);

  std::optional<BenchErrors> errors_;
  LevelChoice level_;
  std::shared_ptr<const TabulatedResponse> response_;
  Plant plant_;
};

}  // namespace lcrig
