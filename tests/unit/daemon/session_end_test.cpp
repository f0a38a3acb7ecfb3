// SPDX-License-Identifier: Apache-2.0
// Somebody locks or moves the database while a run is recorded into it, up to the end of the run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <set>

#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr const char* kShort = R"({ "format": "load-protocol/1", "name": "short",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "level", "do": "measure", "count": 20, "within_s": 8 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 2, "timeout_s": 60 } ] })";

// Another program takes the lock in the last step and holds it while the end of the run waits.
class LockedEnd : public SessionWorld {
 public:
  LockedEnd() : SessionWorld(kShort) {
    acts.push_back(
        {"level", 1s, [](SessionWorld& world) { static_cast<LockedEnd&>(world).take(); }});
  }
  bool beat() const { return beat_; }

 private:
  // The rows of the run wait in vain, which ends it. The rows of its end do not.
  void adjust(SimRequest& /*sim*/, Recorder::Options& recorder) override {
    recorder.lock_attempt = 20ms;
    recorder.lock_patience = 2s;
  }
  void take() {
    other_ = open_read_write(database()).value();
    ASSERT_TRUE(other_.execute("BEGIN IMMEDIATE"));
    watch();
  }
  // The run is over once its own time stands still while the daemon counts beats.
  void watch() {
    if (clock.now() != at_) {
      at_ = clock.now();
      seen_.clear();
    }
    seen_.insert(session->beats());
    beat_ = seen_.size() > 6;
    if (beat_) {
      ASSERT_TRUE(other_.execute("ROLLBACK"));
      return;
    }
    timer_.expires_after(5ms);
    timer_.async_wait([this](boost::system::error_code) { watch(); });
  }

  Database other_;
  asio::steady_timer timer_{io};
  MonoTime at_;
  std::set<std::optional<std::uint64_t>> seen_;
  bool beat_ = false;
};

TEST(SessionEnd, BeatsWhileItWaitsForALockAndLosesNoRow) {
  LockedEnd world;
  const auto ended = world.run();
  ASSERT_TRUE(ended) << ended.error().what;
  EXPECT_TRUE(world.beat());
  EXPECT_THAT(ended->reason, HasSubstr("another program holds it"));
  EXPECT_EQ(world.count("SELECT count(*) FROM run_end"), 1);
  EXPECT_TRUE(verify_chain(world.open(), 1).value().intact);
}

TEST(SessionEnd, SaysThatTheDatabaseWasMovedInTheRun) {
  SessionWorld world(kShort);
  world.judges_again = false;  // the file is elsewhere afterwards
  const std::string moved = world.database() + ".moved";
  world.acts.push_back(
      {"level", 1s, [&moved](SessionWorld& w) { std::filesystem::rename(w.database(), moved); }});
  const auto ended = world.run();
  ASSERT_TRUE(ended) << ended.error().what;
  EXPECT_EQ(ended->exit_status, ExitStatus::success);
  EXPECT_THAT(ended->reason, HasSubstr("move it back beside its log"));
  std::filesystem::rename(moved, world.database());
  EXPECT_EQ(world.count("SELECT count(*) FROM event WHERE kind = 'database_moved'"), 1);
  EXPECT_EQ(world.count("SELECT count(*) FROM lcr_reading WHERE reading_index > 0"), 20);
}

}  // namespace
}  // namespace lcrig
