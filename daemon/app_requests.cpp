// SPDX-License-Identifier: Apache-2.0
// Requests of clients of the control socket: runs that start, go on and stop, specimens.
#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "daemon/app.hpp"
#include "daemon/continuation.hpp"
#include "daemon/control/audit.hpp"
#include "daemon/run_words.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/specimens.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t kLongestReason = 500;  // characters in the journal

std::string for_whom(const std::string& operator_name) {
  return operator_name.empty() ? "" : ", for " + printable(operator_name);
}

}  // namespace

// One run at a time. The caller that claimed the instruments gives them back with `enter`.
Task<Result<>> App::claim(Use use) {
  const MonoTime patience = clock_.now() + 30s;
  const auto is_known = [this] {
    return use_ == Use::idle || use_ == Use::correcting || session_ != nullptr || shutting_down_;
  };
  co_await changed_.wait(is_known, patience);
  if (shutting_down_) co_return fail(Errc::busy, "the daemon is shutting down");
  if (const Run* run = live_run()) {
    co_return fail(Errc::busy,
                   "run {} is going on: one run at a time; `lcrig watch` shows it, "
                   "`lcrig abort` ends it",
                   run->progress().run);
  }
  if (use_ == Use::correcting) {
    co_return fail(Errc::busy,
                   "the open or the short correction of the meter is being made: try again in two "
                   "minutes");
  }
  if (use_ != Use::idle) {
    co_return fail(Errc::busy,
                   "a run is being prepared, or the instruments are being asked who they are: try "
                   "again in a minute");
  }
  enter(use);
  co_return Result<>();
}

// One line in the journal: who wanted what, and why not.
Task<> App::tell_refusal(std::string wanted, PeerCredentials peer, Error error) {
  peer.user = co_await user_name(peer, kNamePatienceOfStops);
  spdlog::warn("no run begins: {} asked for {}: {}", peer_words(peer), printable(wanted),
               printable(error.what, kLongestReason));
}

Task<Result<RunStarted>> App::start_run(RunRequest request, PeerCredentials peer) {
  auto wanted = fmt::format("{} on {}", request.protocol_name, request.specimen_name);
  auto started = co_await begin_run(std::move(request), peer);
  if (!started) co_await tell_refusal(std::move(wanted), std::move(peer), started.error());
  co_return started;
}

Task<Result<RunStarted>> App::begin_run(RunRequest request, PeerCredentials& peer) {
  if (auto free = leaves_to_queue(); !free) co_return fail(free.error());
  auto claimed = co_await claim(Use::starting);
  if (!claimed) co_return fail(claimed.error());
  peer.user = co_await user_name(peer, kNamePatience);
  if (request.operator_name.empty()) request.operator_name = peer.user;
  auto prepared = co_await read_request(std::move(request));
  auto started = co_await start_claimed(std::move(prepared));
  if (started) recorder_->event(request_event(clock_.now(), "run.start", peer));
  co_return started;
}

Task<Result<RunOutcome>> App::run_through(PreparedRun prepared) {
  spawn(heartbeat());
  auto claimed = co_await claim(Use::starting);
  if (!claimed) co_return fail(claimed.error());
  auto started = co_await start_claimed(std::move(prepared));
  if (!started) co_return fail(started.error());
  const auto over = [this] { return use_ == Use::idle; };
  co_await changed_.wait(over);
  co_return *last_run_;
}

Task<Result<RunStarted>> App::start_claimed(Result<PreparedRun> prepared) {
  Result<RunStarted> started;
  if (prepared) {
    started = co_await open_run(std::move(*prepared));
  } else {
    started = fail(prepared.error());
  }
  stop_of_start_.reset();
  if (!started) session_.reset();
  enter(started ? Use::running : Use::idle);
  co_return started;
}

