// SPDX-License-Identifier: Apache-2.0
#include "daemon/replayed_watch.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/record/stored_frame.hpp"

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
  Reader(const Database& db, std::int64_t run) : db_(db) { out_.run = run; }

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
    return keep(WatchReplay::begin(*setup, frame_), watch_);
  }

  Result<> apply(const ReplayedEvent& e) {
    auto input = from_json<WatchInputEvent>(e.detail);
    if (!input) return fail(input.error());
    ++out_.inputs;
    if (auto r = advance(input->samples); !r) return r;
    std::optional<Rest> look;
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

  Result<std::optional<Rest>> look_again(const WatchInputEvent& input) const {
    Rest rest(*input.from_sample);
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
    watch_->end();
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
    Guard guard(bound, Duration::max(), kAssumedForceClass);
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
      if (auto why = guard.check(s)) found.emplace(s.received, EventKind::limit, std::move(*why));
    };
    auto read = db_.each(kSamples, judge, out_.run, std::int64_t{0}, out_.samples);
    if (!read) return read;
    if (found) out_.judged.push_back(std::move(*found));
    std::erase_if(out_.recorded, [](const WatchFinding& f) { return f.kind != EventKind::limit; });
    return {};
  }

  const Database& db_;
  ReplayedWatch out_;
  std::string limits_json_;
  FrameCapabilities frame_;
  std::unique_ptr<WatchReplay> watch_;
  bool from_sample_ = false;  // the event before followed from a sample
  std::optional<ReplayedEvent> limits_end_;
};

}  // namespace

Result<ReplayedWatch> replay_watch(const Database& db, std::int64_t run) {
  return Reader(db, run).read();
}

}  // namespace lcrig
