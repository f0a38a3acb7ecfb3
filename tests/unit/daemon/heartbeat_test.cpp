// SPDX-License-Identifier: Apache-2.0
// The watchdog, the daemon's health, and its config file while it runs.
#include "daemon/app/heartbeat.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "daemon/app/config_taker.hpp"
#include "daemon/app/metrics_keeper.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// A service manager with a watchdog of two seconds.
class Manager {
 public:
  explicit Manager(const std::string& path) {
    fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "2000000", 1);
  }
  ~Manager() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(fd_);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  std::vector<std::string> take() const {
    std::vector<std::string> out;
    char buffer[4096];
    for (;;) {
      const auto n = ::recv(fd_, buffer, sizeof buffer, 0);
      if (n <= 0) return out;
      out.emplace_back(buffer, static_cast<std::size_t>(n));
    }
  }

 private:
  int fd_ = -1;
};

class Beat : public AppPartsTest {
 protected:
  Manager manager_{dir.file("notify")};
  ServiceNotifier watched_ = ServiceNotifier::from_environment();
  News told_{server, watched_, use};
  Heartbeat heartbeat_{clock, {recorder, rig, use, watched_, told_}};
};

TEST_F(Beat, FeedsTheWatchdogAndEndsWithTheDaemon) {
  begin(heartbeat_.run());
  pass(10s);
  EXPECT_GE(std::ranges::count(manager_.take(), "WATCHDOG=1"), 9);
  use.end();
  pass(1s);
  EXPECT_EQ(clock.pending(), 0U);
}

TEST_F(Beat, TellsTheManagerWhatTheRunDoes) {
  auto starter = make_starter();
  auto request = one_level();
  ASSERT_TRUE(run(use.claim(RigUse::State::starting)));
  ASSERT_TRUE(run(starter.start(prepare_run(std::move(request)))));
  begin(heartbeat_.run());
  pass(2s);
  EXPECT_THAT(manager_.take(), testing::Contains(HasSubstr("STATUS=")));
  clock.run(io, [this] { return use.is_idle(); });
}

class Figures : public Beat {
 protected:
  Config config_;
  MetricsKeeper metrics_{io.get_executor(), clock, {config_, recorder, heartbeat_, use, [] {
                                                      return DaemonStatus();
                                                    }}};
};

TEST_F(Figures, CountEventsByKind) {
  metrics_.count(RunEvent(clock.now(), EventKind::retry, "", ""));
  metrics_.count(RunEvent(clock.now(), EventKind::retry, "", ""));
  metrics_.count(RunEvent(clock.now(), EventKind::limit, "", ""));
  const auto page = run(metrics_.text()).value();
  EXPECT_THAT(page, HasSubstr("lcrig_events_total{kind=\"retry\"} 2\n"));
  EXPECT_THAT(page, HasSubstr("lcrig_events_total{kind=\"limit\"} 1\n"));
}

TEST_F(Figures, AreWrittenUntilTheConfigNamesNoFile) {
  begin(metrics_.write());
  pass(20s);
  const std::string file = dir.file("lcrig.prom");
  config_.metrics_file = file;
  use.tell();
  pass(1s);
  EXPECT_TRUE(std::filesystem::exists(file));
  config_.metrics_file.clear();
  use.tell();
  pass(1s);
  EXPECT_FALSE(std::filesystem::exists(file));
}

class Taker : public AppPartsTest {
 protected:
  Task<bool> read_again() {
    co_await taker_.reload();
    co_return true;
  }
  Config config_;
  Result<Config> file_ = Config();
  ConfigTaker taker_{
      io.get_executor(), clock, {config_, [this] { return file_; }, notifier, use, rig, plans}};
};

TEST_F(Taker, KeepsWhatItHasWhenTheFileIsBad) {
  config_.metrics_file = "/var/a.prom";
  file_ = fail(Errc::invalid_request, "rig.json:1:1: no JSON");
  run(read_again());
  EXPECT_EQ(config_.metrics_file, "/var/a.prom");
  EXPECT_THAT(taker_.view().refused, HasSubstr("no JSON"));
  EXPECT_EQ(rig.configs, 0);
}

TEST_F(Taker, TakesTheFixtureOnceTheRigIsIdle) {
  Config wanted = config_;
  wanted.fixture.probe_diameter_m = 5e-3;
  wanted.metrics_file = "/var/b.prom";
  file_ = wanted;
  ASSERT_TRUE(run(use.claim(RigUse::State::starting)));
  run(read_again());
  EXPECT_EQ(config_.metrics_file, "/var/b.prom") << "concerns no run";
  EXPECT_NE(config_.fixture.probe_diameter_m, 5e-3);
  EXPECT_EQ(rig.configs, 0);
  plans.see(Rig(), false);
  use.give_back();
  taker_.take_when_idle();
  EXPECT_EQ(config_.fixture.probe_diameter_m, 5e-3);
  EXPECT_EQ(rig.configs, 1);
  EXPECT_FALSE(plans.last_rig(false)) << "the rig may be another one";
}

TEST_F(Taker, OfADaemonThatEndsReadsNothing) {
  use.end();
  Config wanted = config_;
  wanted.metrics_file = "/var/b.prom";
  file_ = wanted;
  run(read_again());
  EXPECT_EQ(config_.metrics_file, "");
}

}  // namespace
}  // namespace lcrig::support
