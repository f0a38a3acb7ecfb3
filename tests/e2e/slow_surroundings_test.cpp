// SPDX-License-Identifier: Apache-2.0
// The thread that runs the instruments waits for nobody else: not for the disk of the wire log, the
// database of users, a program that holds the lock of the database, a journal that accepts nothing,
// a port that opens slowly or a node that is slow to look at. Readings keep their planned instants.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "base/clock.hpp"
#include "model/specimen_file.hpp"
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

// 60 readings at 5 per second.
constexpr const char* kPlannedReadings = R"({ "format": "load-protocol/1", "name": "planned",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "level", "do": "measure", "count": 60, "within_s": 12 } ],
  "finally": [] })";

constexpr const char* kPatientRecord = R"({ "format": "load-protocol/1", "name": "patient",
  "on_loss": "wait",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast" }, "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "record", "do": "record", "for_s": 8 } ],
  "finally": [] })";

class SlowSurroundings : public Rig {
 protected:
  void SetUp() override {
    Rig::SetUp();
    // The preloaded library comes before that of a sanitizer, of which it needs nothing.
    const char* asan = std::getenv("ASAN_OPTIONS");
    daemon_variables_["ASAN_OPTIONS"] =
        std::string(asan == nullptr ? "" : asan) + ":verify_asan_link_order=0";
    daemon_variables_["LD_PRELOAD"] = LCRIG_SLOW_CALLS;
    start_sim();
  }

  static std::string add_specimen() {
    const std::string text(shipped_specimens().front().text);
    return json{
        {"jsonrpc", "2.0"}, {"id", 1}, {"method", "specimen.add"}, {"params", {{"text", text}}}}
        .dump();
  }

  // Starts the run and returns once it takes readings.
  void begin() {
    client_ = std::make_unique<Control>(control());
    client_->call("watch");
    ASSERT_TRUE(start_run(*client_, kPlannedReadings).contains("result"));
    client_->wait_for("status", [](const json& s) { return s.value("measure_readings", 0) > 3; });
  }

  // Judges each reading by what the machine was able to do at the time.
  void expect_readings_at_their_instants() {
    EXPECT_EQ(client_->run_ended(60s).value("exit_status", ""), "success");
    std::istringstream rows(
        query("SELECT planned_mono_ns || ' ' || asked_mono_ns FROM lcr_reading "
              "WHERE planned_mono_ns IS NOT NULL"));
    int readings = 0;
    Duration worst{};
    for (std::int64_t planned = 0, asked = 0; rows >> planned >> asked; ++readings) {
      const Duration late = Duration(asked - planned);
      worst = std::max(worst, late);
      const MonoTime from{Duration(planned)}, to{Duration(asked)};
      EXPECT_LT(late - machine_.within(from, to), 100ms) << "reading " << readings;
    }
    EXPECT_EQ(readings, 60);
    std::cout << "latest reading: " << to_seconds(worst) * 1e3 << " ms after its instant\n";
  }

  void lose_the_meter() {
    start_daemon(config());
    Control client = control();
    client.call("watch");
    ASSERT_TRUE(start_run(client, kPatientRecord).contains("result"));
    client.wait_for("status", [](const json& s) { return s.value("step", "") == "record"; }, 30s);
    sim("unplug lcr");
    const auto is_event = [](const char* kind) {
      return [kind](const json& e) { return e.value("kind", "") == kind; };
    };
    client.wait_for("event", is_event("loss"));
    sim("plug lcr");
    client.wait_for("event", is_event("reconnected"), 30s);
    EXPECT_EQ(client.run_ended(60s).value("exit_status", ""), "success");
    std::istringstream rows(query("SELECT received_mono_ns FROM frame_sample ORDER BY seq"));
    Duration worst{};
    MonoTime last{};
    for (std::int64_t at = 0; rows >> at; last = MonoTime(Duration(at))) {
      if (last == MonoTime()) continue;
      const MonoTime now{Duration(at)};
      worst = std::max(worst, now - last);
      EXPECT_LT(now - last - machine_.within(last, now), 300ms);
    }
    EXPECT_GT(last, MonoTime());
    std::cout << "longest time without a sample: " << to_seconds(worst) * 1e3 << " ms\n";
  }

  std::unique_ptr<Control> client_;
  StandstillWatch machine_;
};

