// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/sim.hpp"

#include <gtest/gtest.h>

#include "drivers/lcr6100/sim_values.hpp"
#include "drivers/scpi.hpp"
#include "tests/support/meter_bench.hpp"

namespace lcrig::lcr6100 {
namespace {

using namespace std::chrono_literals;

// The bare dialect, without the driver.
class Dialect : public ::testing::Test {
 protected:
  Dialect() {
    auto pair = make_memory_pipe(io.get_executor(), clock, "sim:lcr");
    sim.emplace(std::move(pair.far), clock, SimConfig(),
                Lcr6100Sim::Source(support::seven_picofarad));
    link.emplace(std::move(pair.near), clock);
    asio::co_spawn(io, sim->run(), asio::detached);
  }
  ~Dialect() override {
    sim->close();
    clock.run(io, [] { return false; });
  }
  std::string ask(std::string_view command) {
    const auto r = run_task(io, clock, link->query(command, 5s));
    return r ? r->text : std::string(to_string(r.error().code));
  }
  void send(std::string_view command) {
    ASSERT_TRUE(run_task(io, clock, link->send(command)));
    clock.run_for(io, 1ms);
  }

  asio::io_context io;
  VirtualClock clock;
  std::optional<Lcr6100Sim> sim;
  std::optional<ScpiLink> link;
};

TEST_F(Dialect, ReadBacksLookLikeTheMeters) {
  EXPECT_EQ(ask("*IDN?"), "LCR-6100,REV E8.13,SIM000001,Good Will Instrument Co., Ltd.");
  send("FREQ 1000");
  EXPECT_EQ(ask("FREQ?"), "1.000000e+03");
  send("LEV:VOLT 0.1");
  EXPECT_EQ(ask("LEV:VOLT?"), "1.000e-01V");
  send("BIAS 2.5");
  EXPECT_EQ(ask("BIAS?"), "+2.50V");
  send("BIAS OFF");
  EXPECT_EQ(ask("BIAS?"), "OFF");
  send("APER FAST");
  EXPECT_EQ(ask("APER?"), "FAST,1");
  EXPECT_EQ(ask("DISP:PAGE?"), "syst");
  EXPECT_EQ(ask("FUNC:MON1?"), "z");
}

TEST_F(Dialect, CaseLongFormsAndJoinedCommandsAreUnderstood) {
  send(":func cp-d");
  EXPECT_EQ(ask("FUNCtion?"), "Cp-D");
  send("function:impedance:auto off");
  EXPECT_EQ(ask("FUNC:IMP:AUTO?"), "OFF");
  send("LEV:VOLT 2;ALC OFF\r");
  EXPECT_EQ(ask("LEVel:VOLTage?"), "2.000e+00V");
  EXPECT_EQ(ask("LEV:ALC?"), "OFF");
  send("FREQ 20K");
  EXPECT_EQ(ask("FREQ?"), "2.000000e+04");
  send("LEV:VOLT 100m");
  EXPECT_EQ(ask("LEV:VOLT?"), "1.000e-01V");
  send("FREQ MAX");
  EXPECT_EQ(ask("FREQ?"), "1.000000e+05");
}

// ../shared/reference/lcr-6100.md, 4.3, calculated from the tables by hand: at 1 V, without Kf.
TEST(SimulatedMeter, ErrsByNoMoreThanItsManualAllows) {
  struct Row {
    double pF, frequency_Hz, fast_pF, medium_pF;
  };
  for (const Row& row :
       {Row{3.65, 1e3, 0.354, 0.172}, Row{7.29, 1e3, 0.357, 0.174}, Row{10.9, 10e3, 0.046, 0.023},
        Row{3.65, 100e3, 0.0072, 0.0035}, Row{10.9, 100e3, 0.0144, 0.0072}}) {
    for (const bool fast : {true, false}) {
      const BasicAccuracy allowed = basic_accuracy(fast, row.frequency_Hz, 1);
      const double total_pF = allowed.gain * row.pF + allowed.offset_F * 1e12;
      const double expected_pF = fast ? row.fast_pF : row.medium_pF;
      EXPECT_NEAR(total_pF, expected_pF, 0.03 * expected_pF) << row.pF << row.frequency_Hz << fast;
    }
  }
  EXPECT_DOUBLE_EQ(basic_accuracy(false, 1e5, 0.1).gain, 2.5 * basic_accuracy(false, 1e5, 1).gain);
}

TEST(SimulatedMeter, AnswersWithItsErrors) {
  SimConfig config;
  config.capacitance_noise_F = {};
  support::MeterBench exact("", config);
  config.gain_error = 1;
  config.offset_error = -1;
  support::MeterBench off("", config);
  LcrSettings settings;
  settings.frequency = Frequency::from_si(1e5);
  const auto read_pF = [&settings](support::MeterBench& bench) {
    EXPECT_TRUE(bench.run(bench.meter->identify()));
    EXPECT_TRUE(bench.run(bench.meter->configure(settings)));
    const auto reading = bench.run(bench.meter->measure());
    return reading ? reading->primary.value_or(0) * 1e12 : 0;
  };
  // Expected at 7.2914 pF, 100 kHz and MEDIUM: 0.05 % more, and 1.7 fF less.
  EXPECT_NEAR(read_pF(off) - read_pF(exact), 0.003646 - 0.001703, 2e-5);
}

TEST_F(Dialect, ErrorsAreKeptForTheAsking) {
  for (const auto& [command, code] :
       {std::pair("SPEED FAST", "*E01"), std::pair("FREQ 1e9", "*E02"),
        std::pair("FUNC CPRP", "*E02"), std::pair("FREQ", "*E03"), std::pair("FREQ 100", "*E00")}) {
    send(command);
    EXPECT_EQ(ask("ERR?"), code) << command;
  }
  EXPECT_EQ(ask("SPEED?"), "no_reply");
  link->set_identity(SimConfig().identity);
  EXPECT_EQ(ask("FREQ?"), "1.000000e+02");
}

TEST_F(Dialect, TheCurrentIsNotAnsweredInVoltageMode) {
  EXPECT_EQ(ask("LEV:CURR?"), "no_reply");
}

TEST_F(Dialect, ReadingLinesHaveTheMetersForm) {
  send("FUNC Cp-D");
  send("TRIG:SOUR BUS");
  const std::string line = ask("*TRG");
  EXPECT_EQ(line.size(), std::string("+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG").size());
  EXPECT_TRUE(line.ends_with(",OUT ,AUX-NG,NG")) << line;
  EXPECT_EQ(ask("FETC:MAIN?"), line.substr(0, 25));
  EXPECT_EQ(ask("FETC?"), line);
  EXPECT_EQ(ask("FETC:IMP?").size(), line.size() + 26);
  send("FUNC DCR");
  EXPECT_EQ(ask("*TRG"), "+1.00000e+20,OUT ,OK");
}

TEST_F(Dialect, TriggeringNeedsTheBus) {
  send("FUNC Cp-D");
  EXPECT_EQ(ask("*TRG"), "no_reply");
}

}  // namespace
}  // namespace lcrig::lcr6100
