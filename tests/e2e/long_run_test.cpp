// SPDX-License-Identifier: Apache-2.0
// Long runs need no more resources than short ones: memory, descriptors and the write-ahead log
// stay flat, and planned actions happen on time. These are short forms. The full ones:
//   LCRIG_LONG_HOURS=72 LCRIG_SOAK_MINUTES=20 e2e_tests --gtest_filter='LongRun.*'
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/clock.hpp"
#include "tests/e2e/rig.hpp"
#include "tests/e2e/standstill.hpp"

namespace lcrig::e2e {
namespace {

double wanted(const char* variable, double otherwise) {
  const char* text = std::getenv(variable);
  if (text != nullptr) std::from_chars(text, text + std::strlen(text), otherwise);
  return otherwise;
}

// Levels of 30 readings in 10 s, as in the static experiment. A pass takes 20 s.
std::string protocol_of(double hours) {
  const int passes = std::max(2, static_cast<int>(hours * 3600 / 20));
  return R"({ "format": "load-protocol/1", "name": "long", "on_loss": "wait",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "bus" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05,
      "back_off_mm": 0.05, "timeout_s": 20 },
    { "id": "pass", "do": "repeat", "count": )" +
         std::to_string(passes) + R"(, "steps": [
      { "id": "load", "do": "ramp", "to": { "force_N": 0.5 }, "force_rate_N_s": 0.2,
        "timeout_s": 60 },
      { "id": "settle", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 1 },
      { "id": "level", "do": "measure", "count": 30, "within_s": 10 },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.1 }, "speed_mm_s": 0.1,
        "timeout_s": 60 },
      { "id": "rest", "do": "hold", "hold": "travel", "for_s": 5 } ] } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 1,
    "timeout_s": 20 } ] })";
}

struct Need {
  double memory_MB = 0, wal_MB = 0;
  int descriptors = 0;
};

// nullopt: the process has ended.
std::optional<Need> need_of(pid_t pid, const std::string& database) {
  const std::string proc = "/proc/" + std::to_string(pid);
  Need out;
  std::ifstream status(proc + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("RssAnon:")) out.memory_MB = std::stod(line.substr(8)) / 1024;
  }
  if (out.memory_MB == 0) return std::nullopt;
  std::error_code ec;
  for (auto it = std::filesystem::directory_iterator(proc + "/fd", ec);
       !ec && it != std::filesystem::directory_iterator(); it.increment(ec)) {
    ++out.descriptors;
  }
  const auto wal = std::filesystem::file_size(database + "-wal", ec);
  if (!ec) out.wal_MB = static_cast<double>(wal) / 1e6;
  return out;
}

Need most(const std::vector<Need>& needs, std::size_t from, std::size_t to) {
  Need out;
  for (std::size_t i = from; i < to; ++i) {
    out.memory_MB = std::max(out.memory_MB, needs[i].memory_MB);
    out.wal_MB = std::max(out.wal_MB, needs[i].wal_MB);
    out.descriptors = std::max(out.descriptors, needs[i].descriptors);
  }
  return out;
}

