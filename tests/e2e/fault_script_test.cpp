// SPDX-License-Identifier: Apache-2.0
// lcrig-sim --faults plays the scripts of a rehearsal, in real time on real ports.
#include <filesystem>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

class FaultScripts : public Rig {
 protected:
  std::string script(const std::string& faults) const {
    write("faults.json", R"({ "format": "faults/1", "faults": [)" + faults + "] }");
    return file("faults.json");
  }
  // Waits until the meter has another port than `port`, and returns it. "" means that it has none.
  std::string port_other_than(const std::string& port) {
    const auto limit = std::chrono::steady_clock::now() + 15s;
    std::string now = port;
    while (now == port && std::chrono::steady_clock::now() < limit) {
      const json url = sim("status").at("lcr");
      now = url.is_string() ? url.get<std::string>() : "";
    }
    return now;
  }
};

TEST_F(FaultScripts, AMeterThatIsUnpluggedComesBackAsAnotherDevice) {
  start_sim({"--faults", script(R"({ "fault": "unplug", "on": "meter", "at_s": 0.3, "for_s": 0.3,
                         "other_port": true })")});
  const std::string first = ports_.value("lcr", "?");
  EXPECT_EQ(port_other_than(first), "") << "unplugged";
  const std::string second = port_other_than("");
  EXPECT_NE(second, first);
  EXPECT_EQ("pty:" + std::filesystem::read_symlink(file("lcr")).string(), second);
  EXPECT_THAT(sim_->log(), HasSubstr("fault injected: meter unplug, other_port"));
}

TEST_F(FaultScripts, ARunUnderACountedFaultIsPairedRightAndSucceeds) {
  start_sim({"--faults", script(R"({ "fault": "reply_doubled", "on": "meter", "every": 7 },
                                   { "fault": "line_doubled", "on": "frame", "every": 5 })")});
  start_daemon(config());
  write("quick.json", kQuickProtocol);
  const Ended run = lcrig({"run", file("quick.json"), "--specimen", "paper-1", "--json", "--socket",
                           file("control.sock")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(sim_->log(), HasSubstr("fault injected: meter reply_doubled"));
  EXPECT_THAT(sim_->log(), HasSubstr("fault injected: frame line_doubled"));
  EXPECT_GE(number("SELECT count(*) FROM event WHERE kind = 'repeated_samples'"), 1);
}

TEST_F(FaultScripts, WhatTheSimulatorCannotPlayIsRefusedAtTheStart) {
  for (const char* fault : {R"({ "fault": "stall", "on": "frame", "in_step": "load" })",
                            R"({ "fault": "disk_full", "on": "bench", "at_s": 1 })",
                            R"({ "fault": "stal", "on": "frame", "at_s": 1 })"}) {
    Child child({LCRIG_BIN "/lcrig-sim", "--faults", script(fault)}, file("refused.log"));
    EXPECT_EQ(child.wait(20s), 2) << fault;
    EXPECT_THAT(child.log(), HasSubstr("/faults/0"));
    EXPECT_EQ(child.out().rest(1s), "") << "it offered ports";
  }
}

}  // namespace
}  // namespace lcrig::e2e
