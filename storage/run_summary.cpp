// SPDX-License-Identifier: Apache-2.0
#include "storage/run_summary.hpp"

#include <cstdlib>
#include <vector>

#include "base/exit_status.hpp"
#include "events/event_kind.hpp"

namespace lcrig {

namespace {

// The times of the largest force, one for each excursion above half of the peak.
Result<std::vector<std::int64_t>> peaks(const Database& db, std::int64_t run, double peak_N) {
  std::vector<std::int64_t> out;
  double highest = 0;  // of the current excursion; 0: none
  const auto take = [&](const Statement& sample) {
    const double force = sample.real(1);
    if (force < peak_N / 2) {
      highest = 0;
    } else if (force > highest) {
      if (highest == 0) out.push_back(0);
      out.back() = sample.integer(0);
      highest = force;
    }
  };
  auto all = db.each(
      "SELECT received_mono_ns, force_N FROM frame_sample WHERE run_id = ? AND force_N IS NOT NULL "
      "ORDER BY seq",
      take, run);
  if (!all) return fail(all.error());
  return out;
}

// Mean of the readings nearest to each of `instants`, at most 0.2 s away. The time of a reading is
// the middle of its exchange.
Result<std::optional<double>> mean_near(const Database& db, std::int64_t run,
                                        const std::vector<std::int64_t>& instants) {
  constexpr std::int64_t kNear_ns = 200'000'000;
  double sum = 0;
  int count = 0;
  std::size_t next = 0;
  std::optional<std::pair<std::int64_t, double>> before;
  const auto take = [&](const Statement& row) {
    const std::pair<std::int64_t, double> here(row.integer(0), row.real(1));
    for (; next < instants.size() && instants[next] <= here.first; ++next) {
      const std::int64_t t = instants[next];
      const bool earlier = before && t - before->first < here.first - t;
      const auto& nearest = earlier ? *before : here;
      if (std::abs(nearest.first - t) > kNear_ns) continue;
      sum += nearest.second;
      ++count;
    }
    before = here;
  };
  auto all = db.each(
      "SELECT (asked_mono_ns + last_byte_mono_ns) / 2, capacitance_F FROM lcr_reading "
      "WHERE run_id = ? AND fresh AND capacitance_F IS NOT NULL ORDER BY seq",
      take, run);
  if (!all) return fail(all.error());
  return count > 0 ? std::optional<double>(sum / count) : std::nullopt;
}

Result<std::optional<double>> capacitance_at_peak(const Database& db, std::int64_t run,
                                                  double peak_N) {
  auto level = db.first<double>(
      "SELECT AVG(capacitance_F) FROM lcr_reading JOIN level USING (run_id, level) "
      "WHERE run_id = ?1 AND reading_index IS NOT NULL AND level NOT IN (SELECT "
      "json_extract(detail, '$.level') FROM event WHERE run_id = ?1 AND kind = ?2) AND "
      "target_force_N > 0.999 * (SELECT MAX(target_force_N) FROM level WHERE run_id = ?1)",
      run, EventKind::level_abandoned);
  if (!level || *level) return level;
  auto instants = peaks(db, run, peak_N);
  if (!instants) return fail(instants.error());
  return mean_near(db, run, *instants);
}

Result<> add_counts(const Database& db, std::int64_t run, RunSummary& out) {
  const auto read = [&out](const Statement& s) {
    s.read(out.lcr_readings, out.measure_readings, out.frame_samples);
  };
  return db.each(
      "SELECT (SELECT COUNT(*) FROM lcr_reading WHERE run_id = ?1 AND fresh),"
      // Readings of an abandoned level do not count: the level was begun again.
      " (SELECT COUNT(reading_index) FROM lcr_reading WHERE run_id = ?1 AND (level IS NULL OR level"
      "  NOT IN (SELECT json_extract(detail, '$.level') FROM event WHERE run_id = ?1 AND kind = "
      "?2))),"
      " (SELECT COUNT(*) FROM frame_sample WHERE run_id = ?1)",
      read, run, EventKind::level_abandoned);
}

Result<std::optional<double>> c0_of(const Database& db, std::int64_t run) {
  return db.first<double>(
      "SELECT AVG(capacitance_F) FROM lcr_reading WHERE run_id = ?1 AND fresh AND "
      "last_byte_mono_ns < (SELECT MIN(at_mono_ns) - 1000000000 FROM event "
      "WHERE run_id = ?1 AND kind IN (?2, ?3))",
      run, EventKind::contact, EventKind::confirm);
}

}  // namespace

Result<std::optional<LastC0>> last_c0(const Database& db, std::string_view specimen,
                                      double frequency_Hz) {
  // A run without contact, such as a passive recording, has no C0; then an earlier run may have
  // one.
  auto runs = db.rows<std::int64_t>(
      "SELECT run.id FROM run JOIN run_end ON run_id = id WHERE specimen_name = ? AND"
      " exit_status = ? AND json_extract(lcr_settings_json, '$.frequency_Hz') = ?"
      " ORDER BY started_unix_ns DESC, id DESC LIMIT 5",
      specimen, ExitStatus::success, frequency_Hz);
  if (!runs) return fail(runs.error());
  for (const std::int64_t run : *runs) {
    auto c0 = c0_of(db, run);
    if (!c0) return fail(c0.error());
    if (!*c0) continue;
    LastC0 out;
    out.run = run;
    out.c0_F = **c0;
    return std::optional(out);
  }
  return std::optional<LastC0>();
}

Result<RunSummary> summarise_run(const Database& db, std::int64_t run) {
  RunSummary out;
  if (auto counted = add_counts(db, run, out); !counted) return fail(counted.error());
  auto read = keep(db.first<double>("SELECT (ended_mono_ns - started_mono_ns) * 1e-9 FROM run JOIN"
                                    " run_end ON run_id = id WHERE id = ?",
                                    run),
                   out.duration_s);
  if (read) read = keep(c0_of(db, run), out.c0_F);
  // A peak between two samples is only in the report that the frame sends at the end of the motion.
  constexpr std::string_view kPeak =
      "SELECT MAX(f) FROM (SELECT MAX(force_N) AS f FROM frame_sample WHERE run_id = ?1 UNION ALL"
      " SELECT MAX(json_extract(detail, '$.force_N')) FROM event WHERE run_id = ?1 AND"
      " kind = ?2)";
  if (read) read = keep(db.first<double>(kPeak, run, EventKind::motion), out.peak_force_N);
  if (!read) return fail(read.error());
  if (!out.c0_F || !out.peak_force_N) return out;
  auto top = capacitance_at_peak(db, run, *out.peak_force_N);
  if (!top) return fail(top.error());
  if (*top) out.delta_at_peak_F = **top - *out.c0_F;
  return out;
}

}  // namespace lcrig
