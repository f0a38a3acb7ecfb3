// SPDX-License-Identifier: Apache-2.0
// The plan of a protocol, made without instruments: what it will do, how long, how far, how hard at
// worst, and whether limits and instruments allow it. A session plans before each run; `lcrig
// protocol plan`, the queue and the budget show or use plans.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "protocols/plan/advice.hpp"
#include "protocols/plan/check.hpp"
#include "protocols/watch/watch_figures.hpp"

namespace lcrig {

// One step of the file; loops are summarised.
struct PlannedStep {
  std::string id, kind;
  double start_s = 0;  // of the first time
  double duration_s = 0;  // of the first time
  std::int64_t times = 0;
  double total_s = 0;  // of all times
  std::string note;  // what was chosen or assumed, and why; of the first time
  bool in_finally = false;
  bool by_hand = false;  // a person is needed
};

// How far the force that is shown may be from the true one.
struct ForceUncertainty {
  double class_N = 0;  // of the cell's class, at the limit
  double zero_N = 0;  // of its zero, as the class allows it
  double noise_N = 0;  // four standard deviations of a sample; 0: not known
  double total_N() const { return class_N + zero_N + noise_N; }
};

// Where `lcrig stop --after` and `lcrig pause --at` may end what is under way.
struct PlannedPlaces {
  std::int64_t steps = 0, levels = 0, cycles = 0, repeats = 0;
  std::vector<std::pair<std::string, std::int64_t>> safe_points;  // steps, and how often each runs
};

struct Plan {
  BoundLimits limits;
  LcrSettings lcr;  // at the start, with the aperture that was chosen
  std::string aperture_note;  // the arithmetic behind it
  double frame_rate_Hz = 0;  // of the samples: as the file says, or as fast as the frame can
  double duration_s = 0;  // with `finally`
  double hand_s = 0;  // of it, while a person is needed
  std::int64_t measure_readings = 0;  // planned fresh readings of `measure` steps
  std::int64_t lcr_readings = 0, frame_samples = 0;  // recorded in all, about
  double peak_force_N = 0;  // commanded or expected, without overshoot
  double overshoot_N = 0;  // largest that is expected of the specimen's model
  // Force that the specimen may feel at worst, on the stiffest contact that is not excluded; the
  // same when link or host are lost meanwhile; and how far the frame then goes on by itself.
  double worst_force_N = 0, lost_force_N = 0, lost_way_m = 0;
  bool weights =
      false;  // placed by hand: no load cell, no drive, nothing that either can get wrong
  ForceUncertainty force_uncertainty;  // of the load cell
  WatchFigures watch;  // what the run will not believe
  // Beyond every limit: what is pressed until a frozen cell, or a drive that turned round where
  // the force is largest, has been noticed. Infinite: nothing bounds it.
  std::optional<double> frozen_force_N, reversed_force_N;
  double travel_min_m = 0, travel_max_m = 0;  // envelope of machine travel; 0 0 without motion
  bool travel_from_contact = false;  // ... or counted from contact, where that is not known
  std::int64_t bytes = 0;  // of the database, about
  PlannedPlaces places;  // without `finally`
  std::vector<std::string> assumptions;
  std::vector<PlannedStep> steps;
};

struct PlanRefused {
  std::string pointer, id;
  Refusal refusal;
};

// Errors: invalid_request, "FILE:LINE:COL /pointer (step id): reason with its arithmetic, and
// what to change". The same in parts in `refused`, when it is given.
Result<Plan> make_plan(const Protocol& protocol, const Environment& environment, const Rig& rig,
                       PlanRefused* refused = nullptr);
// The same checks, when only the answer counts.
Result<> check_protocol(const Protocol& protocol, const Environment& environment, const Rig& rig);

// As `lcrig protocol plan --json` prints it (docs/cli-json.md).
nlohmann::json to_json(const Plan& plan);

}  // namespace lcrig