TEST_F(SlowSurroundings, ADiskOfTheWireLogThatIsBusyDelaysNoReading) {
  daemon_variables_["SLOW_WIRE_LOG_MS"] = "300";
  json logged = config();
  std::filesystem::create_directory(file("wires"));
  logged["wire_log_directory"] = file("wires");
  Child& daemon = start_daemon(logged);
  begin();
  expect_readings_at_their_instants();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(20s), 0);
  // When the daemon has ended, the logs hold every byte of the run.
  std::size_t logs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(file("wires"))) {
    std::ifstream in(entry.path());
    std::stringstream text;
    text << in.rdbuf();
    EXPECT_TRUE(text.str().starts_with("wire-log/1\n")) << entry.path();
    EXPECT_TRUE(text.str().ends_with("\"\n")) << entry.path();
    ++logs;
  }
  EXPECT_GE(logs, 3U) << "of the meter when it was asked, of meter and frame in the run";
}

TEST_F(SlowSurroundings, ADatabaseOfUsersThatIsBusyDelaysNoReading) {
  daemon_variables_["SLOW_USERS_MS"] = "4000";
  start_daemon(config());
  begin();
  for (int i = 0; i < 5; ++i) {
    const auto shown = lcrig({"status", "--socket", file("control.sock")});
    EXPECT_EQ(shown.code, 0) << shown.err;
  }
  expect_readings_at_their_instants();
  EXPECT_EQ(query("SELECT operator FROM run"), "uid " + std::to_string(::getuid()) + "\n")
      << "the name did not come within 2 s";
}

TEST_F(SlowSurroundings, AHeldWriteLockDelaysNoReading) {
  start_daemon(config());
  begin();
  LineClient clerk(file("control.sock"));
  {
    const auto other = open_read_write(file("lcrig.db"));
    ASSERT_TRUE(other) << other.error().what;
    const auto held = Transaction::begin(*other);
    ASSERT_TRUE(held) << held.error().what;
    clerk.send(add_specimen());  // waits for the lock, but nobody waits for this call
    EXPECT_EQ(clerk.next(3s), std::nullopt);
  }
  const auto added = clerk.next(20s);
  ASSERT_TRUE(added);
  EXPECT_THAT(*added, HasSubstr("paper-1"));
  expect_readings_at_their_instants();
}

// The lock is held longer than one attempt at it lasts. The run goes on, and no row is lost.
TEST_F(SlowSurroundings, AWriteLockThatIsHeldForSevenSecondsCostsNoRow) {
  start_daemon(config());
  begin();
  {
    const auto other = open_read_write(file("lcrig.db"));
    ASSERT_TRUE(other) << other.error().what;
    const auto held = Transaction::begin(*other);
    ASSERT_TRUE(held) << held.error().what;
    std::this_thread::sleep_for(7s);
  }
  expect_readings_at_their_instants();
  EXPECT_EQ(query("SELECT count(*) FROM event WHERE kind = 'database_locked'"), "1\n");
}

// The frame is still watched while the meter goes and comes back.
TEST_F(SlowSurroundings, APortThatOpensSlowlyDelaysNoSampleOfTheFrame) {
  daemon_variables_["SLOW_PORTS_MS"] = "800";
  lose_the_meter();
}

TEST_F(SlowSurroundings, APortThatWentAwayAndClosesSlowlyDelaysNoSampleOfTheFrame) {
  daemon_variables_["SLOW_CLOSES_MS"] = "3000";
  lose_the_meter();
}

TEST_F(SlowSurroundings, ANodeThatIsSlowToLookAtDelaysNoClient) {
  daemon_variables_["SLOW_NODES_MS"] = "700";
  start_daemon(config());
  Control client = control();
  const RealClock clock;
  Duration worst{};
  for (const MonoTime end = clock.now() + 4s; clock.now() < end;) {
    const MonoTime asked = clock.now();
    client.call("status");
    const MonoTime answered = clock.now();
    worst = std::max(worst, answered - asked);
    EXPECT_LT(answered - asked - machine_.within(asked, answered), 300ms);
  }
  std::cout << "longest wait for an answer: " << to_seconds(worst) * 1e3 << " ms\n";
}

// A full pipe takes the place of standard error.
TEST_F(SlowSurroundings, AJournalThatTakesNothingDelaysNoReading) {
  const std::string journal = file("d1.log");
  ASSERT_EQ(::mkfifo(journal.c_str(), 0600), 0);
  const int reader = ::open(journal.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  start_daemon(config());
  ::unlink(journal.c_str());
  const char byte = '.';
  while (::write(reader, &byte, 1) > 0) {
  }
  begin();
  LineClient clerk(file("control.sock"));
  clerk.send(add_specimen());  // is told in the journal
  EXPECT_TRUE(clerk.next(20s));
  expect_readings_at_their_instants();
  ::close(reader);
}

}  // namespace
}  // namespace lcrig::e2e
