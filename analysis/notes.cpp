// SPDX-License-Identifier: Apache-2.0
// Notes for the reader of the results: gaps, overloads, assumptions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/level_drift.hpp"
#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

using Notes = std::vector<std::string>;

void add_origin(const RunData& data, Notes& notes) {
  if (data.replayed) {
    const std::string& played = data.row.bench_text;  // empty in runs of older versions
    notes.push_back("a recording was played back through simulated instruments" +
                    (played.empty() ? played : ": " + played));
  } else if (data.row.simulated) {
    notes.emplace_back("simulated: nothing was measured");
  }
  for (const EventKind kind : {EventKind::extrapolated, EventKind::device_extrapolated,
                               EventKind::device_travel_step, EventKind::device_force_step}) {
    const auto is_kind = [kind](const EventRow& event) { return event.kind == kind; };
    const auto first = std::ranges::find_if(data.events, is_kind);
    if (first == data.events.end()) continue;
    const auto times = std::ranges::count_if(data.events, is_kind);
    notes.push_back(times == 1 ? first->detail
                               : fmt::format("{} ({} times)", first->detail, times));
  }
  const RunListing& l = data.listing;
  if (l.exit_status != ExitStatus::success) {
    notes.push_back(fmt::format("the run ended with {}{}{}", to_string(l.exit_status, "?"),
                                l.reason.empty() ? "" : ": ", l.reason));
  }
}

void add_proof(const RunData& data, Notes& notes) {
  if (!data.proof_known) {
    notes.emplace_back(
        "the meter's settings were not read back after the run had begun (an older lcrig recorded "
        "it): whether each reading was taken under them is not known");
  } else if (data.unproven_readings > 0) {
    notes.push_back(fmt::format(
        "{} readings are not proven (no two equal read-backs of the meter's settings enclose "
        "them): left out",
        data.unproven_readings));
  }
}

// Adds a note with the count in the place that `text` has for it; adds none if the count is 0.
void add_count(std::int64_t count, const char* text, Notes& notes) {
  if (count > 0) notes.push_back(fmt::format(fmt::runtime(text), count));
}

void add_readings(const RunData& data, Notes& notes) {
  add_count(data.overloads, "{} readings are overloads", notes);
  add_count(data.impossible,
            "{} readings are numbers that no meter measures (a farad or more): left out", notes);
  add_count(data.repeated_readings, "{} answers repeated the value before and are not used", notes);
  add_count(data.other_function, "{} readings of other functions are not used", notes);
  const auto [low, high] =
      std::ranges::minmax_element(data.readings, {}, &RunReading::capacitance_F);
  if (data.readings.size() >= 3 && low->capacitance_F == high->capacitance_F) {
    notes.emplace_back("all readings are alike: a meter that measures shows its noise");
  }
  add_count(
      std::ranges::count_if(data.readings, [](const RunReading& r) { return r.capacitance_F < 0; }),
      "{} readings of a negative capacitance: look at the open correction and the function", notes);
  add_count(std::ranges::count_if(data.readings,
                                  [](const RunReading& r) { return r.capacitance_F == 0; }),
            "{} readings are exactly 0: a meter that measures shows its noise", notes);
  if (!data.has_frame()) notes.emplace_back("no force was recorded");
  if (!data.dead_weights) {
    add_count(
        data.times_of_arrival,
        "{} samples of the frame have no time of a clock that can be believed: theirs is that "
        "of their arrival, which may be late",
        notes);
  }
  add_count(data.frame_gaps, "{} gaps in the frame's samples: nothing is interpolated across them",
            notes);
}

void add_settings(const RunView& view, Notes& notes) {
  if (!view.setting_known) notes.emplace_back("the run does not tell the settings of the meter");
  if (view.different_settings > 1) {
    const MeterSetting& s = view.setting;
    notes.push_back(fmt::format(
        "the meter's settings changed during the run: only readings under {} Hz, {} V, {}, average "
        "{} are used ({} settings in all)",
        s.frequency_Hz, s.level_V, to_string(s.aperture), s.average, view.different_settings));
  }
  add_count(
      view.flagged,
      "{} readings are flagged (a value beside an overload, a value out of the meter's range, "
      "or the first after a resynchronisation): left out",
      notes);
  if (view.flagged == std::ssize(view.data.readings)) {
    notes.emplace_back("of the readings none is left: nothing can be said of the specimen");
  }
}

void add_corrections(const RunData& data, Notes& notes) {
  if (!data.corrections) return;
  if (data.corrections->open.on == false) {
    notes.emplace_back(
        "the meter's open correction was off: C0 and what is divided by it contain the capacitance "
        "of leads and fixture; changes of the capacitance do not");
  }
  if (data.corrections->short_circuit.on == false) {
    notes.emplace_back(
        "the meter's short correction was off: the series impedance of leads and fixture is in all "
        "readings");
  }
}

