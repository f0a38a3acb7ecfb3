// SPDX-License-Identifier: Apache-2.0
#include "daemon/continuation.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/units.hpp"
#include "daemon/session.hpp"
#include "protocols/expand.hpp"
#include "storage/copied_from.hpp"
#include "storage/runs.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

struct StoredEvent {
  std::string step_id, detail;
};

StoredEvent read_event(const Statement& row) {
  StoredEvent out;
  row.read(out.step_id, out.detail);
  return out;
}

// The last event of this kind; nullopt: none.
Result<std::optional<StoredEvent>> last_event(const Database& db, std::int64_t run,
                                              EventKind kind) {
  return db.first(
      "SELECT step_id, detail FROM event WHERE run_id = ? AND kind = ? ORDER BY seq DESC",
      read_event, run, kind);
}

Result<> check_interrupted(const Database& db, std::int64_t run) {
  auto listing = get_run_listing(db, run);
  if (!listing) return fail(listing.error());
  if (listing->exit_status != ExitStatus::interrupted) {
    return fail(Errc::invalid_request,
                "run {} ended with `{}`: only a run that was interrupted can be continued{}", run,
                to_string(listing->exit_status, "nothing yet"),
                listing->exit_status == ExitStatus::stopped
                    ? "; this one unloaded, so what it left out needs a new run (contact is found "
                      "anew)"
                    : "");
  }
  auto copied = get_copied_from(db, run);
  if (!copied) return fail(copied.error());
  if (*copied) {
    return fail(Errc::invalid_request,
                "run {} was copied from {}, where it is run {}: it can be continued only there",
                run, (*copied)->file, (*copied)->run);
  }
  // The events of a copied run contain numbers of another database.
  auto next = db.integer(
      "SELECT max(run_id) FROM event WHERE kind = ?1 AND run_id > ?2 AND "
      "json_extract(detail, '$.run') = ?2 AND run_id NOT IN (SELECT run_id FROM run_copy)",
      EventKind::continues, run);
  if (!next) return fail(next.error());
  if (*next == 0) return {};
  return fail(Errc::invalid_request, "run {} was continued by run {}: continue that one", run,
              *next);
}

Result<LastSeen> last_samples(const Database& db, std::int64_t run) {
  const auto read = [](const Statement& row) {
    FrameSample s;
    row.read(s.device_time_s, s.force_N, s.travel_m, s.flags);
    return s;
  };
  auto samples = db.rows(
      "SELECT device_time_s, force_N, travel_m, flags FROM frame_sample WHERE run_id = ? ORDER BY "
      "seq DESC LIMIT 3",
      read, run);
  if (!samples) return fail(samples.error());
  std::ranges::reverse(*samples);
  LastSeen memory;
  for (const FrameSample& sample : *samples) memory.feed(sample);
  return memory;
}

Result<std::vector<StoredAnswer>> answers_of(const Database& db, std::int64_t run) {
  auto rows =
      db.rows("SELECT step_id, detail FROM event WHERE run_id = ? AND kind = ? ORDER BY seq",
              read_event, run, EventKind::answer);
  if (!rows) return fail(rows.error());
  std::vector<StoredAnswer> out;
  out.reserve(rows->size());
  for (StoredEvent& row : *rows) {
    auto answer = from_json<AnswerEvent>(row.detail);
    if (!answer) return fail(answer.error());
    out.push_back(StoredAnswer{std::move(row.step_id), std::move(*answer)});
  }
  return out;
}

// Reads `parameters_json` of a run row: "from_kPa": 10, or in older runs "from_kPa (SI)": 10000.
Result<> apply_parameters(const std::string& text, Environment& environment) {
  constexpr std::string_view kSuffix = " (SI)";
  const json stored = json::parse(text, nullptr, false);
  if (!stored.is_object()) return fail(Errc::garbled, "the stored parameters do not parse");
  for (const auto& [key, value] : stored.items()) {
    if (!value.is_number()) {
      return fail(Errc::garbled, "the stored parameter `{}` is no number", key);
    }
    if (key.ends_with(kSuffix)) {
      environment.set(key.substr(0, key.size() - kSuffix.size()), value.get<double>());
    } else {
      environment.set(key, value.get<double>() * split_key(key).to_si());
    }
  }
  return {};
}

