// SPDX-License-Identifier: Apache-2.0
#include "analysis/run_data.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/align.hpp"
#include "analysis/pieces.hpp"
#include "analysis/pressure_of_run.hpp"
#include "base/meter_words.hpp"
#include "storage/frame_capabilities.hpp"
#include "storage/proof.hpp"

namespace lcrig {

namespace {

// Readings less than this time before contact may be of a specimen that is already touched.
constexpr double kBeforeContact_s = 1;
// No meter measures a capacitance this large.
constexpr double kNoCapacitance_F = 1;

float narrow(std::optional<double> value) {
  return value ? static_cast<float>(*value) : std::numeric_limits<float>::quiet_NaN();
}

// Keeps all samples, or from every stretch those of least and of largest force.
class Thinner {
 public:
  Thinner(RunData& out, std::int64_t start_ns) : out_(out), start_ns_(start_ns) {}

  void take(const FrameTrack::Sample& s) {
    ++out_.frame_samples;
    if (s.after_gap) ++out_.frame_gaps;
    if (s.of_arrival) ++out_.times_of_arrival;
    FramePoint p;
    p.t_s = static_cast<double>(s.t_ns - start_ns_) * 1e-9;
    p.force_N = narrow(s.force_N);
    p.travel_m = narrow(s.travel_m);
    p.after_gap = s.after_gap;
    if (out_.frame_stride <= 2) {
      out_.frame.push_back(p);
      return;
    }
    gap_ = gap_ || s.after_gap;
    if (count_ == 0 || p.force_N < low_.force_N || std::isnan(low_.force_N)) low_ = p;
    if (count_ == 0 || p.force_N > high_.force_N || std::isnan(high_.force_N)) high_ = p;
    if (++count_ == out_.frame_stride) end_stretch();
  }
  void end_stretch() {
    if (count_ == 0) return;
    FramePoint& first = low_.t_s <= high_.t_s ? low_ : high_;
    FramePoint& second = low_.t_s <= high_.t_s ? high_ : low_;
    first.after_gap = gap_;
    second.after_gap = false;
    out_.frame.push_back(first);
    if (second.t_s > first.t_s) out_.frame.push_back(second);
    count_ = 0;
    gap_ = false;
  }

 private:
  RunData& out_;
  std::int64_t start_ns_;
  std::int64_t count_ = 0;
  bool gap_ = false;
  FramePoint low_, high_;
};

class Loader {
 public:
  Loader(const Database& db, RunData& out) : db_(db), out_(out) {}

  Result<> load(std::int64_t run, const LoadOptions& options) {
    if (auto r = load_row(run); !r) return r;
    if (auto r = load_levels(); !r) return r;
    if (auto r = load_events(); !r) return r;
    if (auto r = load_readings(options); !r) return r;
    read_spans();
    read_contact();
    return {};
  }

 private:
  double seconds(std::int64_t mono_ns) const {
    return static_cast<double>(mono_ns - start_ns_) * 1e-9;
  }

  Result<> load_row(std::int64_t run) {
    auto row = get_run(db_, run);
    if (!row) return fail(row.error());
    auto listing = get_run_listing(db_, run);
    if (!listing) return fail(listing.error());
    if (listing->goes_on) {
      return fail(Errc::busy,
                  "run {} is still going on: analyse it when it has ended (`lcrig status`)", run);
    }
    if (!listing->exit_status) {
      return fail(Errc::invalid_request,
                  "run {} was cut off: lcrigd closes it at its next start (or its end was deleted: "
                  "`lcrig verify {}`); `lcrig export {}` writes what is there",
                  run, run, run);
    }
    out_.run = run;
    out_.row = std::move(*row);
    out_.listing = std::move(*listing);
    start_ns_ = out_.row.started.time_since_epoch().count();
    out_.replayed = out_.row.simulated && replay_directory(out_.row.bench_name).has_value();
    out_.probe_diameter_m = out_.row.probe_diameter_m;
    out_.pressure = pressure_of_run(out_.row);
    out_.area_m2 = out_.pressure.area_m2();
    const StoredCapabilities frame = parse_capabilities(out_.row.frame_capabilities_json);
    out_.dead_weights = frame.weights;
    out_.force_class_percent = frame.force_class_percent;
    out_.corrections = parse_corrections(out_.row.correction_json);
    before_.add(std::numeric_limits<std::int64_t>::min(), out_.row.lcr_settings_json);
    if (const auto s = parse_meter_setting(out_.row.lcr_settings_json)) {
      out_.settings.push_back({-std::numeric_limits<double>::infinity(), *s});
    }
    return {};
  }

