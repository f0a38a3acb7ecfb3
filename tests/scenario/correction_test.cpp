// SPDX-License-Identifier: Apache-2.0
// Open and short correction through the daemon: how they are made, stored and refused, and what a
// run records of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/rehearse.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/memory_pipe.hpp"
#include "storage/chain.hpp"
#include "storage/corrections.hpp"
#include "storage/faulty_disk.hpp"
#include "storage/runs.hpp"
#include "tests/support/daemon_world.hpp"
#include "tests/support/protocol_text.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CorrectedDaemon : public support::DaemonWorld {
 protected:
  json correct(PlainClient& client, const char* kind) {
    return answer(client, "lcr.correct", {{"kind", kind}});
  }
  std::int64_t stored() const { return count("SELECT count(*) FROM lcr_correction"); }
  MeterCorrections of_run(std::int64_t run) const {
    const auto db = open_read_only(dir.file("d.db")).value();
    const auto row = get_run(db, run).value();
    auto meter = parse_corrections(row.correction_json);
    EXPECT_TRUE(meter) << row.correction_json;
    return meter.value_or(MeterCorrections());
  }
  void end_run(PlainClient& client) {
    ASSERT_TRUE(answer(client, "run.abort").contains("result"));
    client.call("watch");
    wait_for(client, [](const json& m) {
      return m.value("method", "") == "run_ended" ||
             (m.contains("result") && m["result"].contains("run") && m["result"]["run"].is_null());
    });
  }
};

TEST_F(CorrectedDaemon, WhatWasMadeIsStoredAndStandsInEveryRunAfterIt) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  end_run(client);
  const MonoTime begin = clock.now();
  const json made = correct(client, "open");
  ASSERT_TRUE(made.contains("result")) << made;
  EXPECT_GT(clock.now() - begin, 20s) << "the meter takes its time";
  EXPECT_EQ(made["result"]["meter"], "LCR-6100 SIM000001");
  EXPECT_EQ(made["result"]["simulated"], true);
  EXPECT_EQ(made["result"]["open"]["on"], true);
  EXPECT_TRUE(made["result"]["open"]["made_unix_ns"].is_number_integer());
  EXPECT_TRUE(made["result"]["short"]["made_unix_ns"].is_null());
  EXPECT_EQ(
      count("SELECT count(*) FROM lcr_correction WHERE kind = 'open' AND simulated = 1 AND"
            " lcr_identity LIKE 'LCR-6100,REV E8.13,%' AND operator <> '' AND operator_uid = " +
            std::to_string(::getuid())),
      1);
  const json seen = answer(client, "lcr.show");
  EXPECT_EQ(seen["result"], made["result"]);
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  end_run(client);
  EXPECT_EQ(of_run(1).open.on, true);
  EXPECT_FALSE(of_run(1).open.made_unix_ns);
  EXPECT_EQ(of_run(2).meter, "LCR-6100 SIM000001");
  EXPECT_EQ(json(of_run(2).open.made_unix_ns.value_or(0)), made["result"]["open"]["made_unix_ns"]);
  EXPECT_FALSE(of_run(2).short_circuit.made_unix_ns);
  const auto db = open_read_only(dir.file("d.db")).value();
  for (const std::int64_t run : {1, 2}) EXPECT_TRUE(verify_chain(db, run).value().intact);
}

TEST_F(CorrectedDaemon, IsRefusedInARunAndARunIsRefusedMeanwhile) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  for (const char* method : {"lcr.correct", "lcr.show"}) {
    const json params =
        std::string_view(method) == "lcr.show" ? json::object() : json{{"kind", "open"}};
    const json refused = answer(client, method, params);
    EXPECT_EQ(refused["error"]["data"]["errc"], "busy") << refused;
    EXPECT_THAT(refused["error"]["message"].get<std::string>(), HasSubstr("run 1 is going on"));
  }
  end_run(client);
  PlainClient other(socket_path());
  other.call("lcr.correct", {{"kind", "short"}});
  clock.run_for(io, 5s);
  const MonoTime asked = clock.now();
  const json start = answer(client, "run.start", start_request());
  EXPECT_EQ(start["error"]["data"]["errc"], "busy");
  EXPECT_THAT(start["error"]["message"].get<std::string>(),
              AllOf(HasSubstr("correction"), HasSubstr("up to two minutes: try again then")));
  EXPECT_EQ(start["error"]["data"]["hint"], "lcrig status   (what goes on)");
  EXPECT_EQ(answer(client, "status")["result"]["correcting"], true);
  EXPECT_LT(clock.now() - asked, 5s) << "at once";
  const json twice = correct(client, "open");
  EXPECT_EQ(twice["error"]["data"]["errc"], "busy") << twice;
  const json made = wait_for(other, [](const json& m) { return m.contains("id"); });
  EXPECT_TRUE(made.contains("result")) << made;
  EXPECT_EQ(stored(), 1);
  EXPECT_EQ(answer(client, "status")["result"]["correcting"], false);
  EXPECT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  end_run(client);
}