// True when a completed step, or the interrupted one, moves or zeroes the frame, lets it hold a
// force, or places a weight. A new simulated bench does not remember that.
bool has_used_frame(const PreparedRun& cut_off) {
  Environment environment = cut_off.environment;
  StepCursor steps(cut_off.protocol.steps, environment);
  for (std::int64_t n = 0; n <= cut_off.continues->point.steps_done; ++n) {
    const Step* step = steps.next();
    if (step == nullptr) return false;
    const StepFacts facts = facts_of(*step);
    if (facts.commands_frame() || facts.places_weight) return true;
  }
  return false;
}

struct CutOff {
  std::int64_t run = 0;
  bool on_bench = false;  // on the simulated bench of a daemon that has ended
};

}  // namespace

Result<PreparedRun> prepare_continuation(const Database& db, std::int64_t run) {
  auto row = get_run(db, run);
  if (!row) return fail(row.error());
  if (auto ok = check_interrupted(db, run); !ok) return fail(ok.error());
  auto state = last_event(db, run, EventKind::state);
  if (!state) return fail(state.error());
  auto begun = last_event(db, run, EventKind::step_begin);
  if (!begun) return fail(begun.error());
  if (!*state) {
    return fail(Errc::invalid_request,
                "run {} stopped before its first step: start it again with `lcrig run`", run);
  }
  RunRequest request;
  request.protocol_name = row->protocol_name;
  request.protocol_text = row->protocol_text;
  request.specimen_name = row->specimen_name;
  request.specimen_text = row->specimen_text;
  request.note = fmt::format("continues run {}", run);
  auto prepared = prepare_run(std::move(request));
  if (!prepared) return prepared;
  if (auto ok = apply_parameters(row->parameters_json, prepared->environment); !ok) {
    return fail(ok.error());
  }
  prepared->max_force_N = largest_force_N(prepared->protocol, prepared->environment);
  const auto is_last = [&](const Step& s) { return *begun && s.id == (*begun)->step_id; };
  if (std::ranges::any_of(prepared->protocol.finally_steps, is_last)) {
    return fail(Errc::invalid_request,
                "run {} was interrupted in `finally`: its steps were over, nothing is left to do",
                run);
  }
  auto point = parse_run_point((*state)->detail);
  if (!point) return fail(point.error());
  auto frame = last_samples(db, run);
  if (!frame) return fail(frame.error());
  Continuation from;
  if (auto r = keep(answers_of(db, run), from.answers); !r) return fail(r.error());
  from.run = run;
  from.step_id = (*state)->step_id;
  from.point = *point;
  from.frame = *frame;
  prepared->continues = std::move(from);
  return prepared;
}

Result<std::vector<ResumableRun>> find_resumable(const Database& db, RigBefore rig) {
  const auto read = [](const Statement& row) {
    return CutOff{row.integer(0), row.integer(1) != 0};
  };
  auto runs = db.rows(
      "SELECT run_id, bench_name <> '' FROM run_end JOIN run ON run.id = run_id WHERE exit_status "
      "= ?1 AND run_id > (SELECT coalesce(max(run_id), 0) FROM run_end WHERE exit_status <> ?1 AND "
      "run_id NOT IN (SELECT run_id FROM run_copy)) ORDER BY run_id",
      read, to_string(ExitStatus::interrupted));
  if (!runs) return fail(runs.error());
  std::vector<ResumableRun> out;
  for (const auto& [run, on_bench] : *runs) {
    const auto prepared = prepare_continuation(db, run);
    // It was continued already, or cut off before its first step or in `finally`.
    if (!prepared) continue;
    const bool gone = on_bench || rig == RigBefore::gone;
    if (gone && has_used_frame(*prepared)) continue;
    ResumableRun& found = out.emplace_back();
    found.run = run;
    found.protocol = prepared->request.protocol_name;
    found.specimen = prepared->request.specimen_name;
    found.step_id = prepared->continues->step_id;
  }
  return out;
}

}  // namespace lcrig
