// SPDX-License-Identifier: Apache-2.0
#include "daemon/replayed_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/record/stored_frame.hpp"
#include "protocols/rig/corridor.hpp"

namespace lcrig {

namespace {

using nlohmann::json;

FrameSample sample_of(const Statement& row) {
  FrameSample s;
  s.received = MonoTime(Duration(row.integer(0)));
  s.device_seq = row.integer(1);
  s.device_time_s = row.optional_real(2);
  s.force_N = row.optional_real(3);
  s.travel_m = row.optional_real(4);
  s.flags = static_cast<std::uint32_t>(row.integer(5));
  return s;
}

constexpr std::string_view kSamples =
    "SELECT received_mono_ns, device_seq, device_time_s, force_N, travel_m, flags FROM frame_sample"
    " WHERE run_id = ? AND seq > ? AND seq <= ? ORDER BY seq";

// A stop, or a new zero: from there on a run without orders does not say which limits apply.
bool ends_limits(EventKind kind) {
  switch (kind) {
    case EventKind::zero:
    case EventKind::abort:
    case EventKind::freeze:
    case EventKind::fault:
    case EventKind::stop_after:
    case EventKind::contradiction:
    case EventKind::limit:
    case EventKind::loss:
    case EventKind::hands_off: return true;
    default: return false;
  }
}

struct ReplayedEvent {
  MonoTime at;
  EventName kind;
  std::string detail;
};

class Reader {
 public:
  Reader(const Database& db, std::int64_t run, WatchReplay::Look look = nullptr)
      : db_(db), look_(std::move(look)) {
    out_.run = run;
  }

  Result<ReplayedWatch> read() {
    if (auto r = read_run(); !r) return fail(r.error());
    if (auto r = read_events(); !r) return fail(r.error());
    auto judged = watch_ ? end_judged() : judge_limits();
    if (!judged) return fail(judged.error());
    return std::move(out_);
  }

 private:
  Result<> read_run() {
    auto row = db_.query(
        "SELECT started_mono_ns, frame_limits_json, frame_capabilities_json FROM run WHERE id = ?",
        out_.run);
    if (!row) return fail(row.error());
    auto found = row->step();
    if (!found) return fail(found.error());
    if (!*found)
      return fail(Errc::invalid_request, "run {}: no such run in {}", out_.run, db_.path());
    out_.started = MonoTime(Duration(row->integer(0)));
    limits_json_ = row->text(1);
    frame_ = frame_capabilities(parse_capabilities(row->text(2)));
    // Samples are numbered from 1 without a gap.
    return keep(
        db_.integer("SELECT coalesce(max(seq), 0) FROM frame_sample WHERE run_id = ?", out_.run),
        out_.samples);
  }

  Result<> read_events() {
    return db_.each(
        "SELECT at_mono_ns, kind, detail FROM event WHERE run_id = ? ORDER BY seq",
        [this](const Statement& row) -> Result<> {
          return take({MonoTime(Duration(row.integer(0))), EventName(std::string(row.text(1))),
                       std::string(row.text(2))});
        },
        out_.run);
  }

  Result<> take(const ReplayedEvent& e) {
    const bool from_sample = std::exchange(from_sample_, false);
    if (e.kind == EventKind::watch_setup) return begin(e);
    if (e.kind == EventKind::watch_input && watch_) return apply(e);
    if (!limits_end_ && ends_limits(e.kind.kind())) limits_end_ = e;
    // A search that disbelieves writes a contradiction, too; it follows from no single sample.
    const bool found = e.kind == EventKind::limit || e.kind == EventKind::overshoot_exceeded ||
                       (e.kind == EventKind::contradiction && from_sample);
    if (found) out_.recorded.emplace_back(e.at, e.kind.kind(), e.detail);
    return {};
  }

  Result<> begin(const ReplayedEvent& e) {
    auto setup = from_json<WatchSetupEvent>(e.detail);
    if (!setup) return fail(setup.error());
    if (auto r = keep(WatchReplay::begin(*setup, frame_), watch_); !r) return r;
    if (look_) watch_->set_look(look_);
    return {};
  }

  Result<> apply(const ReplayedEvent& e) {
    auto input = from_json<WatchInputEvent>(e.detail);
    if (!input) return fail(input.error());
    ++out_.inputs;
    if (auto r = advance(input->samples); !r) return r;
    std::optional<RestMeasurement> look;
    if (input->from_sample) {
      if (auto r = keep(look_again(*input), look); !r) return r;
    }
    watch_->apply(*input, look ? &*look : nullptr, e.at);
    from_sample_ = input->judging.value_or(false);
    return {};
  }

  Result<> advance(std::int64_t to) {
    const std::int64_t from = watch_->samples();
    if (to <= from) return {};
    return db_.each(
        kSamples, [this](const Statement& row) { watch_->add(sample_of(row)); }, out_.run, from,
        to);
  }