  // A stored pressure is over the probe.
  std::optional<double> target_Pa(std::optional<double> stored_Pa,
                                  std::optional<double> force_N) const {
    if (out_.pressure.on == PressureOn::probe || !force_N || !out_.area_m2) return stored_Pa;
    return *force_N / *out_.area_m2;
  }

  Result<> load_levels() {
    const auto take = [this](const Statement& s) {
      LevelRow l;
      l.level = static_cast<std::int32_t>(s.integer(0));
      l.repeat = static_cast<std::int32_t>(s.integer(1));
      l.index = static_cast<std::int32_t>(s.integer(2));
      l.step_id = s.text(3);
      l.target_force_N = s.optional_real(4);
      l.target_pressure_Pa = target_Pa(s.optional_real(5), l.target_force_N);
      l.planned_readings = static_cast<std::int32_t>(s.integer(6));
      l.begin_s = seconds(s.integer(7));
      while (static_cast<std::int64_t>(out_.levels.size()) + 1 < s.integer(0)) {
        out_.levels.emplace_back();  // so that a level is found by its number
      }
      out_.levels.push_back(std::move(l));
    };
    return db_.each(
        "SELECT level, repeat, level_index, step_id, target_force_N, target_pressure_Pa,"
        " planned_readings, begin_mono_ns FROM level WHERE run_id = ? ORDER BY level",
        take, out_.run);
  }

  Result<> load_events() {
    const auto take = [this](const Statement& s) {
      EventRow e{seconds(s.integer(0)), EventName(std::string(s.text(1))), std::string(s.text(2)),
                 std::string(s.text(3))};
      if (e.kind == EventKind::settings) {
        before_.add(s.integer(0), e.detail);
        if (const auto m = parse_meter_setting(e.detail)) out_.settings.push_back({e.t_s, *m});
      }
      if (e.kind == EventKind::level_abandoned) abandon(e.detail);
      out_.duration_s = std::max(out_.duration_s, e.t_s);
      out_.events.push_back(std::move(e));
    };
    const auto sql = fmt::format(
        "SELECT at_mono_ns, kind, step_id, detail FROM event WHERE run_id = ? AND {} ORDER BY seq",
        kIsShown);
    return db_.each(sql, take, out_.run);
  }

  void abandon(const std::string& detail) {
    const auto lost = from_json<LevelAbandonedEvent>(detail);
    LevelRow* const row = lost ? find_level(lost->level) : nullptr;
    if (row != nullptr) row->abandoned = true;
  }

  Result<> load_readings(const LoadOptions& options) {
    auto samples = last_seq(db_, "frame_sample", out_.run);
    if (!samples) return fail(samples.error());
    auto count = last_seq(db_, "lcr_reading", out_.run);
    if (!count) return fail(count.error());
    out_.readings.reserve(static_cast<std::size_t>(*count));
    const std::int64_t points = std::max<std::int64_t>(options.frame_points, 2);
    out_.frame_stride = *samples <= points ? 1 : (2 * *samples + points - 1) / points;
    auto clock = DeviceClock::fit(db_, out_.run);
    if (!clock) return fail(clock.error());
    auto track = FrameTrack::open(db_, out_.run, out_.dead_weights, std::move(*clock));
    if (!track) return fail(track.error());
    auto proof = Proof::load(db_, out_.run);
    if (!proof) return fail(proof.error());
    out_.proof_known = proof->is_known();
    ProofWalk walk(*proof);
    Thinner thinner(out_, start_ns_);
    track->set_listener([&thinner](const FrameTrack::Sample& s) { thinner.take(s); });
    auto taken = db_.each(
        "SELECT asked_mono_ns, first_byte_mono_ns, fresh, capacitance_F, step_id, repeat, level,"
        " reading_index, flags, function FROM lcr_reading WHERE run_id = ? ORDER BY seq",
        [&](const Statement& row) { return take(row, walk, *track); }, out_.run);
    if (!taken) return taken;
    if (auto r = track->drain(); !r) return r;
    thinner.end_stretch();
    if (!out_.frame.empty()) out_.duration_s = std::max(out_.duration_s, out_.frame.back().t_s);
    return check_readings();
  }

