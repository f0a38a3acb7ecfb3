// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "protocols/checks/checks.hpp"

namespace lcrig {

namespace {

using namespace checks;

bool is_compared(const RigState& rig) {
  return rig.is_watched() && rig.is_prepared;
}

// Before the first motion the samples are judged by a rest measurement.
bool is_judged(const RigState& rig) {
  return rig.is_prepared || !rig.facts.commands || !rig.facts.frame.motion;
}

constexpr When kMoves{"the frame moves by an order", [](const RigState& rig) {
                        return is_compared(rig) && rig.frame.motion == FrameMotion::moving;
                      }};
constexpr When kStands{"the frame reported that it stands", [](const RigState& rig) {
                         return is_compared(rig) && rig.frame.motion == FrameMotion::standing;
                       }};
constexpr When kKnown{"the frame moves by an order, or stands", [](const RigState& rig) {
                        return is_compared(rig) && rig.frame.motion != FrameMotion::unknown;
                      }};
constexpr When kCommanded{"the run commands the frame", is_compared};
constexpr When kSends{"the frame has to send samples",
                      [](const RigState& rig) { return rig.watches_age; }};
constexpr When kPredicts{"a motion pressed",
                         [](const RigState& rig) { return rig.forecast.has_value(); }};
constexpr When kSteps{"during the steps", [](const RigState& rig) {
                        return is_judged(rig) && rig.phase == RunPhase::steps;
                      }};
constexpr When kFinally{"during the retreat of `finally`", [](const RigState& rig) {
                          return is_judged(rig) && rig.phase == RunPhase::finally;
                        }};

constexpr EventKind kContradiction = EventKind::contradiction;

// name, when it applies, what it looks at, what is then in doubt, the response, the event
constexpr std::array kChecks{
    Check{"frozen_digits", kKnown, "equal forces one after another", Doubt::force,
          Response::stop_and_retreat, kContradiction, frozen_digits},
    Check{"place_after_motion", kKnown, "the travel after a motion, and the reported place",
          Doubt::standstill, Response::stop, kContradiction, place_after_motion},
    Check{"moves_at_standstill", kStands, "the corridor of the travel, and the flag of motion",
          Doubt::standstill, Response::stop, kContradiction, moves_at_standstill},
    Check{"force_jumps", kStands, "the medians of the force, 1 s apart", Doubt::force,
          Response::stop_and_retreat, kContradiction, force_jumps},
    Check{"against_order", kMoves, "the corridor of the travel, near edge", Doubt::drive,
          Response::lock_out, kContradiction, against_order},
    Check{"ahead_of_order", kMoves, "the corridor of the travel, far edge", Doubt::drive,
          Response::lock_out, kContradiction, ahead_of_order},
    Check{"force_falls", kMoves, "the corridor of the force, lower edge of an approach",
          Doubt::force, Response::stop_and_retreat, kContradiction, force_falls},
    Check{"force_rises", kMoves, "the corridor of the force, upper edge of a retreat", Doubt::drive,
          Response::lock_out, kContradiction, force_rises},
    Check{"force_too_small", kMoves, "the corridor of the force, lower edge in a contact",
          Doubt::force, Response::stop_and_retreat, kContradiction, force_too_small},
    Check{"stalls", kMoves, "the way, in quarters of the time for progress", Doubt::drive,
          Response::lock_out, kContradiction, stalls},
    Check{"loop_without_force", kMoves, "the way of a force loop, and the force on it",
          Doubt::force, Response::stop_and_retreat, kContradiction, loop_without_force},
    Check{"loop_runs_away", kMoves, "the way of a force loop, and its distance from its set point",
          Doubt::drive, Response::lock_out, kContradiction, loop_runs_away},
    Check{"sign_changed", kCommanded, "a force below its limit, and the one before", Doubt::force,
          Response::stop_and_retreat, kContradiction, sign_changed},
    Check{"pulls_without_retreat", kCommanded, "a force below its limit, and the direction",
          Doubt::force, Response::stop_and_retreat, kContradiction, pulls_without_retreat},
    Check{"prediction_exceeded", kPredicts,
          "the largest force of a motion, and the corridor's upper edge", Doubt::prediction,
          Response::no_pressing, EventKind::overshoot_exceeded, prediction_exceeded},
    Check{"shown_late", kPredicts, "the force that the cell shows after a motion", Doubt::nothing,
          Response::note, EventKind::overshoot, shown_late},
    Check{"beyond_cell", kSteps, "the flag of an overload", Doubt::nothing, Response::stop,
          EventKind::limit, beyond_cell},
    Check{"force_limit", kSteps, "the force, and the limits", Doubt::nothing, Response::stop,
          EventKind::limit, force_limit},
    Check{"no_travel", kSteps, "the age of the last travel", Doubt::nothing, Response::stop,
          EventKind::limit, no_travel},
    Check{"travel_limit", kSteps, "the travel, and the limits of travel and gap", Doubt::nothing,
          Response::stop, EventKind::limit, travel_limit},
    Check{"blind_retreat", kFinally, "the travel, while no force counts", Doubt::nothing,
          Response::stop, EventKind::limit, blind_retreat},
    Check{"force_on_retreat", kFinally, "the force, and the largest one of the run", Doubt::nothing,
          Response::stop, EventKind::limit, force_on_retreat},
    Check{"travel_on_retreat", kFinally, "the travel, and the limits", Doubt::nothing,
          Response::stop, EventKind::limit, travel_on_retreat},
    Check{"no_force", kSends, "the age of the last force", Doubt::link, Response::lose,
          EventKind::loss, nullptr, no_force},
};

}  // namespace

std::span<const Check> all_checks() {
  return kChecks;
}

std::vector<Finding> find(const RigState& rig, const Sight& sight) {
  std::vector<Finding> out;
  for (const Check& check : kChecks) {
    if (check.find == nullptr || !check.when.holds(rig)) continue;
    if (auto why = check.find(rig, sight)) out.emplace_back(check, std::move(*why));
  }
  return out;
}

std::optional<Finding> find_silence(const RigState& rig, MonoTime now) {
  for (const Check& check : kChecks) {
    if (check.find_by_clock == nullptr || !check.when.holds(rig)) continue;
    if (auto why = check.find_by_clock(rig, now)) return Finding(check, std::move(*why));
  }
  return std::nullopt;
}

const Finding* most_severe(std::span<const Finding> findings) {
  const auto severity = [](const Finding& f) { return f.check->response; };
  const auto most = std::ranges::max_element(findings, {}, severity);
  return most != findings.end() && severity(*most) > Response::no_pressing ? &*most : nullptr;
}

}  // namespace lcrig
