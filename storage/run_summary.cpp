// SPDX-License-Identifier: Apache-2.0
#include "storage/run_summary.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "base/exit_status.hpp"
#include "events/event_kind.hpp"
#include "storage/proof.hpp"

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

class Mean {
 public:
  void add(const std::optional<double>& value) {
    if (!value) return;
    sum_ += *value;
    ++count_;
  }
  std::optional<double> value() const {
    return count_ > 0 ? std::optional<double>(sum_ / static_cast<double>(count_)) : std::nullopt;
  }

 private:
  double sum_ = 0;
  std::int64_t count_ = 0;
};

// Mean of the proven readings nearest to each of `instants`, at most 0.2 s away. The time of a
// reading is the middle of its exchange.
Result<std::optional<double>> mean_near(const Database& db, std::int64_t run, const Proof& proof,
                                        const std::vector<std::int64_t>& instants) {
  constexpr std::int64_t kNear_ns = 200'000'000;
  Mean mean;
  ProofWalk walk(proof);
  std::size_t next = 0;
  std::optional<std::pair<std::int64_t, double>> before;
  const auto take = [&](const Statement& row) {
    if (!walk.is_proven(row.integer(2))) return;
    const std::pair<std::int64_t, double> here(row.integer(0), row.real(1));
    for (; next < instants.size() && instants[next] <= here.first; ++next) {
      const std::int64_t t = instants[next];
      const bool earlier = before && t - before->first < here.first - t;
      const auto& nearest = earlier ? *before : here;
      if (std::abs(nearest.first - t) <= kNear_ns) mean.add(nearest.second);
    }
    before = here;
  };
  auto all = db.each(
      "SELECT (asked_mono_ns + last_byte_mono_ns) / 2, capacitance_F, asked_mono_ns FROM "
      "lcr_reading WHERE run_id = ? AND fresh AND capacitance_F IS NOT NULL ORDER BY seq",
      take, run);
  if (!all) return fail(all.error());
  return mean.value();
}

// C0 is measured before this time; nullopt: the run records no contact and no weight.
Result<std::optional<std::int64_t>> end_of_baseline(const Database& db, std::int64_t run) {
  return db.first<std::int64_t>(
      "SELECT MIN(at_mono_ns) - 1000000000 FROM event WHERE run_id = ? AND kind IN (?, ?)", run,
      EventKind::contact, EventKind::confirm);
}

// What one pass over the proven readings gives.
struct Readings {
  std::int64_t fresh = 0, unproven = 0, of_levels = 0;
  Mean baseline, top;
};

Result<Readings> read_readings(const Database& db, std::int64_t run, const Proof& proof) {
  auto end = end_of_baseline(db, run);
  if (!end) return fail(end.error());
  // Readings of an abandoned level do not count, because the level is measured again.
  auto abandoned = db.rows<std::int64_t>(
      "SELECT json_extract(detail, '$.level') FROM event WHERE run_id = ? AND kind = ? ORDER "
      "BY 1",
      run, EventKind::level_abandoned);
  if (!abandoned) return fail(abandoned.error());
  auto top = db.rows<std::int64_t>(
      "SELECT level FROM level WHERE run_id = ?1 AND target_force_N > 0.999 * (SELECT "
      "MAX(target_force_N) FROM level WHERE run_id = ?1) ORDER BY level",
      run);
  if (!top) return fail(top.error());
  const auto is_in = [](const std::vector<std::int64_t>& levels, std::int64_t level) {
    return std::ranges::binary_search(levels, level);
  };
  Readings out;
  ProofWalk walk(proof);
  const auto take = [&](const Statement& row) {
    const bool fresh = row.integer(1) != 0;
    if (!walk.is_proven(row.integer(0))) {
      out.unproven += fresh ? 1 : 0;
      return;
    }
    out.fresh += fresh ? 1 : 0;
    const auto value = row.optional_real(3);
    if (fresh && *end && row.integer(2) < **end) out.baseline.add(value);
    const std::int64_t level = row.optional_integer(4).value_or(0);
    if (row.is_null(5) || is_in(*abandoned, level)) return;
    ++out.of_levels;
    if (is_in(*top, level)) out.top.add(value);
  };
  auto all = db.each(
      "SELECT asked_mono_ns, fresh, last_byte_mono_ns, capacitance_F, level, reading_index FROM "
      "lcr_reading WHERE run_id = ? ORDER BY seq",
      take, run);
  if (!all) return fail(all.error());
  return out;
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
    auto proof = Proof::load(db, run);
    if (!proof) return fail(proof.error());
    auto readings = read_readings(db, run, *proof);
    if (!readings) return fail(readings.error());
    const auto c0_F = readings->baseline.value();
    if (!c0_F) continue;
    LastC0 out;
    out.run = run;
    out.c0_F = *c0_F;
    return std::optional(out);
  }
  return std::optional<LastC0>();
}

Result<RunSummary> summarise_run(const Database& db, std::int64_t run) {
  auto proof = Proof::load(db, run);
  if (!proof) return fail(proof.error());
  auto readings = read_readings(db, run, *proof);
  if (!readings) return fail(readings.error());
  RunSummary out;
  out.lcr_readings = readings->fresh;
  out.unproven_readings = readings->unproven;
  out.measure_readings = readings->of_levels;
  out.c0_F = readings->baseline.value();
  auto read = keep(db.integer("SELECT COUNT(*) FROM frame_sample WHERE run_id = ?", run),
                   out.frame_samples);
  if (read) {
    read = keep(db.first<double>("SELECT (ended_mono_ns - started_mono_ns) * 1e-9 FROM run JOIN"
                                 " run_end ON run_id = id WHERE id = ?",
                                 run),
                out.duration_s);
  }
  // A peak between two samples is only in the report that the frame sends at the end of the motion.
  constexpr std::string_view kPeak =
      "SELECT MAX(f) FROM (SELECT MAX(force_N) AS f FROM frame_sample WHERE run_id = ?1 UNION ALL"
      " SELECT MAX(json_extract(detail, '$.force_N')) FROM event WHERE run_id = ?1 AND"
      " kind = ?2)";
  if (read) read = keep(db.first<double>(kPeak, run, EventKind::motion), out.peak_force_N);
  if (!read) return fail(read.error());
  if (!out.c0_F || !out.peak_force_N) return out;
  auto top = readings->top.value();
  if (!top) {
    auto instants = peaks(db, run, *out.peak_force_N);
    if (!instants) return fail(instants.error());
    if (auto r = keep(mean_near(db, run, *proof, *instants), top); !r) return fail(r.error());
  }
  if (top) out.delta_at_peak_F = *top - *out.c0_F;
  return out;
}

}  // namespace lcrig