TEST_F(CorrectedDaemon, IsRefusedWhileTheQueueGoes) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "queue.add", start_request()).contains("result"));
  ASSERT_TRUE(answer(client, "queue.start").contains("result"));
  const json refused = correct(client, "open");
  EXPECT_EQ(refused["error"]["data"]["errc"], "busy") << refused;
  EXPECT_THAT(refused["error"]["message"].get<std::string>(), HasSubstr("hold it first"));
  EXPECT_EQ(refused["error"]["data"]["command"], "lcrig queue hold");
  ASSERT_TRUE(answer(client, "queue.hold").contains("result"));
  clock.run_for(io, 1s);
  EXPECT_TRUE(correct(client, "open").contains("result"));
}

TEST_F(CorrectedDaemon, AStoppingDaemonDoesNotWaitForTheMeter) {
  PlainClient client(socket_path());
  client.call("lcr.correct", {{"kind", "open"}});
  clock.run_for(io, 5s);
  bool down = false;
  asio::co_spawn(io, app->shut_down("test"), [&](const std::exception_ptr&, bool) { down = true; });
  const json refused = wait_for(client, [](const json& m) { return m.contains("id"); });
  EXPECT_EQ(refused["error"]["data"]["errc"], "aborted") << refused;
  EXPECT_TRUE(clock.run(io, [&] { return down; }));
  EXPECT_EQ(stored(), 0);
}

// A rig with nothing but a meter, which has the fault that the test sets.
class MeterOnly final : public InstrumentFactory {
 public:
  MeterOnly(asio::any_io_executor executor, Clock& clock) : executor_(executor), clock_(clock) {}
  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest) override {
    co_return fail(Errc::unsupported, "a meter only");
  }
  Task<> ask() override { co_return; }
  Task<Result<std::unique_ptr<LoneMeter>>> open_lone_meter() override {
    if (refuses) co_return fail(*refuses);
    std::unique_ptr<LoneMeter> out = std::make_unique<Meter>(executor_, clock_, faults);
    co_return out;
  }
  std::optional<Error> refuses;  // the port does not open
  lcr6100::SimFaults faults;

 private:
  class Meter final : public LoneMeter {
   public:
    Meter(const asio::any_io_executor& executor, Clock& clock, const lcr6100::SimFaults& faults)
        : clock_(clock) {
      auto wire = make_memory_pipe(executor, clock, "sim:lcr");
      sim_ = std::make_unique<lcr6100::Lcr6100Sim>(std::move(wire.far), clock, lcr6100::SimConfig(),
                                                   lcr6100::Lcr6100Sim::Source([](MonoTime) {
                                                     Electrical e;
                                                     e.capacitance_F = 1e-13;
                                                     return e;
                                                   }));
      sim_->faults() = faults;
      meter_ = std::make_unique<lcr6100::Lcr6100>(std::move(wire.near), clock);
      asio::co_spawn(executor, sim_->run(), [this](std::exception_ptr) { runs_ = false; });
    }
    LcrMeter& meter() override { return *meter_; }
    Task<> close() override {
      meter_->close();
      sim_->close();
      while (runs_) co_await clock_.wait_for(1ms);
    }

   private:
    Clock& clock_;
    bool runs_ = true;
    std::unique_ptr<lcr6100::Lcr6100Sim> sim_;
    std::unique_ptr<lcr6100::Lcr6100> meter_;
  };

  asio::any_io_executor executor_;
  Clock& clock_;
};

class FaultyMeter : public CorrectedDaemon {
 protected:
  AppParts parts() override {
    AppParts out;
    auto made = std::make_unique<MeterOnly>(io.get_executor(), clock);
    rig = made.get();
    out.rig = std::move(made);
    return out;
  }
  std::string refusal(const char* errc) {
    PlainClient client(socket_path());
    const json refused = correct(client, "open");
    EXPECT_EQ(refused["error"]["data"]["errc"], errc) << refused;
    EXPECT_EQ(stored(), 0);
    return refused.value("/error/message"_json_pointer, "");
  }
  MeterOnly* rig = nullptr;
};

TEST_F(FaultyMeter, ThatSaysFailIsToldInItsWordsAndNothingIsStored) {
  rig->faults.correction_fails = true;
  EXPECT_THAT(refusal("refused"), HasSubstr("check fixture and leads"));
  rig->faults.correction_fails = false;
  PlainClient client(socket_path());
  EXPECT_TRUE(correct(client, "open").contains("result"));
  EXPECT_EQ(stored(), 1);
}

TEST_F(FaultyMeter, ThatIsSilentIsToldWithWhatToLookAt) {
  rig->faults.silent = true;
  EXPECT_THAT(refusal("no_reply"), HasSubstr("check power and cable"));
}

