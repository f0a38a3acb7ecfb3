// SPDX-License-Identifier: Apache-2.0
// The promises of every LcrMeter, checked for every driver: on its simulator (over memory and
// through the kernel) and on a replayed wire log. A new driver adds one line to kCases.
// LCRIG_ACCEPT=1 records the wire logs anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "drivers/fd_transport.hpp"
#include "drivers/recording_transport.hpp"
#include "drivers/registry.hpp"
#include "tests/support/meter_bench.hpp"
#include "tests/support/replay_transport.hpp"

namespace lcrig {
namespace {

enum class Wire { memory, socketpair, replay };

struct Case {
  const char* driver;
  Wire wire;
  bool replay() const { return wire == Wire::replay; }
};

std::string log_path(const Case& c) {
  return std::string("tests/replay/") + c.driver + ".wire";
}

class Meter : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const auto* driver = std::ranges::find(kMeterDrivers, GetParam().driver, &MeterDriver::name);
    ASSERT_NE(driver, kMeterDrivers.end());
    std::unique_ptr<Transport> transport;
    if (GetParam().replay() && std::getenv("LCRIG_ACCEPT") == nullptr) {
      auto log = load_wire_log(log_path(GetParam()));
      ASSERT_TRUE(log) << log.error().what;
      transport = std::make_unique<ReplayTransport>(std::move(*log), clock, "replay");
    } else {
      transport = simulated();
    }
    meter = driver->make(std::move(transport), clock, "");
  }
  void TearDown() override {
    if (meter) meter->close();
    if (sim) sim->close();
    clock.run(io, [] { return false; });
  }
  std::unique_ptr<Transport> simulated() {
    const bool kernel = GetParam().wire == Wire::socketpair;
    auto pair = kernel ? make_socketpair(io.get_executor(), clock, "sim:lcr")
                       : make_memory_pipe(io.get_executor(), clock, "sim:lcr");
    sim.emplace(std::move(pair->far), clock, lcr6100::SimConfig(),
                lcr6100::Lcr6100Sim::Source(support::seven_picofarad));
    asio::co_spawn(io, sim->run(), asio::detached);
    if (!GetParam().replay()) return std::move(pair->near);
    WireLogHeader header;
    header.instrument = "LCR-6100 (simulated)";
    header.firmware = "REV E8.13";
    header.date = "2026-01-01";
    header.conditions = "7.2914 pF, D 0.004; conformance suite";
    auto log =
        std::make_shared<WireRecord>(logs.create(log_path(GetParam()), "lcr"), clock, header);
    return std::make_unique<RecordingTransport>(std::move(pair->near), std::move(log));
  }
  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  void expect_reading(LcrSettings settings) {
    const auto got = run(meter->configure(settings));
    ASSERT_TRUE(got) << got.error().what;
    EXPECT_EQ(*got, settings);
    for (int i = 0; i < 3; ++i) {
      const auto r = run(meter->measure());
      ASSERT_TRUE(r) << r.error().what;
      EXPECT_TRUE(r->fresh);
      EXPECT_EQ(r->function, settings.function);
      EXPECT_NEAR(r->primary.value_or(0), 7.2914e-12, 0.5e-12);
      EXPECT_LE(r->asked, r->first_byte);
      EXPECT_LE(r->first_byte, r->last_byte);
    }
  }

  static int create_anew(const std::string& path) {
    std::remove(path.c_str());
    return WireLogWriter::create_exclusively(path);
  }

  asio::io_context io;
  VirtualClock clock;
  WireLogWriter logs{WireLogWriter::Options{.create = create_anew}};
  std::optional<lcr6100::Lcr6100Sim> sim;
  std::unique_ptr<LcrMeter> meter;
};

// One session, in the order of the wire log.
TEST_P(Meter, KeepsItsPromises) {
  const auto& c = meter->capabilities();
  EXPECT_FALSE(c.functions.empty());
  EXPECT_LT(c.frequency_min, c.frequency_max);
  EXPECT_GT(c.conversion[2], c.conversion[0]);

  const auto id = run(meter->identify());
  ASSERT_TRUE(id) << id.error().what;
  EXPECT_FALSE(id->model.empty());
  EXPECT_FALSE(id->serial.empty());

  const auto early = run(meter->measure());
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, Errc::invalid_request);

  LcrSettings triggered;
  triggered.frequency = Frequency::from_si(10e3);
  expect_reading(triggered);
  LcrSettings polled = triggered;
  polled.trigger = LcrTrigger::internal;
  polled.aperture = Aperture::fast;
  expect_reading(polled);

  LcrSettings impossible = triggered;
  impossible.frequency = Frequency::from_si(1e9);
  EXPECT_EQ(run(meter->configure(impossible)).error().code, Errc::invalid_request);

  EXPECT_TRUE(run(meter->resync()));
  EXPECT_TRUE(run(meter->correct(CorrectionKind::open)));
  EXPECT_TRUE(run(meter->make_safe()));
  meter->close();
  const auto closed = run(meter->resync());
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().code, Errc::disconnected);
}

constexpr Case kCases[] = {
    {"lcr6100", Wire::memory}, {"lcr6100", Wire::socketpair}, {"lcr6100", Wire::replay}};
std::string case_name(const testing::TestParamInfo<Case>& each) {
  constexpr const char* kWires[] = {"_sim", "_sim_socketpair", "_replay"};
  return std::string(each.param.driver) + kWires[static_cast<std::size_t>(each.param.wire)];
}
INSTANTIATE_TEST_SUITE_P(Drivers, Meter, ::testing::ValuesIn(kCases), case_name);

}  // namespace
}  // namespace lcrig
