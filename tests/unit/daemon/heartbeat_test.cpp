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

// A driver with a bug: it takes its own time to stop the frame.
class StuckFrame final : public LoadFrame {
 public:
  StuckFrame(LoadFrame& inner, Clock& clock, const bool& stuck)
      : inner_(inner), clock_(clock), stuck_(stuck) {}

  const FrameCapabilities& capabilities() const override { return inner_.capabilities(); }
  std::optional<std::string> origin() const override { return inner_.origin(); }
  Task<Result<Identity>> identify() override { return inner_.identify(); }
  Task<Result<Identity>> observe(double rate_Hz) override { return inner_.observe(rate_Hz); }
  Task<Result<>> arm(FrameLimits limits) override { return inner_.arm(limits); }
  Task<Result<>> set_sample_rate(double rate_Hz) override {
    return inner_.set_sample_rate(rate_Hz);
  }
  Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) override {
    return inner_.move_to(travel, speed);
  }
  Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed, Length guard) override {
    return inner_.move_until_force(force, speed, guard);
  }
  Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) override {
    return inner_.ramp_force(force, rate);
  }
  Task<Result<>> hold_travel() override { return inner_.hold_travel(); }
  Task<Result<>> hold_force(Force force) override { return inner_.hold_force(force); }
  Task<Result<>> zero(bool force, bool travel) override { return inner_.zero(force, travel); }
  Task<Result<MotionOutcome>> place_mass(Mass mass) override { return inner_.place_mass(mass); }
  Task<Result<>> stop() override {
    while (stuck_) co_await clock_.wait_for(10ms);
    co_return co_await inner_.stop();
  }
  Task<Result<>> resync() override { return inner_.resync(); }
  Task<Result<Identity>> reconnect() override { return inner_.reconnect(); }
  void close() override { inner_.close(); }
  void set_listener(Listener* listener) override { inner_.set_listener(listener); }

 private:
  LoadFrame& inner_;
  Clock& clock_;
  const bool& stuck_;
};

class StuckInstruments final : public Instruments {
 public:
  StuckInstruments(std::unique_ptr<Instruments> inner, Clock& clock, const bool& stuck)
      : inner_(std::move(inner)), frame_(inner_->frame(), clock, stuck) {
    info_ = inner_->info();
  }
  LcrMeter& meter() override { return inner_->meter(); }
  LoadFrame& frame() override { return frame_; }
  Operator& person() override { return inner_->person(); }
  Task<> close() override { return inner_->close(); }

 private:
  std::unique_ptr<Instruments> inner_;
  StuckFrame frame_;
};

TEST_F(Beat, SaysThatAPartIsStuckForAsLongAsItIs) {
  bool stuck = false;
  rig.wrap = [&](std::unique_ptr<Instruments> inner) {
    return std::make_unique<StuckInstruments>(std::move(inner), clock, stuck);
  };
  auto starter = make_starter();
  ASSERT_TRUE(run(use.claim(RigUse::State::starting)));
  ASSERT_TRUE(run(starter.start(prepare_run(one_level()))));
  begin(heartbeat_.run());
  pass(2s);
  stuck = true;
  use.live_run()->interrupt(InterruptRequest(Interrupt::abort, "by ada"));
  pass(25s);
  static_cast<void>(manager_.take());
  pass(10s);
  const auto told = manager_.take();
  EXPECT_THAT(told, testing::SizeIs(testing::Ge(9U)));
  EXPECT_THAT(told, testing::Each(testing::StartsWith("STATUS=stuck: the runner")))
      << "and the watchdog is not fed";
  stuck = false;
  clock.run(io, [this] { return use.is_idle(); });
  pass(2s);
  EXPECT_THAT(use.last_run()->reason, HasSubstr("the runner"));
  EXPECT_THAT(manager_.take(), testing::IsSupersetOf({std::string("WATCHDOG=1"),
                                                      std::string("STATUS=every part moves "
                                                                  "again")}));
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