Task<Result<PreparedRun>> App::read_request(RunRequest request) {
  const auto read = [this, &request]() -> Result<PreparedRun> {
    if (auto found = find_texts(request); !found) return fail(found.error());
    return prepare_run(std::move(request));
  };
  co_return co_await run_aside(io_.get_executor(), clock_, read);
}

Result<> App::not_stopped() const {
  if (shutting_down_) return fail(Errc::aborted, "the daemon is stopping");
  if (!stop_of_start_) return {};
  return fail(Errc::aborted, "stopped while it was being prepared ({}): nothing has moved",
              stop_of_start_->why);
}

// Looks at the rig and plans; the frame is not commanded.
Task<Result<Plan>> App::plan_run(RunRequest request, PeerCredentials /*peer*/) {
  auto claimed = co_await claim(Use::asking);
  if (!claimed) co_return fail(claimed.error());
  auto plan = co_await preview(std::move(request));
  session_.reset();
  enter(Use::idle);
  co_return plan;
}

Task<Result<Plan>> App::preview(RunRequest request) {
  auto prepared = co_await read_request(std::move(request));
  if (!prepared) co_return fail(prepared.error());
  auto made = co_await make_session(std::move(*prepared), LearnedBy::plan);
  if (!made) co_return fail(made.error());
  auto plan = co_await session_->preview();
  co_await session_->close();
  if (plan) plans_.see(session_->rig(), session_->places_weights());
  co_return plan;
}

Task<Result<>> App::ask_instruments(PeerCredentials /*peer*/) {
  auto claimed = co_await claim(Use::asking);
  if (!claimed) co_return claimed;
  co_await rig_->ask();
  enter(Use::idle);
  co_return Result<>();
}

Task<Result<>> App::make_session(PreparedRun prepared, LearnedBy why) {
  InstrumentsRequest wanted = instruments_for(prepared);
  wanted.why = why;
  auto instruments = co_await rig_->open(wanted);
  if (!instruments) co_return fail(instruments.error());
  if (auto going = not_stopped(); !going) {
    co_await (*instruments)->close();
    co_return going;
  }
  session_ = std::make_unique<Session>(io_.get_executor(), clock_, *recorder_,
                                       std::move(*instruments), std::move(prepared));
  session_->report_to(known_, why);
  changed_.notify_all();
  co_return Result<>();
}

// Nothing moves when it fails.
Task<Result<RunStarted>> App::open_run(PreparedRun prepared) {
  auto made = co_await make_session(std::move(prepared), LearnedBy::start);
  if (!made) co_return fail(made.error());
  Session::Listener listener;
  listener.events = [this](const std::vector<RunEvent>& events) {
    for (const RunEvent& event : events) publish_event(event);
  };
  listener.stop = [this] { changed_.notify_all(); };
  listener.goes_on = [this] { return may_begin(); };
  session_->set_listener(std::move(listener));
  auto run = co_await session_->open();
  if (!run) {
    stranger_ = session_->stranger();
    if (const auto lost = session_->lost_run()) {
      std::erase_if(resumable_, [&](const ResumableRun& r) { return r.run == *lost; });
    }
    co_await session_->close();
    co_return fail(run.error());
  }
  // Asked for while the run row was written: the run ends before it moves anything.
  if (stop_of_start_) session_->run()->interrupt(*stop_of_start_);
  plans_.see(session_->rig(), session_->places_weights());
  resumable_.clear();  // the rig is not as they left it any more
  const RunProgress begun = session_->run()->progress();
  spdlog::info("{} begins: {} on {}{}", run_words(session_->simulated(), *run),
               printable(begun.protocol), printable(begun.specimen),
               for_whom(session_->operator_name()));
  spawn(run_to_its_end());
  RunStarted started;
  started.run = *run;
  co_return started;
}

