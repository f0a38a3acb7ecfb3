// SPDX-License-Identifier: Apache-2.0
// Instruments, server and database that the tests of the App's parts share: an open database, a
// server without a socket, and instruments that do what the test says, in virtual time.
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/spawn.hpp"
#include "daemon/app/callers.hpp"
#include "daemon/app/database_writes.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/app/run_starter.hpp"
#include "daemon/control/server.hpp"
#include "daemon/queue/plans.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/sim.hpp"
#include "daemon/service.hpp"
#include "daemon/session.hpp"
#include "model/specimen_file.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"
#include "tests/support/control_fixture.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig::support {

class ToldRig final : public InstrumentFactory {
 public:
  ToldRig(asio::any_io_executor executor, Clock& clock)
      : executor_(std::move(executor)), clock_(clock) {}

  bool real = true;
  bool hangs = false;  // its ports open slowly
  std::optional<Error> refuses;  // they do not open
  bool stands = true;  // the frame confirms every STOP
  Operator* person = nullptr;  // confirms and answers; nullptr: a simulated person
  // Wraps the instruments; may be empty.
  std::function<std::unique_ptr<Instruments>(std::unique_ptr<Instruments>)> wrap;
  std::function<void()> asked;  // called when the meter is asked
  int opened = 0, asks = 0, stops = 0, looks = 0, configs = 0;

  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest wanted) override {
    ++opened;
    while (hangs) co_await clock_.wait_for(std::chrono::milliseconds(10));
    if (refuses) co_return fail(*refuses);
    SimRequest sim(*find_bench("paper"), wanted);
    sim.person = person;
    auto made = make_sim_instruments(executor_, clock_, sim);
    if (made && wrap) co_return wrap(std::move(*made));
    co_return made;
  }
  bool is_real() const override { return real; }
  Task<> ask_meter() override {
    ++asks;
    if (asked) asked();
    co_return;
  }
  Task<bool> make_frame_safe() override {
    ++stops;
    co_return stands;
  }
  Task<bool> watch_ports() override {
    ++looks;
    co_return false;
  }
  void config_changed() override { ++configs; }

 private:
  asio::any_io_executor executor_;
  Clock& clock_;
};

inline constexpr const char* kOneLevel = R"({ "format": "load-protocol/1", "name": "short",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 10, "within_s": 4 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 2, "timeout_s": 60 } ] })";

inline RunRequest one_level() {
  RunRequest out;
  out.protocol_name = "short";
  out.protocol_text = kOneLevel;
  out.specimen_name = "paper-1";
  out.specimen_text = std::string(shipped_specimens().front().text);
  return out;
}

class AppPartsTest : public testing::Test {
 protected:
  void SetUp() override {
    recorder = std::move(Recorder::open(io, clock, Recorder::Options(database)).value());
  }
  // No coroutine may outlive what it uses, so all of them end here.
  void TearDown() override {
    use.end();
    clock.run_for(io, std::chrono::minutes(10));
    EXPECT_EQ(clock.pending(), 0U);
  }
  void begin(Task<> task) { lcrig::spawn(io.get_executor(), std::move(task)); }
  // Runs a task to its end. Unlike run_task it does not need a default constructor of `T`.
  template <class T>
  T run(Task<T> task) {
    std::optional<T> out;
    begin(keep(std::move(task), out));
    clock.run(io, [&out] { return out.has_value(); });
    return std::move(out.value());
  }
  template <class T>
  static Task<> keep(Task<T> task, std::optional<T>& out) {
    auto value = co_await std::move(task);
    out.emplace(std::move(value));
  }
  void pass(Duration time) { clock.run_for(io, time); }
  std::int64_t count(const std::string& sql) const {
    return open_read_only(database).value().integer(sql).value();
  }
  RunStarter make_starter() {
    return RunStarter(io.get_executor(), clock,
                      {database, recorder, rig, known, use, plans, news, writes});
  }

  TempDir dir;
  std::string database = dir.file("a.db");
  VirtualClock clock;
  asio::io_context io{1};
  FakeHandler handler;
  ControlServer server{io.get_executor(), clock, handler};
  ServiceNotifier notifier;
  ToldRig rig{io.get_executor(), clock};
  KnownRig known{clock};
  std::unique_ptr<Recorder> recorder;
  RigUse use{clock};
  QueuePlans plans;
  Callers callers{clock, server, recorder};
  DatabaseWrites writes{io.get_executor(), clock, database, callers};
  News news{server, notifier, use};
};

}  // namespace lcrig::support
