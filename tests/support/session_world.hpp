// SPDX-License-Identifier: Apache-2.0
// A whole run in virtual time: recorder, session and simulated instruments. A test can act in the
// middle of a step. For scenario tests.
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/rig/instruments.hpp"
#include "daemon/rig/sim.hpp"
#include "daemon/session.hpp"
#include "model/specimen_file.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"
#include "tests/support/replayed.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {

class SessionWorld {
 public:
  // `act` is called `after` the beginning of the step with this id.
  struct Act {
    std::string step_id;
    Duration after{};
    std::function<void(SessionWorld&)> act;
  };

  explicit SessionWorld(std::string protocol_text) : text_(std::move(protocol_text)) {}
  virtual ~SessionWorld() = default;

  Bench bench = *find_bench("paper");
  bool in_memory = false;  // keeps the database in memory, not on the disk
  bool judges_again = true;  // the stored run, as `lcrig watch replay`
  ParameterValues parameters;
  std::string specimen_name = "paper-1";
  std::string specimen_text{shipped_specimens().front().text};
  std::vector<Act> acts;

  // Returns the outcome, or why the run did not begin.
  Result<RunResult> run() {
    RunRequest request;
    request.protocol_name = "test";
    request.protocol_text = text_;
    request.parameters = parameters;
    request.specimen_name = specimen_name;
    request.specimen_text = specimen_text;
    auto prepared = prepare_run(std::move(request));
    if (!prepared) return fail(prepared.error());
    SimRequest sim(bench, instruments_for(*prepared));
    Recorder::Options options(database());
    if (in_memory) keep_in_memory(options);
    adjust(sim, options);
    auto instruments = make_sim_instruments(io.get_executor(), clock, sim);
    if (!instruments) return fail(instruments.error());
    auto recorder = Recorder::open(io, clock, std::move(options));
    if (!recorder) return fail(recorder.error());
    recorder_ = std::move(*recorder);
    session = std::make_unique<Session>(io.get_executor(), clock, *recorder_,
                                        std::move(*instruments), std::move(*prepared));
    built();
    asio::co_spawn(io, play(), [](std::exception_ptr e) {
      if (e) std::rethrow_exception(e);
    });
    clock.run(io, [this] { return outcome_.has_value() && clock.pending() == 0; });
    recorder_.reset();
    if (judges_again && outcome_ && *outcome_) {
      EXPECT_EQ(replay_difference(open(), 1), "") << "the watch, judging the stored run again";
    }
    if (!outcome_) return fail(Errc::bug, "the run never ended");
    return *outcome_;
  }

  std::string database() const { return dir_.file("t.db"); }
  Database open() const {
    auto db = open_read_only(database(), in_memory ? kInMemory : "");
    if (!db) throw std::runtime_error(db.error().what);
    return std::move(*db);
  }
  // First column of the first row of a query on the finished run.
  std::int64_t count(const std::string& sql) const {
    const Database db = open();
    return db.integer(sql).value();
  }
  double real(const std::string& sql) const {
    const Database db = open();
    auto s = db.prepare(sql).value();
    if (!s.step().value()) throw std::runtime_error("no row: " + sql);
    return s.real(0);
  }
  std::string text(const std::string& sql) const {
    const Database db = open();
    auto s = db.prepare(sql).value();
    if (!s.step().value()) return "";
    return std::string(s.text(0));
  }
  void interrupt(Interrupt kind, const std::string& why = "test") {
    session->run()->interrupt(InterruptRequest(kind, why));
  }

 protected:
  virtual void adjust(SimRequest& /*sim*/, Recorder::Options& /*recorder*/) {}
  virtual void built() {}  // before anything is sent to an instrument
  virtual void began() {}  // the run row is stored
  virtual void ended() {}  // the run row is closed, the ports are open

 private:
  // Keeps a connection open. Otherwise the database in memory would vanish with the recorder's.
  void keep_in_memory(Recorder::Options& options) {
    options.vfs = kInMemory;
    kept_ = Database::open(database(), Database::Mode::read_write_create, kInMemory).value();
  }

  TempDir dir_;
  Database kept_;

 public:
  VirtualClock clock;
  asio::io_context io{1};
  std::unique_ptr<Session> session;

 private:
  Task<> play() {
    auto opened = co_await session->open();
    if (opened) {
      began();
      for (Act& act : acts) {
        asio::co_spawn(io, wait_and_act(act), [](std::exception_ptr e) {
          if (e) std::rethrow_exception(e);
        });
      }
      RunResult result = co_await session->execute();
      outcome_.emplace(std::move(result));
    } else {
      outcome_.emplace(fail(opened.error()));
    }
    ended();
    co_await session->close();
  }

  Task<> wait_and_act(Act& act) {
    while (session->run()->progress().step_id != act.step_id) {
      if (outcome_) co_return;
      co_await clock.wait_for(std::chrono::milliseconds(1));
    }
    co_await clock.wait_for(act.after);
    act.act(*this);
  }

  std::string text_;
  std::unique_ptr<Recorder> recorder_;
  std::optional<Result<RunResult>> outcome_;
};

inline void expect_cleared(const SessionWorld& world) {
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='clear' AND kind='motion' AND "
                        "detail LIKE '%\"target\"%'"),
            1)
      << "`finally` did not clear the specimen";
}

// The machine at the far end of the frame's wire, while a run goes on.
inline ZwickSim& frame(SessionWorld& world) {
  return *world.session->instruments().door()->frame_sim();
}

}  // namespace lcrig
