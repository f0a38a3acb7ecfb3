// SPDX-License-Identifier: Apache-2.0
// An overloaded computer, or one whose host takes its processors away, stands still for a while.
// Bytes that arrive meanwhile wait in the kernel, so this must not be taken for the silence of an
// instrument.
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

class Standstill : public Rig {
 protected:
  // Starts a run with `on_loss`: `wait`, and waits for the middle of its ramp.
  Child& ramp() {
    start_sim();
    Child& daemon = start_daemon(config());
    client_ = std::make_unique<Control>(control());
    client_->call("watch");
    std::string protocol = kSlowProtocol;
    protocol.insert(protocol.find("\"limits\""), "\"on_loss\": \"wait\", ");
    EXPECT_TRUE(start_run(*client_, protocol).contains("result"));
    client_->wait_for(
        "status", [this](const json& s) { return s.value("step", "") == "away" && is_moving(); });
    return daemon;
  }

  void expect_no_answer_for(Timeout time) const {
    EXPECT_EQ(LineClient(file("control.sock")).next(time), std::nullopt) << "it does not stand";
  }

  bool is_moving() { return sim("status").value("moving", false); }

  std::unique_ptr<Control> client_;
};

TEST_F(Standstill, OfTheDaemonIsNotTakenForSilenceOfTheInstruments) {
  // Longer than a frame may be silent (0.5 s), but shorter than the gateway's patience (1 s) less a
  // heartbeat (0.25 s).
  constexpr auto kStop = 560ms;
  Child& daemon = ramp();
  const StandstillWatch machine;
  const auto readings = [&] { return number("SELECT count(*) FROM lcr_reading"); };
  const double before = readings();
  for (int i = 0; i < 8; ++i) {
    daemon.signal(SIGSTOP);
    expect_no_answer_for(kStop);
    daemon.signal(SIGCONT);
    client_->listen(Timeout(350 + 37 * i));  // so that the stops come at different instants
  }
  EXPECT_GT(readings(), before + 8);
  expect_losses_only_while_it_stood_still(machine);
  EXPECT_THAT(query("SELECT detail FROM event WHERE kind = 'lag'"),
              testing::HasSubstr("the event loop was"));
}

// While the daemon stands still, only the gateway can stop the frame.
TEST_F(Standstill, OfMoreThanASecondStopsTheFrameAndTheRunGoesOnAfterIt) {
  Child& daemon = ramp();
  daemon.signal(SIGSTOP);
  expect_no_answer_for(1600ms);
  EXPECT_FALSE(is_moving());
  daemon.signal(SIGCONT);
  client_->wait_for(
      "status", [&](const json& s) { return s.value("state", "") == "running" && is_moving(); });
  EXPECT_THAT(query("SELECT detail FROM event WHERE kind = 'loss'"),
              testing::HasSubstr("host silent for 1 s"));
}

}  // namespace
}  // namespace lcrig::e2e