void add_missing_levels(const RunData& data, const MeasuredLevels& measured, Notes& notes) {
  std::int64_t missing = 0;
  for (const MeasuredLevel& l : measured.levels) missing += l.missing;
  add_count(
      missing,
      "{} planned readings of levels are missing (overload, no force, or the level broke off)",
      notes);
  const auto abandoned = std::ranges::count(data.levels, true, &LevelRow::abandoned);
  add_count(abandoned, "{} levels were abandoned when an instrument was lost in them: left out",
            notes);
  const auto empty = std::ssize(data.levels) - std::ssize(measured.levels) - abandoned;
  if (data.area_m2) add_count(empty, "{} levels have no usable reading", notes);
}

constexpr double kShowsInHold =
    3.3;  // standard errors: chance exceeds it in one hold of a thousand

bool has_outlier(const Outliers& outliers, const HoldResult& h) {
  return std::ranges::any_of(
      outliers.outliers, [&h](const Outlier& o) { return h.begin_s <= o.t_s && o.t_s <= h.end_s; });
}

// The fit to a hold follows an outlier; the ranks of its readings do not.
bool shows_in_ranks(const Scene& scene, const HoldResult& h) {
  constexpr double kInRanks = 2.6;  // standard deviations: one hold of a hundred by chance
  std::vector<double> fF;
  for (std::size_t i = h.first; i < h.last; ++i) {
    const RunReading& r = scene.data.readings[i];
    if (r.has_force() && scene.uses(r)) fF.push_back(scene.fF(r));
  }
  return fF.size() > 1 && std::abs(rank_trend(fF)) > kInRanks;
}

// A drift within the readings of one load is named as such; it is no outlier.
void add_creep(const Scene& scene, const MeasuredLevels& measured, const HoldResults& holds,
               Notes& notes) {
  if (const auto& d = measured.drift_in_levels) {
    const std::string part =
        d->percent ? fmt::format(" ({:.2g} % of what the load makes)", std::abs(*d->percent)) : "";
    notes.push_back(fmt::format(
        "creep or relaxation: C drifts one way within {} of {} levels, by up to {:.3g} fF{} at "
        "{:.4g} kPa; such readings are no outliers",
        d->levels, measured.levels.size(), d->largest_fF, part, d->kPa));
    return;
  }
  if (!measured.levels.empty()) return;
  const HoldResult* largest = nullptr;
  std::int64_t resolved = 0;
  const double widening = scene.rest_correlation.widening();
  for (const HoldResult& h : holds.holds) {
    if (!h.resolved || std::abs(h.change_fF) <= kShowsInHold * widening * h.change_se_fF) continue;
    if (has_outlier(measured.outliers, h) && !shows_in_ranks(scene, h)) continue;
    ++resolved;
    if (largest == nullptr || std::abs(h.change_fF) > std::abs(largest->change_fF)) largest = &h;
  }
  if (largest == nullptr) return;
  notes.push_back(
      fmt::format("creep or relaxation: C drifts one way within {} of {} holds, by up to {:.3g} fF",
                  resolved, holds.holds.size(), largest->change_fF));
}

void add_certified_range(const Scene& scene, const MeasuredLevels& measured, Notes& notes) {
  const auto from = scene.options.rig.force_certified_from_N;
  if (!from || !scene.data.area_m2) return;
  const auto below = std::ranges::count_if(measured.levels, [&](const MeasuredLevel& l) {
    return l.pressure_kPa * 1e3 * *scene.data.area_m2 < *from;
  });
  if (below == 0) return;
  notes.push_back(fmt::format(
      "{} of {} levels lie below {} N, where the load cell is not certified: the force part of the "
      "uncertainty does not hold there",
      below, measured.levels.size(), *from));
}

}  // namespace

Notes calc_notes(const Scene& scene, const MeasuredLevels& measured, const HoldResults& holds) {
  const RunData& data = scene.data;
  Notes notes;
  add_origin(data, notes);
  add_proof(data, notes);
  add_readings(data, notes);
  add_settings(scene, notes);
  add_corrections(data, notes);
  if ((!scene.loadings.empty() || !data.levels.empty()) && !scene.drift.known()) {
    notes.emplace_back(
        "no two stretches without load: a drift of the capacitance cannot be told from the "
        "specimen's answer, and none is subtracted");
  }
  if (!data.levels.empty() && !data.area_m2) {
    notes.emplace_back(
        "the run knows no probe diameter, so there are no pressures and no levels in kPa; state it "
        "in the fixture of the bench or config file");
  }
  add_count(measured.without_force,
            "{} levels have no recorded force: the force that was asked for is taken", notes);
  if (holds.holds_left_out > 0) {
    notes.push_back(fmt::format("only the first {} holds are analysed, {} more are not",
                                holds.holds.size(), holds.holds_left_out));
  }
  add_creep(scene, measured, holds, notes);
  add_certified_range(scene, measured, notes);
  add_missing_levels(data, measured, notes);
  add_count(measured.outliers.outlier_count,
            "{} outliers among the readings: listed, and kept in every result but the robust "
            "ones, the noise and the drift that is subtracted",
            notes);
  return notes;
}

}  // namespace lcrig