// Clients send texts; a specimen may also be one of the database or one that ships. Not on the
// thread of the instruments: another program may hold the database for seconds.
Result<> App::find_texts(RunRequest& wanted) const {
  if (wanted.protocol_text.empty()) {
    return fail(Errc::invalid_request, "`protocol_text` is missing: send the text of the file");
  }
  if (!wanted.specimen_text.empty()) return {};
  auto db = open_read_only(config_.database);
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

Task<std::string> App::user_name(const PeerCredentials& peer, Duration patience) const {
  if (!control_) co_return peer.user;
  co_return co_await control_->user_name(peer.uid, patience);
}

Task<Result<>> App::pause(PeerCredentials peer) {
  peer.user = co_await user_name(peer, kNamePatienceOfStops);
  Run* run = live_run();
  if (run == nullptr) co_return fail(Errc::invalid_request, "no run is going on");
  recorder_->event(request_event(clock_.now(), "run.pause", peer));
  run->interrupt(InterruptRequest(Interrupt::pause, "by " + peer.user));
  co_return Result<>();
}

Task<Result<RunStarted>> App::resume(std::optional<std::int64_t> run, bool confirmed,
                                     PeerCredentials peer) {
  if (live_run() == nullptr && run) {
    co_return co_await continue_run(*run, confirmed, std::move(peer));
  }
  peer.user = co_await user_name(peer, kNamePatience);
  Run* live = live_run();
  if (live == nullptr || (run && *run != live->progress().run)) {
    co_return fail(Errc::invalid_request, "no such run is paused");
  }
  if (!live->resume()) {
    co_return fail(Errc::invalid_request, "run {} is not paused", live->progress().run);
  }
  recorder_->event(request_event(clock_.now(), "run.resume", peer));
  RunStarted going;
  going.run = live->progress().run;
  co_return going;
}

Task<Result<RunStarted>> App::continue_run(std::int64_t run, bool confirmed, PeerCredentials peer) {
  auto started = co_await begin_continuation(run, confirmed, peer);
  auto wanted = fmt::format("the continuation of run {}", run);
  if (!started) co_await tell_refusal(std::move(wanted), std::move(peer), started.error());
  co_return started;
}

Task<Result<RunStarted>> App::begin_continuation(std::int64_t run, bool confirmed,
                                                 PeerCredentials& peer) {
  if (auto free = leaves_to_queue(); !free) co_return fail(free.error());
  auto claimed = co_await claim(Use::starting);
  if (!claimed) co_return fail(claimed.error());
  peer.user = co_await user_name(peer, kNamePatience);
  const auto read = [this, run, confirmed, &peer]() -> Result<PreparedRun> {
    auto db = open_read_write(config_.database);
    if (!db) return fail(db.error());
    auto prepared = prepare_continuation(*db, run);
    if (!prepared) return prepared;
    prepared->continues->confirmed = confirmed;
    prepared->request.operator_name = peer.user;
    return prepared;
  };
  auto prepared = co_await run_aside(io_.get_executor(), clock_, read);
  auto started = co_await start_claimed(std::move(prepared));
  if (!started) co_return started;
  recorder_->event(request_event(clock_.now(), "run.resume", peer));
  std::vector<std::int64_t> before;
  before.push_back(run);
  auto text = fmt::format("continued by run {}", started->run);
  co_await note_runs(std::move(before), std::move(text));
  co_return started;
}

Task<Result<StopAnswer>> App::stop_run(Interrupt kind, std::string why, PeerCredentials peer) {
  peer.user = co_await user_name(peer, kNamePatienceOfStops);
  const std::string reason = why.empty() ? "by " + peer.user : why + " (by " + peer.user + ")";
  Run* run = live_run();
  if (run == nullptr && use_ == Use::starting) co_return stop_start(kind, reason);
  if (run == nullptr) co_return fail(Errc::invalid_request, "no run is going on");
  const char* request = kind == Interrupt::freeze ? "run.freeze" : "run.abort";
  recorder_->event(request_event(clock_.now(), request, peer, why));
  const std::uint64_t stands = run->stands(), failures = run->failed_stops();
  const Run::Taken taken = run->interrupt(InterruptRequest(kind, reason));
  if (taken == Run::Taken::finally_goes_on) {
    co_return StopAnswer(
        StopState::finally,
        "`finally` is running and goes on: the frame moves to unload the specimen; "
        "lcrig freeze stops it at once");
  }
  co_return co_await confirm_stop(*run, stands, failures);
}

// Nothing may move from here on; the start that is being prepared answers with an error.
StopAnswer App::stop_start(Interrupt kind, std::string why) {
  stop_of_start_ = InterruptRequest(kind, std::move(why));
  return StopAnswer(StopState::not_begun,
                    "the run that is being prepared does not begin: nothing moves");
}

// "Stopped" is said only of a frame that confirmed it after the request.
Task<Result<StopAnswer>> App::confirm_stop(Run& run, std::uint64_t stands, std::uint64_t failures) {
  const MonoTime limit = clock_.now() + 70s;  // two STOPs of the slowest machine
  const auto is_known = [this, &run, stands, failures] {
    return live_run() != &run || run.stands() != stands || run.failed_stops() > failures;
  };
  co_await changed_.wait(is_known, limit);
  const bool gone = live_run() != &run;
  if (!gone && run.stands() == stands) {
    co_return fail(Errc::not_standing, "standstill not confirmed: use the E-stop");
  }
  if (gone && last_run_ && last_run_->code == Errc::not_standing) {
    co_return fail(Errc::not_standing, "standstill not confirmed: use the E-stop");
  }
  if (!gone && !run.commands()) {
    co_return StopAnswer(StopState::not_ours,
                         "the recording ends; the frame was only observed and is not stopped");
  }
  co_return StopAnswer(StopState::standing, "stopped");
}

Task<Result<StopAnswer>> App::abort(std::string why, PeerCredentials peer) {
  co_return co_await stop_run(Interrupt::abort, std::move(why), std::move(peer));
}

Task<Result<StopAnswer>> App::freeze(std::string why, PeerCredentials peer) {
  auto stopped = co_await stop_run(Interrupt::freeze, std::move(why), std::move(peer));
  if (stopped && stopped->state == StopState::standing) {
    stopped->note = "stopped; the frame stays where it is";
  }
  co_return stopped;
}

// Not on the thread of the instruments: another program may hold the database for seconds.
Task<Result<>> App::note_run(std::int64_t run, std::string text, PeerCredentials peer) {
  if (storing_) co_return fail(Errc::busy, "another note or specimen is being stored: try again");
  storing_ = true;
  peer.user = co_await user_name(peer, kNamePatience);
  const std::int64_t now = clock_.unix_ns();
  const auto store = [this, run, &text, &peer, now]() -> Result<> {
    auto db = open_read_write(config_.database);
    if (!db) return fail(db.error());
    return add_run_note(*db, run, peer.user, text, now);
  };
  auto noted = co_await run_aside(io_.get_executor(), clock_, store);
  storing_ = false;
  if (noted) spdlog::info("a note was added to run {} for {}", run, peer_words(peer));
  co_return noted;
}

Task<Result<std::string>> App::add_specimen(std::string text, PeerCredentials peer) {
  if (storing_) co_return fail(Errc::busy, "another note or specimen is being stored: try again");
  storing_ = true;
  const std::int64_t now = clock_.unix_ns();
  const auto store = [this, &text, now]() -> Result<std::string> {
    auto specimen = parse_specimen(text, "specimen");
    if (!specimen) return fail(specimen.error());
    auto db = open_read_write(config_.database);
    if (!db) return fail(db.error());
    auto stored = lcrig::add_specimen(*db, specimen->name, text, now);
    if (!stored) return fail(stored.error());
    return specimen->name;
  };
  auto name = co_await run_aside(io_.get_executor(), clock_, store);
  storing_ = false;
  peer.user = co_await user_name(peer, kNamePatience);
  if (name) spdlog::info("specimen {} stored for {}", printable(*name), peer_words(peer));
  co_return name;
}

}  // namespace lcrig
