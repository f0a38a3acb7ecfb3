// SPDX-License-Identifier: Apache-2.0
// Exactly one part hangs. What the watchdog looks at reveals this, and reveals nothing otherwise.
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include "protocols/file/parse.hpp"
#include "protocols/run/run.hpp"
#include "tests/support/stub_rig.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr const char* kProtocol = R"({ "format": "load-protocol/1", "name": "t",
  "limits": { "force_N": [-1, 1], "travel_mm": [-1, 1] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" } },
  "steps": [ { "id": "r", "do": "record", "for_s": 3600 } ], "finally": [] })";

class Hang : public ::testing::Test {
 protected:
  Hang() {
    RunSetup setup(clock, meter, frame, sink, protocol);
    setup.limits = bind_limits(protocol, setup.environment, frame.capabilities()).value();
    run.emplace(io.get_executor(), std::move(setup));
    asio::co_spawn(io, frame.send_samples(), asio::detached);
    asio::co_spawn(io, run->execute(), [this](std::exception_ptr, RunResult) { ended = true; });
    clock.run_for(io, 30s);
  }

  VirtualClock clock;
  asio::io_context io;
  StubMeter meter{clock};
  StubFrame frame{clock};
  EventSink sink;
  Protocol protocol = parse_protocol(kProtocol, "t").value();
  std::optional<lcrig::Run> run;
  bool ended = false;
};

TEST_F(Hang, NothingHangsAndEverythingBeats) {
  for (int i = 0; i < 60; ++i) {
    const auto before = run->beats();
    clock.run_for(io, 1s);
    EXPECT_GT(run->beats(), before);
    EXPECT_FALSE(run->sampler().overdue(clock.now()));
  }
}

TEST_F(Hang, AMeterThatNeverReturnsIsOverdue) {
  meter.hangs = true;
  clock.run_for(io, 5s);
  EXPECT_FALSE(run->sampler().overdue(clock.now())) << "an honest time-out takes longer";
  // The runner itself ends the exchange with a silent meter. Otherwise the watchdog would notice.
  EXPECT_TRUE(run->sampler().overdue(clock.now() + 20s));
}

TEST_F(Hang, ARunnerThatWaitsForEverBeatsNoMore) {
  frame.hangs = true;
  run->interrupt(InterruptRequest(Interrupt::abort, "test"));
  clock.run_for(io, 1s);
  const auto before = run->beats();
  clock.run_for(io, 60s);
  EXPECT_EQ(run->beats(), before);
  EXPECT_FALSE(ended);
}

}  // namespace
}  // namespace lcrig
