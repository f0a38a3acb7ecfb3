// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "protocols/plan/aperture.hpp"
#include "protocols/plan/planner.hpp"

namespace lcrig {

namespace {

// Approximate size of rows with their indexes and keys. A reading has texts and three times.
constexpr double kBytesPerReading = 120, kBytesPerSample = 56, kBytesPerRun = 100e3;

// Cuts figures that exceed an integer: a file may plan for longer than anybody lives.
std::int64_t whole(double value) {
  constexpr double kMost = 9e18;
  return static_cast<std::int64_t>(std::min(value, kMost));
}

nlohmann::json finite(std::optional<double> value) {
  return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

// Adds line and column: the plan knows only the JSON pointer.
Error placed(const Protocol& protocol, const PlanRefused& refused) {
  TextPosition at;
  if (const auto doc = JsonDocument::parse(protocol.text, protocol.file)) {
    at = doc->value_position(refused.pointer);
  }
  return Error(Errc::invalid_request,
               fmt::format("{}:{}:{} {} ({}): {}", protocol.file, at.line, at.column,
                           refused.pointer, refused.id, refused.refusal.text()));
}

void estimate_size(const Protocol& protocol, const Rig& rig, Plan& plan) {
  const double interval = reading_interval_s(plan.lcr, rig.lcr);
  plan.lcr_readings = plan.measure_readings;
  if (protocol.sample.lcr_continuous && interval > 0) {
    plan.lcr_readings = std::max(plan.lcr_readings, whole(plan.duration_s / interval));
  }
  const bool sampled = rig.frame.force_channel || rig.frame.travel_channel;
  if (sampled && rig.frame.sample_rate_max_Hz > 0) {
    plan.frame_samples = whole(plan.duration_s * plan.frame_rate_Hz);
  }
  plan.bytes = whole(kBytesPerRun + kBytesPerReading * static_cast<double>(plan.lcr_readings) +
                     kBytesPerSample * static_cast<double>(plan.frame_samples));
}

// One walk through the protocol. Errors: the limits contradict each other.
Result<std::optional<PlanRefused>> walk(const Protocol& protocol, const Environment& environment,
                                        const Rig& rig, Plan& plan) {
  const auto limits = bind_limits(protocol, environment, rig.frame);
  if (!limits) return fail(limits.error());
  const ApertureChoice choice = choose_aperture(protocol, environment, rig);
  plan.limits = *limits;
  plan.lcr = protocol.sample.lcr;
  plan.lcr.aperture = choice.aperture;
  plan.read_backs = PlannedReadBacks(rig.lcr);
  plan.aperture_note = choice.note;
  Environment values = environment;  // the walk sets and removes sweep variables
  Planner planner(protocol, values, rig, *limits, plan);
  planner.walk();
  return planner.refused();
}

// False: some change is not of a parameter, so the file itself must be changed.
bool apply(const std::vector<Change>& changes, const Protocol& protocol, Environment& values) {
  for (const Change& c : changes) {
    const auto it = protocol.parameters.find(c.place);
    if (!c.parameter || it == protocol.parameters.end()) return false;
    values.set(c.place, c.value * it->second.to_si);
  }
  return true;
}

void merge(const std::vector<Change>& more, std::vector<Change>& all) {
  for (const Change& c : more) {
    const auto same = [&c](const Change& one) { return one.place == c.place; };
    const auto it = std::ranges::find_if(all, same);
    if (it == all.end()) {
      all.push_back(c);
    } else {
      *it = c;
    }
  }
}

// The value that a refusal proposes may be refused by a later step. This plans with the proposal
// and adds further changes until the plan is accepted, or says why it cannot be.
void complete(const Protocol& protocol, Environment values, const Rig& rig, Refusal& refusal) {
  constexpr int kMostRounds = 8;
  std::vector<Change> all = refusal.changes, last = all;
  bool further = false;  // the first change was not sufficient
  for (int round = 0; round < kMostRounds; ++round) {
    if (last.empty() || !apply(last, protocol, values)) break;
    Plan changed;
    const auto again = walk(protocol, values, rig, changed);
    if (!again) return;
    if (!*again) break;
    last = (*again)->refusal.changes;
    merge(last, all);
    further = further || !last.empty();
    if (last.empty()) {
      refusal.why += fmt::format("; changed so, {}: {}", (*again)->pointer, (*again)->refusal.why);
    }
  }
  if (further) refusal.why += "; a further check asks for more";
  refusal.changes = std::move(all);
}

nlohmann::json places_json(const PlannedPlaces& p) {
  nlohmann::json safe_points = nlohmann::json::array();
  for (const auto& [id, times] : p.safe_points) {
    safe_points.push_back({{"id", id}, {"times", times}});
  }
  return {{"steps", p.steps},
          {"levels", p.levels},
          {"cycles", p.cycles},
          {"repeats", p.repeats},
          {"safe_points", std::move(safe_points)}};
}

nlohmann::json pressure_json(const Plan& plan) {
  nlohmann::json out = to_json(plan.pressure);
  const auto area_m2 = plan.pressure.area_m2(), on_disc = plan.pressure.on_disc();
  const auto peak_kPa = area_m2 ? std::optional(plan.peak_force_N / *area_m2 * 1e-3) : std::nullopt;
  out["peak_kPa"] = peak_kPa ? nlohmann::json(*peak_kPa) : nlohmann::json();
  out["peak_on_disc_kPa"] =
      peak_kPa && on_disc ? nlohmann::json(*peak_kPa * *on_disc) : nlohmann::json();
  return out;
}

}  // namespace

Result<Plan> make_plan(const Protocol& protocol, const Environment& environment, const Rig& given,
                       PlanRefused* refused) {
  const Rig rig = rig_for(protocol, given);
  if (aims_at_pressure(protocol.steps)) {
    if (auto known = require_area(rig.pressure); !known) {
      return fail(known.error().code, "{}: {}", protocol.name, known.error().what);
    }
  }
  Plan plan;
  plan.pressure = rig.pressure;
  auto found = walk(protocol, environment, rig, plan);
  if (!found) return fail(found.error());
  if (*found) {
    complete(protocol, environment, rig, (*found)->refusal);
    if (refused != nullptr) *refused = **found;
    return fail(placed(protocol, **found));
  }
  if (rig.pressure.presses_part() && rig.compression_m) {
    plan.assumptions.emplace_back(
        "the specimen gives way as if its whole disc were pressed: the probe presses a part of it");
  }
  estimate_size(protocol, rig, plan);
  return plan;
}

Result<> check_protocol(const Protocol& protocol, const Environment& environment, const Rig& rig) {
  if (const auto plan = make_plan(protocol, environment, rig); !plan) return fail(plan.error());
  return {};
}

nlohmann::json to_json(const Plan& plan) {
  nlohmann::json steps = nlohmann::json::array();
  for (const PlannedStep& s : plan.steps) {
    steps.push_back({{"id", s.id},
                     {"do", s.kind},
                     {"start_s", s.start_s},
                     {"duration_s", s.duration_s},
                     {"times", s.times},
                     {"total_s", s.total_s},
                     {"in_finally", s.in_finally},
                     {"by_hand", s.by_hand},
                     {"note", s.note}});
  }
  nlohmann::json uncertainty, parts;
  if (!plan.weights) {
    uncertainty = plan.force_uncertainty.total_N();
    parts = {{"class_N", plan.force_uncertainty.class_N},
             {"zero_N", plan.force_uncertainty.zero_N},
             {"noise_N", plan.force_uncertainty.noise_N}};
  }
  return {{"duration_s", plan.duration_s},
          {"hand_s", plan.hand_s},
          {"measure_readings", plan.measure_readings},
          {"lcr_readings", plan.lcr_readings},
          {"frame_samples", plan.frame_samples},
          {"frame_rate_Hz", plan.frame_rate_Hz},
          {"peak_force_N", plan.peak_force_N},
          {"overshoot_N", plan.overshoot_N},
          {"force_max_N", plan.limits.force_max_N},
          {"worst_force_N", plan.worst_force_N},
          {"worst_force_without_link_N", plan.lost_force_N},
          {"way_without_link_mm", plan.lost_way_m * 1e3},
          {"weights", plan.weights},
          {"force_uncertainty_N", std::move(uncertainty)},
          {"force_uncertainty", std::move(parts)},
          {"watch", plan.weights ? nlohmann::json() : to_json(plan.watch)},
          {"worst_force_frozen_N", finite(plan.frozen_force_N)},
          {"worst_force_reversed_N", finite(plan.reversed_force_N)},
          {"travel_from", plan.travel_from_contact ? "contact" : "machine"},
          {"travel_mm", {plan.travel_min_m * 1e3, plan.travel_max_m * 1e3}},
          {"database_bytes", plan.bytes},
          {"aperture", to_string(plan.lcr.aperture)},
          {"aperture_note", plan.aperture_note},
          {"read_back", to_json(plan.read_backs)},
          {"stop_places", places_json(plan.places)},
          {"pressure", pressure_json(plan)},
          {"assumptions", plan.assumptions},
          {"steps", std::move(steps)}};
}

}  // namespace lcrig