class LongRun : public Rig {
 protected:
  // The address sanitizer keeps freed memory, which would look like growth.
  LongRun() { ::setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 1); }

  // The first tenth is left out as the start.
  static void expect_flat(const std::vector<Need>& needs, int spare_descriptors) {
    ASSERT_GE(needs.size(), 10U) << "too short to be watched";
    const std::size_t n = needs.size();
    const Need early = most(needs, n / 10, n / 2), late = most(needs, n / 2, n);
    EXPECT_LE(late.memory_MB, early.memory_MB * 1.05 + 2);
    EXPECT_LE(late.descriptors, early.descriptors + spare_descriptors);
    EXPECT_LE(late.wal_MB, 16) << "checkpoints do not keep up";
    std::printf("%zu looks: memory %.1f then %.1f MB, descriptors %d then %d, WAL %.1f MB\n", n,
                early.memory_MB, late.memory_MB, early.descriptors, late.descriptors, late.wal_MB);
  }

  // The k-th reading of a level is due (k - 1)/3 s after the first one. `late_ns` is the deviation
  // from that.
  const std::string kLate =
      " FROM (SELECT level, asked_mono_ns, asked_mono_ns - first_ns - (reading_index - 1) *"
      " 10000000000 / 30 AS late_ns FROM (SELECT *, first_value(asked_mono_ns) OVER (PARTITION BY"
      " level ORDER BY reading_index) AS first_ns FROM lcr_reading WHERE run_id = 1 AND"
      " reading_index IS NOT NULL)) ";

  // Largest lateness of a reading in one half of the run, s.
  double lateness_s(bool second_half) const {
    const std::string half = "(SELECT max(level) / 2 FROM lcr_reading WHERE run_id = 1)";
    return number("SELECT max(abs(late_ns)) / 1e9" + kLate + "WHERE level " +
                  std::string(second_half ? "> " : "<= ") + half);
  }

  // Largest lateness, s, less the time for which the machine itself stood still from one second
  // before the reading was due until it was asked for.
  double own_lateness_s(const StandstillWatch& machine) const {
    std::istringstream rows(query("SELECT asked_mono_ns || ' ' || abs(late_ns)" + kLate));
    Duration worst{};
    for (std::int64_t asked = 0, late = 0; rows >> asked >> late;) {
      const MonoTime end{Duration(asked)};
      const Duration lateness(late);
      worst = std::max(worst, lateness - machine.within(end - lateness - 1s, end));
    }
    return to_seconds(worst);
  }
};

TEST_F(LongRun, DaysOfRigTimeNeedNoMoreThanTheirFirstHours) {
  const double hours = wanted("LCRIG_LONG_HOURS", 0.5);
  write("long.json", protocol_of(hours));
  const Child::Variables variables{{"HOME", file("home")}};
  Child child({LCRIG_BIN "/lcrig", "rehearse", file("long.json"), "--specimen", "paper-1",
               "--bench", file("bench.json"), "--db", file("lcrig.db"), "--json"},
              file("rehearse.log"), variables);
  std::vector<Need> needs;
  while (!readable(child.exit_fd(), 50ms)) {
    if (const auto need = need_of(child.pid(), file("lcrig.db"))) needs.push_back(*need);
  }
  ASSERT_EQ(child.wait(1s), 0) << child.log();
  expect_flat(needs, 0);
  const double rig_h =
      number("SELECT max(received_mono_ns) - min(received_mono_ns) FROM frame_sample") / 3.6e12;
  EXPECT_GT(rig_h, 0.9 * hours);
  const double early = lateness_s(false), late = lateness_s(true);
  EXPECT_LT(early, 0.001);
  EXPECT_LE(late, early + 1e-6) << "planned instants drift";
  std::printf("%.1f h of rig time; lateness of readings %.3g s, then %.3g s\n", rig_h, early, late);
}

TEST_F(LongRun, TheDaemonNeedsNoMoreWhileClientsComeAndGo) {
  const double minutes = wanted("LCRIG_SOAK_MINUTES", 0.25);
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  ASSERT_TRUE(start_run(client, protocol_of(minutes / 60 * 2 + 1)).contains("result"));
  const StandstillWatch machine;
  const RealClock clock;
  const MonoTime end = clock.now() + from_seconds(minutes * 60);
  std::vector<Need> needs;
  while (clock.now() < end) {
    Control visitor = control();
    visitor.call("watch");
    visitor.wait_for("status", [](const json& s) { return s.value("run", 0) == 1; });
    visitor.listen(500ms);
    const auto need = need_of(daemon.pid(), file("lcrig.db"));
    ASSERT_TRUE(need) << "the daemon has ended";
    needs.push_back(*need);
  }
  client.call("run.abort");
  client.call("watch");
  expect_flat(needs, 1);
  expect_losses_only_while_it_stood_still(machine);
  const double late_s = lateness_s(true), own_s = own_lateness_s(machine);
  const Duration stood_still = machine.within(end - from_seconds(minutes * 60), end);
  std::printf(
      "%.1f minutes; the machine stood still for %.1f s, at most %.3f s; %.0f losses;"
      " lateness of readings %.3g s, of it our own %.3g s\n",
      minutes, to_seconds(stood_still), to_seconds(machine.longest()),
      number("SELECT count(*) FROM event WHERE kind = 'loss'"), late_s, own_s);
  // Two simulators, a daemon, two clients and other programs share the processors.
  EXPECT_LT(own_s, 0.25);
}

}  // namespace
}  // namespace lcrig::e2e
