// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/rig_watch.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <system_error>
#include <thread>

#include "base/clock.hpp"
#include "daemon/app/database_writes.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/run_words.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "storage/anchor.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

std::string stored_anchor(const Database& db, std::int64_t run) {
  const auto anchor = get_anchor(db, run);
  return anchor && *anchor ? to_string(**anchor) : std::string();  // empty: no anchor
}

// Whether the run had ended before and its end was deleted.
bool had_ended(const Database& db, std::int64_t orphan) {
  const auto earlier = get_earlier_anchor(db, orphan);
  return earlier && *earlier;
}

bool look(const std::string& database) {
  std::error_code unknown;
  if (!std::filesystem::exists(database, unknown) && !unknown) {
    return !require_safe_to_create(database);  // the database was moved away, or its disk is
                                               // missing
  }
  const auto db = open_read_only(database);
  if (!db) return true;
  const auto runs = unfinished_runs(*db);
  if (!runs) return true;
  return std::ranges::any_of(*runs, [&](std::int64_t run) {
    const auto goes_on = is_being_recorded(database, run);
    return !(goes_on && *goes_on) && commanded_frame(*db, run);
  });
}

}  // namespace

bool commanded_frame(const Database& db, std::int64_t run) {
  const auto row = get_run(db, run);
  if (!row) return true;
  const auto protocol = parse_protocol(row->protocol_text, row->protocol_name);
  return !protocol || commands_frame(*protocol);
}

// A disk that does not answer blocks the thread. The thread then keeps its data alive.
bool may_have_left_motion(const std::string& database, Duration patience) {
  const auto told = std::make_shared<std::promise<bool>>();
  auto answer = told->get_future();
  std::thread([told, database] { told->set_value(look(database)); }).detach();
  return answer.wait_for(patience) != std::future_status::ready || answer.get();
}

bool RigWatch::may_be_left() const {
  constexpr Duration kPatience = 1s;  // for the disk
  return parts_.rig.is_real() && may_have_left_motion(parts_.database, kPatience);
}

Task<> RigWatch::stop_first() {
  spdlog::warn("a run may have been cut off: the frame is stopped before the database is opened");
  stood_first_ = co_await parts_.rig.make_frame_safe();
  if (stood_first_) spdlog::info("the frame confirmed standstill");
}

void RigWatch::look_at_orphans() {
  for (const auto& orphan : parts_.recorder->interrupted_runs()) {
    const auto db = open_read_only(parts_.database);
    spdlog::warn("{}", orphan_line(orphan, db ? stored_anchor(*db, orphan) : std::string(),
                                   db && had_ended(*db, orphan)));
    const bool commanded = !db || commanded_frame(*db, orphan);
    is_due_ = is_due_ || (parts_.rig.is_real() && commanded);
  }
}

Task<bool> RigWatch::make_safe() {
  if (!is_due_) co_return true;
  bool stands = stood_first_;
  if (!stands) stands = co_await parts_.rig.make_frame_safe();
  is_due_ = !stands;
  auto interrupted = parts_.recorder->interrupted_runs();
  if (stands) {
    co_await parts_.writes.note(std::move(interrupted),
                                "lcrigd was restarted: the frame confirmed standstill");
  }
  co_return stands;
}

Task<> RigWatch::ask() {
  const auto is_free = [this] { return parts_.use.is_idle() || parts_.use.is_ending(); };
  bool ready = false;
  // True also when somebody else found the meter not ready any more.
  const auto is_due = [this, &ready] {
    return parts_.use.is_ending() || !parts_.known.is_known(Instrument::lcr) ||
           (ready && !parts_.known.is_ready(Instrument::lcr));
  };
  while (!parts_.use.is_ending()) {
    parts_.use.enter(RigUse::State::asking);
    const bool safe = co_await make_safe();
    co_await parts_.rig.ask_meter();
    parts_.use.enter(RigUse::State::idle);
    ready = parts_.known.is_ready(Instrument::lcr) && safe;
    const MonoTime next = clock_.now() + (ready ? 60s : 10s);
    co_await parts_.use.wait(is_due, next);
    co_await parts_.use.wait(is_free);
  }
}

Task<> RigWatch::watch_ports() {
  const auto is_over = [this] { return parts_.use.is_ending(); };
  while (!parts_.use.is_ending()) {
    if (parts_.use.live_run() == nullptr) {
      const bool changed = co_await parts_.rig.watch_ports();
      if (changed) parts_.use.tell();
    }
    const MonoTime next = clock_.now() + 1s;
    co_await parts_.use.wait(is_over, next);
  }
}

}  // namespace lcrig
