// SPDX-License-Identifier: Apache-2.0
// The plan of a protocol, made without instruments: what it will do, how long it takes, how far it
// moves, the largest force at worst, and whether limits and instruments allow it. A session makes a
// plan before each run; `lcrig protocol plan`, the queue and the budget show or use plans.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "protocols/plan/advice.hpp"
#include "protocols/plan/check.hpp"
#include "protocols/plan/read_backs.hpp"
#include "protocols/rig/tolerances.hpp"

namespace lcrig {

// One step of the file; loops are summarised.
struct PlannedStep {
  std::string id, kind;
  double start_s = 0;  // of its first execution
  double duration_s = 0;  // of its first execution
  std::int64_t times = 0;
  double total_s = 0;  // of all executions
  std::string note;  // what was chosen or assumed, and why; of the first execution
  bool in_finally = false;
  bool by_hand = false;  // a person is needed
};

// How far the shown force may be from the true one.
struct ForceUncertainty {
  double class_N = 0;  // error that the cell's class allows at the limit
  double zero_N = 0;  // error of the zero that the class allows
  double noise_N = 0;  // four standard deviations of a sample; 0: unknown
  double total_N() const { return class_N + zero_N + noise_N; }
};

// Places where `lcrig stop --after` and `lcrig pause --at` may end a run.
struct PlannedPlaces {
  std::int64_t steps = 0, levels = 0, cycles = 0, repeats = 0;
  std::vector<std::pair<std::string, std::int64_t>> safe_points;  // step ids, with how often each
                                                                  // runs
};

struct Plan {
  BoundLimits limits;
  LcrSettings lcr;  // at the start, with the chosen aperture
  std::string aperture_note;  // how the aperture was calculated
  double frame_rate_Hz = 0;  // of the samples: from the file, or the fastest of the frame
  double duration_s = 0;  // including `finally`
  double hand_s = 0;  // the part for which a person is needed
  std::int64_t measure_readings = 0;  // planned fresh readings of `measure` steps
  PlannedReadBacks read_backs;
  std::int64_t lcr_readings = 0, frame_samples = 0;  // approximate numbers of recorded rows
  double peak_force_N = 0;  // largest commanded or expected force, without overshoot
  double overshoot_N = 0;  // largest overshoot that the specimen's model expects
  // Largest force on the specimen for the stiffest possible contact; the same if link or host are
  // lost meanwhile; and how far the frame then moves on by itself.
  double worst_force_N = 0, lost_force_N = 0, lost_way_m = 0;
  bool weights = false;  // placed by hand: no load cell and no drive that could fail
  ForceUncertainty force_uncertainty;  // of the load cell
  Tolerances watch;  // what the run will distrust
  // The force, possibly beyond every limit, by the time a fault is noticed: a frozen cell, or a
  // drive that reverses where the force is largest. Infinite: unbounded.
  std::optional<double> frozen_force_N, reversed_force_N;
  double travel_min_m = 0, travel_max_m = 0;  // range of machine travel; 0 0 without motion
  bool travel_from_contact = false;  // the range counts from contact, whose place is unknown
  std::int64_t bytes = 0;  // approximate size in the database
  PlannedPlaces places;  // not counting `finally`
  PressureArea pressure;  // what its pressures are over
  std::vector<std::string> assumptions;
  std::vector<PlannedStep> steps;
};

struct PlanRefused {
  std::string pointer, id;
  Refusal refusal;
};

// Errors: invalid_request, "FILE:LINE:COL /pointer (step id): reason with its arithmetic, and what
// to change". `refused`, if given, gets the parts of that message.
Result<Plan> make_plan(const Protocol& protocol, const Environment& environment, const Rig& rig,
                       PlanRefused* refused = nullptr);
// The same checks without the plan.
Result<> check_protocol(const Protocol& protocol, const Environment& environment, const Rig& rig);

// The form that `lcrig protocol plan --json` prints (docs/cli-json.md).
nlohmann::json to_json(const Plan& plan);

}  // namespace lcrig