TEST_F(FaultyMeter, ThatGivesNoVerdictEndsAfterTwoMinutes) {
  // Greeting, fifteen settings and the sweep's first answer arrive; its second, the verdict, is
  // lost.
  rig->faults.replies.assign(2 + 15 + 1, lcr6100::SimFaults::Reply(lcr6100::SimFaults::Kind::none));
  rig->faults.replies.emplace_back(lcr6100::SimFaults::Kind::drop);
  const MonoTime begin = clock.now();
  EXPECT_THAT(refusal("no_reply"), HasSubstr("CORR:OPEN:LCR -> no verdict in 120 s"));
  EXPECT_GT(clock.now() - begin, 2min);
  EXPECT_LT(clock.now() - begin, 3min);
}

TEST_F(FaultyMeter, WhosePortIsNotThereIsToldAsTheportSaysIt) {
  rig->refuses = Error(Errc::disconnected, "/dev/lcr: no such port");
  EXPECT_EQ(refusal("disconnected"), "/dev/lcr: no such port");
}

TEST(CorrectorAlone, MakesNoneThatTheDiskHasNoRoomFor) {
  const TempDir dir;
  VirtualClock clock;
  asio::io_context io{1};
  MeterOnly rig(io.get_executor(), clock);
  rig.refuses = Error(Errc::unsupported, "the meter was used");
  KnownRig known(clock);
  const std::string database = dir.file("a.db"), vfs;
  Corrector corrector({io.get_executor(), clock, rig, known, database, vfs, std::int64_t{1} << 60});
  std::optional<Result<MeterCorrections>> made;
  asio::co_spawn(io, corrector.make(CorrectionKind::open, PeerCredentials()),
                 [&](const std::exception_ptr&, Result<MeterCorrections> got) { made = got; });
  EXPECT_TRUE(clock.run(io, [&] { return made.has_value(); }));
  ASSERT_FALSE(*made);
  EXPECT_EQ(made->error().code, Errc::io);
  EXPECT_THAT(made->error().what, HasSubstr("MB are free, but"));
}

class DaemonWithAFullDisk : public CorrectedDaemon {
 protected:
  AppParts parts() override {
    AppParts out;
    out.vfs = disk.name();
    return out;
  }
  FaultyDisk disk;
};

TEST_F(DaemonWithAFullDisk, SaysThatTheCorrectionIsOnButNotStored) {
  PlainClient client(socket_path());
  client.call("lcr.correct", {{"kind", "open"}});
  clock.run_for(io, 5s);
  disk.set_full(true);
  disk.fail_operation(0, FaultyDisk::Failure::full);
  const json refused = wait_for(client, [](const json& m) { return m.contains("id"); });
  EXPECT_EQ(refused["error"]["data"]["errc"], "io") << refused;
  EXPECT_THAT(refused["error"]["message"].get<std::string>(),
              AllOf(HasSubstr("the open correction is on at the meter, but not stored: "),
                    HasSubstr("no space is left on its disk"), Not(HasSubstr("INSERT"))));
  EXPECT_EQ(refused["error"]["data"]["hint"],
            "see to what the message names, then: lcrig lcr correct open");
  EXPECT_EQ(stored(), 0);
  disk.set_full(false);
  EXPECT_TRUE(correct(client, "open").contains("result"));
  EXPECT_EQ(stored(), 1);
}

class ReplayingDaemon : public CorrectedDaemon {
 protected:
  void configure(Config& config) override { config.bench = "replay:" + dir.file("none"); }
};

TEST_F(ReplayingDaemon, HasNoMeterToCorrect) {
  PlainClient client(socket_path());
  EXPECT_EQ(correct(client, "open")["error"]["data"]["errc"], "unsupported");
}

RehearseRequest rehearsal(const std::string& db) {
  RehearseRequest out;
  out.protocol_name = "static-frame";
  out.protocol_text = library("static-frame");
  out.parameters = {{"levels", "3"}, {"repeats", "1"}, {"readings", "3"}, {"within_s", "1.5"}};
  out.specimen_name = "paper-1";
  out.specimen_text = std::string(shipped_specimens().front().text);
  out.db_path = db;
  return out;
}

std::string correction_in(const std::string& path) {
  const auto db = open_read_only(path).value();
  return get_run(db, 1).value().correction_json;
}

TEST(CorrectedRehearsal, SaysTheSameEachTimeAndThatABenchIsCorrected) {
  const TempDir dir;
  for (const char* name : {"a.db", "b.db"}) {
    const auto done = rehearse(rehearsal(dir.file(name)));
    ASSERT_TRUE(done) << done.error().what;
    EXPECT_EQ(done->exit_status, ExitStatus::success) << done->reason;
  }
  EXPECT_EQ(correction_in(dir.file("a.db")), correction_in(dir.file("b.db")));
  const auto meter = parse_corrections(correction_in(dir.file("a.db")));
  ASSERT_TRUE(meter);
  EXPECT_EQ(meter->open.on, true);
  EXPECT_EQ(meter->short_circuit.on, true);
  EXPECT_FALSE(meter->open.made_unix_ns);
}

}  // namespace
}  // namespace lcrig