  Result<std::optional<RestMeasurement>> look_again(const WatchInputEvent& input) const {
    RestMeasurement rest(*input.from_sample);
    const auto add = [&rest](const Statement& row) {
      const FrameSample sample = sample_of(row);
      rest.add(std::span(&sample, 1));
    };
    const std::int64_t to = input.to_sample.value_or(*input.from_sample);
    if (auto r = db_.each(kSamples, add, out_.run, *input.from_sample, to); !r) {
      return fail(r.error());
    }
    if (input.drift_N_s) rest.know_drift({*input.drift_N_s, input.drift_error_N_s.value_or(0)});
    if (input.shift_N) rest.shift(*input.shift_N);
    return std::optional(std::move(rest));
  }

  Result<> end_judged() {
    if (auto r = advance(out_.samples); !r) return r;
    out_.judged = watch_->findings();
    return {};
  }

  // Of a run that did not store its orders.
  Result<> judge_limits() {
    const json limits = json::parse(limits_json_, nullptr, false);
    if (!limits.is_object() || !limits.contains("force_min_N") || !limits.contains("force_max_N")) {
      out_.only = "it stored neither its orders nor its limits: nothing was judged";
      return {};
    }
    BoundLimits bound;
    bound.force_min_N = limits.at("force_min_N").get<double>();
    bound.force_max_N = limits.at("force_max_N").get<double>();
    RigFacts facts;
    facts.commands = false;
    facts.limits = bound;
    facts.rate_Hz = kFrameRate_Hz;
    RigState rig(std::move(facts), std::nullopt);
    out_.only = limits_end_
                    ? fmt::format(
                          "it did not store its orders: only the limits of the force were "
                          "judged, until its first event `{}`",
                          limits_end_->kind.word())
                    : "it did not store its orders: only the limits of the force were judged";
    std::optional<WatchFinding> found;
    const auto judge = [&](const Statement& row) {
      FrameSample s = sample_of(row);
      if (found || (limits_end_ && s.received > limits_end_->at)) return;
      s.travel_m.reset();
      const auto compared = rig.apply(s);
      const auto findings = find(rig, Sight{s, compared});
      if (const Finding* f = most_severe(findings))
        found.emplace(s.received, EventKind::limit, f->why);
    };
    auto read = db_.each(kSamples, judge, out_.run, std::int64_t{0}, out_.samples);
    if (!read) return read;
    if (found) out_.judged.push_back(std::move(*found));
    std::erase_if(out_.recorded, [](const WatchFinding& f) { return f.kind != EventKind::limit; });
    return {};
  }

  const Database& db_;
  const WatchReplay::Look look_;
  ReplayedWatch out_;
  std::string limits_json_;
  FrameCapabilities frame_;
  std::unique_ptr<WatchReplay> watch_;
  bool from_sample_ = false;  // the event before followed from a sample
  std::optional<ReplayedEvent> limits_end_;
};

// Collects the motions towards the specimen, and keeps the one that is worth a picture.
class MotionPicker {
 public:
  void look(const RigState& rig, const FrameSample& s, bool is_found) {
    const bool presses = rig.frame.motion == FrameMotion::moving && rig.frame.order.direction >= 0;
    if (presses && rig.frame.since != since_) end_motion();
    if (!presses || !s.travel_m || !s.force_N) return;
    since_ = rig.frame.since;
    const Corridor corridor = force_corridor(rig, s.received, s.travel_m);
    WatchedMotion::Point point{*s.travel_m * 1e3, *s.force_N, std::nullopt, std::nullopt};
    if (corridor.lower) point.low_N = corridor.lower->value();
    if (corridor.upper) point.high_N = corridor.upper->value();
    now_.points.push_back(point);
    if (is_found && !now_.outside) now_.outside = now_.points.size() - 1;
  }
  std::optional<WatchedMotion> pick() {
    end_motion();
    return std::move(best_);
  }

 private:
  static double largest_N(const WatchedMotion& m) {
    return std::ranges::max(m.points, {}, &WatchedMotion::Point::force_N).force_N;
  }
  void end_motion() {
    const WatchedMotion motion = std::exchange(now_, WatchedMotion());
    if (motion.points.empty() || (best_ && best_->outside)) return;
    if (!best_ || motion.outside || largest_N(motion) > largest_N(*best_)) best_ = motion;
  }

  MonoTime since_{};
  WatchedMotion now_;
  std::optional<WatchedMotion> best_;
};

}  // namespace

Result<ReplayedWatch> replay_watch(const Database& db, std::int64_t run) {
  return Reader(db, run).read();
}

Result<std::optional<WatchedMotion>> watched_motion(const Database& db, std::int64_t run) {
  MotionPicker picker;
  const auto look = [&picker](const RigState& rig, const FrameSample& sample, bool is_found) {
    picker.look(rig, sample, is_found);
  };
  auto read = Reader(db, run, look).read();
  if (!read) return fail(read.error());
  return picker.pick();
}

}  // namespace lcrig