  Result<> take(const Statement& row, ProofWalk& walk, FrameTrack& track) {
    if (row.integer(2) == 0) {
      ++out_.repeated_readings;
      return {};
    }
    const std::int64_t asked = row.integer(0);
    if (!walk.is_proven(asked)) {
      ++out_.unproven_readings;
      return {};
    }
    ++out_.fresh_readings;
    const LevelRow* const of_level = live_level(row.optional_integer(6).value_or(0));
    const std::int64_t index = of_level == nullptr ? 0 : row.optional_integer(7).value_or(0);
    const auto capacitance = row.optional_real(3);
    if (!capacitance) {
      const auto function = parse_word<LcrFunction>(row.text(9));
      ++(function && is_capacitance(*function) ? out_.overloads : out_.other_function);
      return {};
    }
    if (!(std::abs(*capacitance) < kNoCapacitance_F)) {
      ++out_.impossible;
      return {};
    }
    if (out_.function.empty()) out_.function = row.text(9);
    auto a = align(track, before_.at(asked), asked, row.integer(1));
    if (!a) return fail(a.error());
    RunReading r;
    r.t_s = seconds(a->middle_ns);
    r.capacitance_F = *capacitance;
    if (a->state.force_N) {
      r.force_N = static_cast<float>(*a->state.force_N);
      r.present |= 1;
    }
    if (a->state.travel_m) {
      r.travel_m = static_cast<float>(*a->state.travel_m);
      r.present |= 2;
    }
    r.alignment_s = static_cast<float>(a->uncertainty_s);
    r.force_rate_N_s = static_cast<float>(a->state.force_rate_N_s);
    r.level = of_level == nullptr ? 0 : of_level->level;
    r.index = static_cast<std::int32_t>(index);
    r.repeat = static_cast<std::int32_t>(row.integer(5));
    r.step = step_of(row.text(4));
    r.flags = static_cast<std::uint8_t>(row.integer(8));
    out_.duration_s = std::max(out_.duration_s, r.t_s);
    out_.readings.push_back(r);
    return {};
  }

  // Null: there is no such level, or it was abandoned.
  const LevelRow* live_level(std::int64_t level) {
    LevelRow* const row = find_level(level);
    return row == nullptr || row->abandoned ? nullptr : row;
  }

  LevelRow* find_level(std::int64_t level) {
    if (level < 1 || level > static_cast<std::int64_t>(out_.levels.size())) return nullptr;
    return &out_.levels[static_cast<std::size_t>(level - 1)];
  }

  // Readings of one step follow each other, so the last step found is tried first.
  std::uint16_t step_of(std::string_view name) {
    if (!out_.steps.empty() && out_.steps[step_] == name) return step_;
    const auto it = std::find(out_.steps.begin(), out_.steps.end(), name);
    step_ = static_cast<std::uint16_t>(it - out_.steps.begin());
    if (it == out_.steps.end()) out_.steps.emplace_back(name);
    return step_;
  }

