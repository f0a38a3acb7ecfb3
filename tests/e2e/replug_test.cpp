// SPDX-License-Identifier: Apache-2.0
// A cable that is pulled and plugged in again, after which the port is another device node.
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

std::string patient_protocol() {
  std::string text = kSlowProtocol;
  return text.insert(text.find("\"limits\""), "\"on_loss\": \"wait\", ");
}

// Keeps the name `node` from being given to a new pty. The kernel gives out the lowest free number,
// and other tests open and close ptys at the same time.
class Occupied {
 public:
  explicit Occupied(const std::string& node) {
    for (std::string name; name != node && fds_.size() < 64;) {
      const int fd = ::posix_openpt(O_RDWR | O_NOCTTY);
      if (fd < 0) break;
      fds_.push_back(fd);
      name = ::ptsname(fd);
    }
  }
  ~Occupied() {
    for (const int fd : fds_) ::close(fd);
  }
  Occupied(const Occupied&) = delete;
  Occupied& operator=(const Occupied&) = delete;

 private:
  std::vector<int> fds_;
};

class Replug : public Rig {
 protected:
  std::unique_ptr<Control> ramp() {
    start_sim();
    start_daemon(config());
    auto client = std::make_unique<Control>(control());
    client->call("watch");
    const json started = start_run(*client, patient_protocol());
    EXPECT_TRUE(started.contains("result")) << started;
    client->wait_for("status", [](const json& s) {
      return s.value("step", "") == "away" && s.value("lcr_readings", 0) > 5;
    });
    return client;
  }
  static json wait_state(Control& client, const char* state) {
    return client.wait_for("status", [=](const json& s) { return s.value("state", "") == state; });
  }
};

TEST_F(Replug, MeterComesBackAsAnotherDeviceAndTheRunGoesOn) {
  auto client = ramp();
  const auto node = std::filesystem::read_symlink(file("lcr"));
  sim("unplug lcr");
  wait_state(*client, "waiting_for_instrument");
  EXPECT_FALSE(sim("settle").value("moving", true)) << "the ramp goes on without a meter";
  const Occupied occupied(node.string());  // the next pty gets another number
  sim("plug lcr");
  const RealClock clock;
  const MonoTime plugged = clock.now();
  const json running = wait_state(*client, "running");
  const auto before = running.value("lcr_readings", 0);
  client->wait_for("status", [=](const json& s) { return s.value("lcr_readings", 0) > before; });
  const double back_s = to_seconds(clock.now() - plugged);
  std::printf("meter: a stored reading %.3f s after the replug\n", back_s);
  EXPECT_LT(back_s, 3) << "a loaded machine; the promise is measured in virtual time";
  EXPECT_NE(std::filesystem::read_symlink(file("lcr")), node);
  EXPECT_TRUE(sim("status").value("moving", false)) << "the ramp goes on";
  client->call("run.abort");
  EXPECT_EQ(client->run_ended().value("exit_status", ""), "abort");
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind = 'reconnected'"), 1);
  EXPECT_EQ(number("SELECT count(*) FROM lcr_reading WHERE flags & 16"), 1);
}

TEST_F(Replug, FrameLinkComesBackAndTheStepIsFinished) {
  auto client = ramp();
  sim("unplug frame");
  EXPECT_EQ(wait_state(*client, "stopping").value("standstill", ""), "unknown");
  sim("plug frame");
  wait_state(*client, "running");
  client->wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
  EXPECT_TRUE(sim("status").value("moving", false)) << "the ramp goes on";
  client->call("run.abort");
  EXPECT_EQ(client->run_ended().value("exit_status", ""), "abort");
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind = 'reconnected'"), 1);
  EXPECT_EQ(query("SELECT detail FROM event WHERE kind = 'step_end' AND step_id = 'clear'"),
            "done\n");
}

}  // namespace
}  // namespace lcrig::e2e
