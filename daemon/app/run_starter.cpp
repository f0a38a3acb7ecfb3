// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/run_starter.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "base/name_rule.hpp"
#include "base/spawn.hpp"
#include "base/text.hpp"
#include "daemon/app/database_writes.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/continuation.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/session.hpp"
#include "model/specimen_file.hpp"
#include "protocols/plan/plan.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"
#include "storage/specimens.hpp"

namespace lcrig {

namespace {

RunOutcome outcome_of(const RunResult& result, const RunStatus& last) {
  RunOutcome out;
  out.run = last.run;
  out.exit_status = result.exit_status;
  out.reason = result.reason;
  out.code = result.code;
  out.stands = result.stands;
  out.simulated = last.simulated;
  out.lcr_readings = last.lcr_readings;
  out.measure_readings = last.measure_readings;
  out.unproven_readings = last.unproven_readings;
  out.frame_samples = last.frame_samples;
  return out;
}

}  // namespace

RunStarter::RunStarter(asio::any_io_executor executor, Clock& clock, const Parts& parts)
    : executor_(std::move(executor)), clock_(clock), parts_(parts) {}

// A specimen named without a text may be in the database or ship with the program.
Result<> RunStarter::find_texts(RunRequest& wanted) const {
  if (wanted.protocol_text.empty()) {
    return fail(Errc::invalid_request, "`protocol_text` is missing: send the text of the file");
  }
  if (!wanted.specimen_text.empty()) {
    const auto why = why_no_name(wanted.specimen_name);
    if (!why) return {};
    return fail(Errc::invalid_request, "specimen: the name {}", *why);
  }
  auto db = open_read_only(parts_.database);
  if (!db) return fail(db.error());
  auto stored = find_specimen(*db, wanted.specimen_name);
  if (!stored) return fail(stored.error());
  if (*stored) {
    wanted.specimen_text = (*stored)->text;
    return {};
  }
  for (const ShippedSpecimen& s : shipped_specimens()) {
    if (s.name == wanted.specimen_name) wanted.specimen_text = std::string(s.text);
  }
  if (!wanted.specimen_text.empty()) return {};
  return fail(Errc::invalid_request,
              "no specimen `{}`: `lcrig specimen list` shows the known ones, `lcrig specimen add "
              "FILE` stores one",
              wanted.specimen_name);
}

// Aside, because another program may lock the database for seconds.
Task<Result<PreparedRun>> RunStarter::read(RunRequest request) {
  const auto job = [this, &request]() -> Result<PreparedRun> {
    if (auto found = find_texts(request); !found) return fail(found.error());
    return prepare_run(std::move(request));
  };
  co_return co_await run_aside(executor_, clock_, job);
}

Task<Result<Plan>> RunStarter::plan(RunRequest request) {
  auto claimed = co_await parts_.use.claim(RigUse::State::asking);
  if (!claimed) co_return fail(claimed.error());
  auto plan = co_await preview(std::move(request));
  parts_.use.give_back();
  co_return plan;
}

Task<Result<Plan>> RunStarter::preview(RunRequest request) {
  auto prepared = co_await read(std::move(request));
  if (!prepared) co_return fail(prepared.error());
  auto made = co_await make_session(std::move(*prepared), LearnedBy::plan);
  if (!made) co_return fail(made.error());
  Session& session = *parts_.use.session();
  auto plan = co_await session.preview();
  co_await session.close();
  if (plan) parts_.plans.see(session.rig(), session.places_weights());
  co_return plan;
}

Task<Result<>> RunStarter::make_session(PreparedRun prepared, LearnedBy why) {
  InstrumentsRequest wanted = instruments_for(prepared);
  wanted.why = why;
  auto instruments = co_await parts_.rig.open(wanted);
  if (!instruments) co_return fail(instruments.error());
  if (auto going = parts_.use.may_go_on(); !going) {
    co_await (*instruments)->close();
    co_return going;
  }
  auto session = std::make_unique<Session>(executor_, clock_, *parts_.recorder,
                                           std::move(*instruments), std::move(prepared));
  session->report_to(parts_.known, why);
  parts_.use.take(std::move(session));
  co_return Result<>();
}

Task<Result<RunStarted>> RunStarter::start(Result<PreparedRun> prepared) {
  Result<RunStarted> started;
  if (prepared) {
    started = co_await open(std::move(*prepared));
  } else {
    started = fail(prepared.error());
  }
  if (started) {
    parts_.use.enter(RigUse::State::running);
  } else {
    parts_.use.give_back();
  }
  co_return started;
}

void RunStarter::listen_to(Session& session) {
  Session::Listener out;
  out.events = [this](const std::vector<RunEvent>& events) {
    for (const RunEvent& event : events) parts_.news.event(event);
  };
  out.stop = [this] { parts_.use.tell(); };
  out.goes_on = [this]() -> Result<> {
    auto going = parts_.use.may_go_on();
    return going && guard_ ? guard_(*parts_.use.session()) : going;
  };
  session.set_listener(std::move(out));
}

// If it fails, nothing has moved.
Task<Result<RunStarted>> RunStarter::open(PreparedRun prepared) {
  auto made = co_await make_session(std::move(prepared), LearnedBy::start);
  if (!made) co_return fail(made.error());
  Session& session = *parts_.use.session();
  listen_to(session);
  auto run = co_await session.open();
  if (!run) {
    stranger_ = session.stranger();
    if (const auto lost = session.lost_run()) {
      std::erase_if(resumable_, [&](const ResumableRun& r) { return r.run == *lost; });
    }
    co_await session.close();
    co_return fail(run.error());
  }
  // A stop that came while the row was written ends the run before it moves anything.
  if (const auto& stop = parts_.use.stop_of_start()) session.run()->interrupt(*stop);
  parts_.plans.see(session.rig(), session.places_weights());
  resumable_.clear();  // the rig is no longer as those runs left it
  parts_.news.run_begins(*run);
  spawn(executor_, run_to_its_end());
  RunStarted started;
  started.run = *run;
  started.pressure = session.planned().pressure;
  co_return started;
}

Task<> RunStarter::run_to_its_end() {
  Session& session = *parts_.use.session();
  parts_.news.service_status();
  const MonoTime begin = clock_.now();
  const RunResult result = co_await session.execute();
  const RunStatus last = session.status();
  const PressureArea pressure = session.planned().pressure;
  if (result.stands) co_await session.close();
  RunOutcome ended = outcome_of(result, last);
  ended.pressure = pressure;
  ended.duration_s = to_seconds(clock_.now() - begin);
  ended.wall_s = ended.duration_s;
  ended.anchor = session.anchor();
  parts_.news.status();
  if (result.stands) {
    parts_.use.end_run(ended);
    parts_.news.run_ended(ended);
  } else {
    co_await stop_until_it_stands(std::move(ended));
  }
}

// The run is over, and its frame may move: nothing begins before that frame stands.
Task<> RunStarter::stop_until_it_stands(RunOutcome ended) {
  const std::int64_t run = ended.run;
  const MonoTime end = clock_.now();
  parts_.use.end_run_stopping(ended);
  parts_.news.run_ended(ended);
  parts_.news.service_status();
  Session& session = *parts_.use.session();
  std::function<bool()> gives_up = [this] { return parts_.use.is_ending(); };
  const bool stands = co_await session.stop_until_it_stands(std::move(gives_up));
  const double after_s = to_seconds(clock_.now() - end);
  co_await session.close();
  parts_.use.end_stopping(stands ? std::optional(after_s) : std::nullopt);
  if (!stands) {
    spdlog::critical("{}", alarm_words_after(run));
    co_return;
  }
  auto words = stood_words(after_s);
  spdlog::info("run {}: {}", run, words);
  std::vector<std::int64_t> runs(1, run);
  co_await parts_.writes.note(std::move(runs), std::move(words));
}

// If the search fails the daemon works all the same; `lcrig resume RUN` searches by itself.
void RunStarter::look_for_resumable() {
  auto db = open_read_only(parts_.database);
  const RigBefore rig = parts_.rig.is_real() ? RigBefore::still_there : RigBefore::gone;
  auto found = db ? find_resumable(*db, rig) : fail(db.error());
  if (!found) {
    spdlog::warn("which run can be resumed is not known: {}", printable(found.error().what));
    return;
  }
  resumable_ = std::move(*found);
}

}  // namespace lcrig