  Result<> check_readings() const {
    if (!out_.readings.empty()) return {};
    const RunListing& l = out_.listing;
    if (out_.unproven_readings > 0 && out_.fresh_readings == 0) {
      return fail(Errc::invalid_request,
                  "none of the {} readings of run {} is proven: the meter's settings were not read "
                  "back as they were set; `lcrig export` writes them with the flag `unproven`",
                  out_.unproven_readings, out_.run);
    }
    if (out_.other_function > 0) {
      return fail(Errc::invalid_request,
                  "run {} measured no capacitance (its function is another): there is nothing to "
                  "analyse; `lcrig export` writes its readings",
                  out_.run);
    }
    if (out_.overloads > 0) {
      return fail(Errc::invalid_request,
                  "all {} readings of run {} are overloads: check the connection of the specimen",
                  out_.overloads, out_.run);
    }
    if (out_.repeated_readings > 0) {
      return fail(Errc::invalid_request,
                  "all {} answers repeat the one before in run {}: the meter measured nothing new; "
                  "look at its trigger",
                  out_.repeated_readings, out_.run);
    }
    return fail(Errc::invalid_request, "run {} has no readings (it ended with {}{}{})", out_.run,
                to_string(l.exit_status, "?"), l.reason.empty() ? "" : ": ", l.reason);
  }

  void read_spans() {
    for (const EventRow& e : out_.events) {
      if (e.kind == EventKind::step_begin) {
        out_.spans.push_back({e.t_s, out_.duration_s});
      } else if (e.kind == EventKind::step_end && !out_.spans.empty()) {
        out_.spans.back().end_s = e.t_s;
      }
    }
  }

  // A frame records the touch; with dead weights a person hangs the weight while the step waits.
  void read_contact() {
    for (const EventRow& e : out_.events) {
      if (e.kind == EventKind::contact) {
        const auto contact = from_json<ContactEvent>(e.detail);
        if (contact) out_.rest_force_N = contact->rest_force_N;
        out_.contact_s = (contact ? first_touch_s(e.t_s, *contact) : e.t_s) - kBeforeContact_s;
        return;
      }
      if (e.kind != EventKind::confirm) continue;
      const auto placed = from_json<WeightPlacedEvent>(e.detail);
      if (!placed || placed->force_N.value_or(0) <= 0) continue;
      out_.contact_s = e.t_s - kBeforeContact_s;
      for (const StepSpan& s : out_.spans) {
        if (s.begin_s <= e.t_s && e.t_s <= s.end_s) out_.contact_s = s.begin_s;
      }
      out_.rest_force_N = 0;
      return;
    }
  }

  // A search that slows down touches several times before it reports the contact. Touches count
  // from the last zero of the force, because before it the cell may show as much without a touch.
  double first_touch_s(double found_s, const ContactEvent& contact) const {
    double since_s = 0;
    for (const StepSpan& s : out_.spans) {
      if (s.begin_s <= found_s && found_s <= s.end_s) since_s = s.begin_s;
    }
    for (const EventRow& e : out_.events) {
      if (e.kind == EventKind::zero && e.t_s <= found_s) since_s = std::max(since_s, e.t_s);
    }
    if (!contact.force_N) return found_s;
    const double touch_N = (contact.rest_force_N.value_or(0) + *contact.force_N) / 2;
    for (const FramePoint& p : out_.frame) {
      if (p.t_s >= found_s) break;
      if (p.t_s > since_s && p.force_N >= touch_N) return p.t_s;
    }
    return found_s;
  }

  const Database& db_;
  RunData& out_;
  std::int64_t start_ns_ = 0;
  WindowBefore before_;
  std::uint16_t step_ = 0;
};

}  // namespace

double RunReading::alignment_N() const {
  return std::abs(static_cast<double>(force_rate_N_s)) * alignment_s;
}

double RunReading::half_window_s() const {
  return std::sqrt(3.0) * alignment_s;
}

Result<RunData> load_run_data(const Database& db, std::int64_t run, const LoadOptions& options) {
  auto view = Transaction::begin_read(db);
  if (!view) return fail(view.error());
  RunData out;
  if (auto r = Loader(db, out).load(run, options); !r) return fail(r.error());
  return out;
}

}  // namespace lcrig
