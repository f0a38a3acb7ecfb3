// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/driver.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "tests/support/meter_bench.hpp"

namespace lcrig::lcr6100 {
namespace {

using namespace std::chrono_literals;
using support::MeterBench;
using Fault = SimFaults::Reply;
using Kind = SimFaults::Kind;

LcrSettings fast_polling() {
  LcrSettings s;
  s.aperture = Aperture::fast;
  s.trigger = LcrTrigger::internal;
  return s;
}

TEST(Lcr6100, IdentifiesAndConfigures) {
  MeterBench bench;
  const auto id = bench.run(bench.meter->identify());
  ASSERT_TRUE(id) << id.error().what;
  EXPECT_EQ(id->model, "LCR-6100");
  EXPECT_EQ(id->serial, "SIM000001");
  EXPECT_TRUE(id->simulated);
  LcrSettings wanted;
  wanted.frequency = Frequency::from_si(20e3);
  wanted.bias = Voltage::from_si(-1.25);
  wanted.average = 4;
  const auto got = bench.run(bench.meter->configure(wanted));
  ASSERT_TRUE(got) << got.error().what;
  EXPECT_EQ(*got, wanted);
}

TEST(Lcr6100, GarbageAfterOpeningIsSurvived) {
  MeterBench bench;
  bench.sim->faults().first_line = std::string("\x00\xff#NG\r\n", 7);
  const auto id = bench.run(bench.meter->identify());
  ASSERT_TRUE(id) << id.error().what;
  EXPECT_EQ(id->model, "LCR-6100");
}

TEST(Lcr6100, ASilentMeterNamesTheFrontPanelChoice) {
  MeterBench bench;
  bench.sim->faults().silent = true;
  const auto id = bench.run(bench.meter->identify());
  ASSERT_FALSE(id);
  EXPECT_EQ(id.error().code, Errc::no_reply);
  EXPECT_NE(id.error().what.find("RS-232 or USB"), std::string::npos) << id.error().what;
  EXPECT_LT(bench.seconds(), 10);
}

TEST(Lcr6100, BytesThatAreNoAnswerAreNotCalledSilence) {
  MeterBench bench;
  bench.sim->faults().byte_noise = 1;
  const auto id = bench.run(bench.meter->identify());
  ASSERT_FALSE(id);
  EXPECT_EQ(id.error().code, Errc::garbled);
  EXPECT_NE(id.error().what.find("baud rate and parity"), std::string::npos) << id.error().what;
}

TEST(Lcr6100, AnotherInstrumentIsRefusedByName) {
  SimConfig config;
  config.identity = "Keysight Technologies,E4980A,MY46,A.06";
  MeterBench bench("", config);
  const auto id = bench.run(bench.meter->identify());
  ASSERT_FALSE(id);
  EXPECT_EQ(id.error().code, Errc::refused);
  EXPECT_NE(id.error().what.find("E4980A"), std::string::npos) << id.error().what;
}

TEST(Lcr6100, AnotherSerialNumberIsRefused) {
  MeterBench bench("GEZ883880");
  const auto id = bench.run(bench.meter->identify());
  ASSERT_FALSE(id);
  EXPECT_EQ(id.error().code, Errc::refused);
  EXPECT_NE(id.error().what.find("SIM000001"), std::string::npos);
}

TEST(Lcr6100, ALostSettingIsSentAgain) {
  for (int lost = 1; lost <= 2; ++lost) {
    MeterBench bench;
    ASSERT_TRUE(bench.run(bench.meter->identify()));
    bench.sim->faults().lose_sets = lost;
    const auto got = bench.run(bench.meter->configure(LcrSettings()));
    ASSERT_TRUE(got) << got.error().what;
  }
}

TEST(Lcr6100, ASettingThatIsNeverTakenIsRefusedWithTheDifference) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  bench.sim->faults().lose_sets = 3;
  const auto got = bench.run(bench.meter->configure(LcrSettings()));
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::refused);
  EXPECT_EQ(got.error().what,
            "sim:lcr: the meter does not take the display page: wanted MEAS, got syst");
  const auto reading = bench.run(bench.meter->measure());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().code, Errc::invalid_request);
}

TEST(Lcr6100, RestoringAsksForEverythingAndSendsWhatDiffers) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  double begin = bench.seconds();
  const auto same = bench.run(bench.meter->restore(fast_polling()));
  ASSERT_TRUE(same) << same.error().what;
  EXPECT_EQ(*same, fast_polling());
  EXPECT_LT(bench.seconds() - begin, 0.05) << "nothing had to be sent";
  bench.sim->power_on();
  begin = bench.seconds();
  const auto again = bench.run(bench.meter->restore(fast_polling()));
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(*again, fast_polling());
  EXPECT_GT(bench.seconds() - begin, 0.3) << "a meter with factory settings was taken as it is";
  bench.sim->power_on();
  bench.sim->faults().lose_sets = 100;
  EXPECT_EQ(bench.run(bench.meter->restore(fast_polling())).error().code, Errc::refused);
}

TEST(Lcr6100, SettingsOutOfRangeAreRefusedBeforeAnythingIsSent) {
  MeterBench bench;
  LcrSettings s;
  s.frequency = Frequency::from_si(200e3);
  const auto got = bench.run(bench.meter->configure(s));
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::invalid_request);
  EXPECT_EQ(bench.seconds(), 0);
}

TEST(Lcr6100, ATriggeredReadingIsNewerThanItsRequest) {
  MeterBench bench;
  LcrSettings s;
  s.aperture = Aperture::slow;
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  std::set<double> values;
  for (int i = 0; i < 20; ++i) {
    const auto r = bench.run(bench.meter->measure());
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->last_byte - r->asked, 380ms);
    EXPECT_TRUE(r->fresh);
    EXPECT_EQ(r->flags, 0U);
    EXPECT_EQ(r->status, "OUT ,AUX-NG,NG");
    ASSERT_TRUE(r->primary && r->secondary);
    EXPECT_NEAR(*r->primary, 7.2914e-12, 6 * 25e-15);
    EXPECT_NEAR(*r->secondary, 0.004, 6 * 25e-15 / 7.2914e-12);
    values.insert(*r->primary);
  }
  EXPECT_GT(values.size(), 15U);
}

TEST(Lcr6100, OverloadBecomesNullAndFlag) {
  MeterBench bench;
  LcrSettings s;
  s.function = LcrFunction::CpRp;  // 22 Mohm reactance, D 0.004: Rp is beyond 99.9999 Mohm
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  auto r = bench.run(bench.meter->measure());
  ASSERT_TRUE(r);
  EXPECT_TRUE(r->primary);
  EXPECT_EQ(r->secondary, std::nullopt);
  EXPECT_EQ(r->flags, lcr_flag::kSecondaryOverload);
  bench.sim->faults().overload = true;
  r = bench.run(bench.meter->measure());
  ASSERT_TRUE(r);
  EXPECT_EQ(r->primary, std::nullopt);
  EXPECT_TRUE(r->flags & lcr_flag::kPrimaryOverload);
}

TEST(Lcr6100, PollingFindsEveryConversionOnceAndQuickly) {
  for (const Aperture aperture : {Aperture::fast, Aperture::medium, Aperture::slow}) {
    MeterBench bench;
    LcrSettings s = fast_polling();
    s.aperture = aperture;
    ASSERT_TRUE(bench.run(bench.meter->configure(s)));
    const auto first = bench.run(bench.meter->measure());
    ASSERT_TRUE(first) << first.error().what;
    const auto polls = bench.sim->fetches();
    MonoTime last = first->asked;
    constexpr int kReadings = 1000;
    for (int i = 0; i < kReadings; ++i) {
      const auto r = bench.run(bench.meter->measure());
      ASSERT_TRUE(r) << r.error().what;
      ASSERT_TRUE(r->fresh);
      last = r->asked;
    }
    const double period = SimConfig().conversion_s[static_cast<std::size_t>(aperture)];
    EXPECT_NEAR(to_seconds(last - first->asked) / period, kReadings, 1.0);
    EXPECT_LE(static_cast<double>(bench.sim->fetches() - polls), 1.5 * kReadings);
  }
}

TEST(Lcr6100, PollingFollowsAMeterThatIsSlowerOrFasterThanItsDataSheet) {
  for (const double period : {0.055, 0.0623, 0.0671, 0.080}) {
    SimConfig config;
    config.conversion_s[0] = period;
    MeterBench bench("", config);
    ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
    const auto first = bench.run(bench.meter->measure());
    ASSERT_TRUE(first);
    const auto polls = bench.sim->fetches();
    MonoTime last;
    for (int i = 0; i < 1000; ++i) last = bench.run(bench.meter->measure())->asked;
    EXPECT_NEAR(to_seconds(last - first->asked) / period, 1000, 2) << period;
    EXPECT_LE(static_cast<double>(bench.sim->fetches() - polls), 1600) << period;
  }
}

TEST(Lcr6100, AStuckMeterIsReportedAsNotFresh) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  ASSERT_TRUE(bench.run(bench.meter->measure())->fresh);
  bench.sim->faults().stuck = true;
  const double begin = bench.seconds();
  const auto polls = bench.sim->fetches();
  const auto r = bench.run(bench.meter->measure());
  ASSERT_TRUE(r);
  EXPECT_FALSE(r->fresh);
  EXPECT_GE(bench.seconds() - begin, 3 * 0.065);
  EXPECT_LE(bench.seconds() - begin, 4 * 0.065);
  EXPECT_LE(bench.sim->fetches() - polls, 60);
}

TEST(Lcr6100, ALateAnswerNeverBecomesAReading) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  ASSERT_TRUE(bench.run(bench.meter->measure()));
  bench.sim->faults().replies = {Fault(Kind::delay, 1500ms)};
  const auto late = bench.run(bench.meter->measure());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Errc::no_reply);
  const auto next = bench.run(bench.meter->measure());
  ASSERT_TRUE(next) << next.error().what;
  EXPECT_TRUE(next->flags & lcr_flag::kAfterResync);
  EXPECT_LE(next->last_byte - next->asked, 1ms);
}

TEST(Lcr6100, EveryDamagedAnswerIsAnErrorThenTheMeterIsInStepAgain) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->configure(LcrSettings())));
  const std::vector<std::pair<Kind, Errc>> cases{{Kind::drop, Errc::no_reply},
                                                 {Kind::cut, Errc::reply_cut_off},
                                                 {Kind::garble, Errc::garbled}};
  for (const auto& [kind, code] : cases) {
    bench.sim->faults().replies = {Fault(kind)};
    const auto bad = bench.run(bench.meter->measure());
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, code) << bad.error().what;
    const auto good = bench.run(bench.meter->measure());
    ASSERT_TRUE(good) << good.error().what;
    EXPECT_EQ(good->last_byte - good->asked, 120ms);
  }
}

TEST(Lcr6100, AStreamingMeterIsSilenced) {
  MeterBench bench;
  bench.sim->faults().streaming = true;
  bench.clock.run_for(bench.io, 1s);
  const auto id = bench.run(bench.meter->identify());
  ASSERT_TRUE(id) << id.error().what;
  ASSERT_TRUE(bench.run(bench.meter->configure(LcrSettings())));
  EXPECT_TRUE(bench.run(bench.meter->measure()));
}

TEST(Lcr6100, AMeterThatBecameSlowSaysSoUntilItIsSetUpAgain) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(bench.run(bench.meter->measure()));
  bench.sim->faults().slow_factor = 5;
  std::vector<bool> slow;
  for (int i = 0; i < 30; ++i) slow.push_back(bench.run(bench.meter->measure())->slow);
  EXPECT_FALSE(slow.front());
  EXPECT_TRUE(slow.back());
  EXPECT_EQ(bench.sim->faults().slow_factor, 5) << "what its settings are is not known";
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  EXPECT_EQ(bench.sim->faults().slow_factor, 1);
  for (int i = 0; i < 8; ++i) EXPECT_FALSE(bench.run(bench.meter->measure())->slow);
}

// The truth of each case is what the simulator was set to, by its back door.
TEST(Lcr6100, AReadBackNamesEverySettingThatAHandAtThePanelChanged) {
  const std::vector<std::tuple<PanelKey, std::string, std::string>> cases{
      {PanelKey::function, "R-X", "function"}, {PanelKey::frequency, "100", "frequency_Hz"},
      {PanelKey::level, "0.1", "level_V"},     {PanelKey::aperture, "SLOW", "aperture"},
      {PanelKey::average, "8", "average"},     {PanelKey::range, "HOLD", "range"},
      {PanelKey::bias, "1.5", "bias_V"},       {PanelKey::correction, "ON", "open_correction"}};
  for (const auto& [key, to, differs] : cases) {
    SCOPED_TRACE(differs);
    MeterBench bench;
    const LcrSettings settings = fast_polling();
    ASSERT_TRUE(bench.run(bench.meter->configure(settings)));
    auto on = bench.run(bench.meter->corrections());
    ASSERT_TRUE(on);
    const MeterState wanted(settings, *on);
    EXPECT_TRUE(bench.run(bench.meter->read_back(wanted))->equal());
    ASSERT_TRUE(bench.sim->turn(key, to));
    const auto found = bench.run(bench.meter->read_back(wanted));
    ASSERT_TRUE(found) << found.error().what;
    EXPECT_EQ(found->differs, std::vector<std::string>{differs});
    ASSERT_TRUE(bench.run(bench.meter->restore(wanted)));
    EXPECT_TRUE(bench.run(bench.meter->read_back(wanted))->equal()) << "it was sent again";
    ASSERT_TRUE(bench.run(bench.meter->measure()));
    EXPECT_EQ(bench.sim->measured_at()->frequency_Hz, 1000);
  }
}

TEST(Lcr6100, AMeterThatRestartedBehindItsPortDiffers) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
  bench.sim->power_on();
  const auto found = bench.run(bench.meter->read_back(fast_polling()));
  ASSERT_TRUE(found);
  EXPECT_GE(found->differs.size(), 5U);
}

// The simulator repeats the answer before: to a query that asks for another setting, or twice.
TEST(Lcr6100, AReadBackIsNotFooledByAnOldLine) {
  for (int at = 0; at < 12; ++at) {
    SCOPED_TRACE(at);
    MeterBench bench;
    ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
    ASSERT_TRUE(bench.run(bench.meter->measure()));
    for (int i = 0; i < at; ++i) bench.sim->faults().replies.emplace_back(Kind::none);
    bench.sim->faults().replies.emplace_back(Kind::twice);
    auto found = bench.run(bench.meter->read_back(fast_polling()));
    ASSERT_TRUE(found) << found.error().what;
    EXPECT_TRUE(found->equal()) << found->differs.front();
    bench.sim->faults().replies.clear();
    ASSERT_TRUE(bench.sim->turn(PanelKey::frequency, "100"));
    for (int i = 0; i < at; ++i) bench.sim->faults().replies.emplace_back(Kind::none);
    bench.sim->faults().replies.emplace_back(Kind::twice);
    found = bench.run(bench.meter->read_back(fast_polling()));
    ASSERT_TRUE(found) << found.error().what;
    EXPECT_EQ(found->differs, std::vector<std::string>{"frequency_Hz"});
  }
  for (std::size_t i = 0; i + 1 < read_backs_for(fast_polling()).size(); ++i) {
    const auto table = read_backs_for(fast_polling());
    if (table[i].query == table[i + 1].query) continue;
    EXPECT_FALSE(matches(table[i + 1], table[i].wanted)) << table[i].query << " too late by one";
  }
}

TEST(Lcr6100, AFrequencyWithinAFewPartsPerMillionIsTheOneWanted) {
  const auto table = settings_for(LcrSettings());
  const auto frequency = std::ranges::find(table, SettingId::frequency, &Setting::id);
  EXPECT_TRUE(matches(*frequency, "1.000002e+03"));
  EXPECT_TRUE(matches(*frequency, "9.999970e+02"));
  EXPECT_FALSE(matches(*frequency, "1.000020e+03"));
}

// A setting whose change takes effect 1 s after it was answered.
TEST(Lcr6100, NoValueOfTheSettingsBeforeIsTakenWithinTheSettlingTime) {
  for (const LcrTrigger trigger : {LcrTrigger::bus, LcrTrigger::internal}) {
    for (const double delay_s : {0.3, 0.7, 1.0}) {
      SCOPED_TRACE(delay_s);
      MeterBench bench;
      LcrSettings s = fast_polling();
      s.trigger = trigger;
      bench.sim->faults().late_settings_s = delay_s;
      for (const double Hz : {1000.0, 100.0, 20e3}) {
        s.frequency = Frequency::from_si(Hz);
        ASSERT_TRUE(bench.run(bench.meter->configure(s)));
        for (int i = 0; i < 20; ++i) {
          ASSERT_TRUE(bench.run(bench.meter->measure()));
          ASSERT_TRUE(bench.sim->measured_at());
          EXPECT_EQ(bench.sim->measured_at()->frequency_Hz, Hz) << "reading " << i;
          EXPECT_EQ(bench.sim->measured_at()->aperture, 0U);
        }
      }
    }
  }
}

TEST(Lcr6100, ACapacitanceThatNoMeterCanShowIsFlagged) {
  for (const double F : {0.0, -1.0, -5e-12}) {
    const auto source = [F](MonoTime) {
      Electrical e;
      e.capacitance_F = F;
      return e;
    };
    SimConfig config;
    config.capacitance_noise_F = {};
    MeterBench bench("", config, source);
    ASSERT_TRUE(bench.run(bench.meter->configure(fast_polling())));
    const auto r = bench.run(bench.meter->measure());
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_TRUE(r->flags & lcr_flag::kOutOfRange) << F;
  }
  EXPECT_FALSE(is_out_of_range(LcrSettings(), 7e-12));
  EXPECT_FALSE(is_out_of_range(LcrSettings(), -1e-13)) << "noise about an open fixture";
}

TEST(Lcr6100, CorrectionsEndWithPassOrWithTheMetersWord) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  auto on = bench.run(bench.meter->corrections());
  ASSERT_TRUE(on) << on.error().what;
  EXPECT_EQ(on->open, false);
  EXPECT_EQ(on->short_circuit, false);
  const double begin = bench.seconds();
  EXPECT_TRUE(bench.run(bench.meter->correct(CorrectionKind::open)));
  EXPECT_GT(bench.seconds(), begin + 20) << "it measures at all its frequencies";
  on = bench.run(bench.meter->corrections());
  EXPECT_EQ(on->open, true);
  EXPECT_EQ(on->short_circuit, false) << "one does not switch the other on";
  EXPECT_TRUE(bench.run(bench.meter->correct(CorrectionKind::short_circuit)));
  EXPECT_EQ(bench.run(bench.meter->corrections())->short_circuit, true);
  bench.sim->faults().correction_fails = true;
  const auto failed = bench.run(bench.meter->correct(CorrectionKind::open));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, Errc::refused);
  EXPECT_FALSE(bench.run(bench.meter->measure())) << "it has to be set up again";
  EXPECT_TRUE(bench.run(bench.meter->configure(LcrSettings())));
}

// The meter measures the correction; a separate command decides whether it is used.
TEST(Lcr6100, ACorrectionThatTheMeterDoesNotSwitchOnIsRefused) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  bench.sim->faults().lose_sets = 3;
  const auto made = bench.run(bench.meter->correct(CorrectionKind::open));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::refused) << made.error().what;
  EXPECT_EQ(bench.run(bench.meter->corrections())->open, false);
}

TEST(Lcr6100, AVerdictThatNeverComesIsNoReplyAndALateOneIsNoReading) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  bench.sim->faults().replies = {Fault(Kind::none), Fault(Kind::drop)};
  const auto made = bench.run(bench.meter->correct(CorrectionKind::open));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::no_reply);
  Fault late(Kind::none);
  late.delay = 150s;
  bench.sim->faults().replies = {Fault(Kind::none), late};
  EXPECT_FALSE(bench.run(bench.meter->correct(CorrectionKind::short_circuit)));
  ASSERT_TRUE(bench.run(bench.meter->configure(LcrSettings())));
  const auto r = bench.run(bench.meter->measure());
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_NEAR(r->primary.value_or(0), 7.2914e-12, 1e-12);
}

TEST(Lcr6100, AMeterThatDoesNotKnowTheQuestionLeavesItsCorrectionsUnknown) {
  MeterBench bench;
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  bench.sim->faults().replies = {Fault(Kind::drop), Fault(Kind::none), Fault(Kind::drop),
                                 Fault(Kind::none), Fault(Kind::drop)};
  const auto on = bench.run(bench.meter->corrections());
  ASSERT_TRUE(on) << on.error().what;
  EXPECT_FALSE(on->open);
  EXPECT_FALSE(on->short_circuit);
  ASSERT_TRUE(bench.run(bench.meter->configure(LcrSettings())));
  EXPECT_TRUE(bench.run(bench.meter->measure()));
  bench.sim->close();
  EXPECT_EQ(bench.run(bench.meter->corrections()).error().code, Errc::disconnected);
}

// A power cut does not remove the corrections of a meter that stores them.
TEST(Lcr6100, ACorrectedMeterStaysCorrected) {
  SimConfig config;
  config.corrected = true;
  MeterBench bench("", config);
  ASSERT_TRUE(bench.run(bench.meter->identify()));
  EXPECT_EQ(bench.run(bench.meter->corrections())->open, true);
  bench.sim->power_on();
  EXPECT_EQ(bench.run(bench.meter->corrections())->short_circuit, true);
}

// The pause between two questions was once taken for a slow meter.
TEST(Lcr6100, AMeterThatIsAskedSeldomIsNotSetUpAgain) {
  MeterBench bench;
  LcrSettings s = fast_polling();
  s.poll_interval = 400ms;
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  for (int i = 0; i < 20; ++i) {
    const auto r = bench.run(bench.meter->measure());
    ASSERT_TRUE(r);
    EXPECT_TRUE(r->fresh);
    EXPECT_EQ(r->flags & lcr_flag::kAfterSetUp, 0U) << i;
  }
}

TEST(Lcr6100, RecordedReadingsComeBackDigitForDigit) {
  const std::vector<std::string> rows{"+1.84249e-12,+1.00000e+20", "+1.83986e-12,-9.98700e+07",
                                      "+1.83005e-12,+1.00000e+20"};
  MeterBench bench([&rows](Duration t, Duration) {
    const auto i = std::min(static_cast<std::size_t>(t / 70ms), rows.size() - 1);
    return Lcr6100Sim::Recorded{i + 1, rows[i]};
  });
  LcrSettings s = fast_polling();
  s.function = LcrFunction::CpRp;
  s.poll_interval = 5ms;
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  EXPECT_EQ(bench.run(bench.meter->measure())->primary, 1.84249e-12);
  const auto second = bench.run(bench.meter->measure());
  EXPECT_EQ(second->primary, 1.83986e-12);
  EXPECT_EQ(second->secondary, -9.98700e+07);
  EXPECT_EQ(bench.run(bench.meter->measure())->primary, 1.83005e-12);
  EXPECT_FALSE(bench.run(bench.meter->measure())->fresh);
}

// The recording begins after 300 ms, with a reading every 70 ms.
Lcr6100Sim::Recorded late_recording(Duration t, Duration) {
  Lcr6100Sim::Recorded out;
  if (t < 300ms) return out;
  out.number = static_cast<std::size_t>((t - 300ms) / 70ms) + 1;
  out.text = fmt::format("+1.{:03d}00e-12,+1.00000e+08", out.number);
  return out;
}

TEST(Lcr6100, TheFirstRecordedReadingIsWaitedFor) {
  MeterBench bench(late_recording);
  LcrSettings s = fast_polling();
  s.poll_interval = 10ms;
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  const double begin_s = bench.seconds();
  const auto first = bench.run(bench.meter->measure());
  ASSERT_TRUE(first) << first.error().what;
  EXPECT_EQ(first->primary, 1.001e-12);
  EXPECT_NEAR(bench.seconds() - begin_s, 0.3, 0.1);
}

// A triggered reading is newer than the trigger: the window that it ends began after it.
TEST(Lcr6100, ATriggerGetsARecordedReadingThatIsNewer) {
  MeterBench bench(late_recording);
  LcrSettings s = fast_polling();
  s.trigger = LcrTrigger::bus;
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  ASSERT_TRUE(bench.run(bench.meter->measure()));
  const double conversion_s = to_seconds(bench.meter->capabilities().conversion_time(s));
  double arrived_s = bench.seconds(), number = 0;
  for (int i = 0; i < 10; ++i) {
    const double asked_s = bench.seconds();
    const auto r = bench.run(bench.meter->measure());
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_GE(bench.seconds() - asked_s, conversion_s);
    EXPECT_LE(bench.seconds() - asked_s, conversion_s + 0.075);
    const double got = std::round((r->primary.value() * 1e12 - 1) * 1e3);
    EXPECT_GT(got, number) << "the same reading again";
    // Its recorded arrival is that of the answer.
    if (i > 0) {
      EXPECT_NEAR((got - number) * 0.07, bench.seconds() - arrived_s, 0.005);
    }
    number = got;
    arrived_s = bench.seconds();
  }
}

TEST(Lcr6100, TheSameSeedGivesTheSameReadingsHoweverTheyAreAsked) {
  const auto readings = [](std::uint64_t seed, Duration interval) {
    SimConfig config;
    config.seed = seed;
    MeterBench bench("", config);
    LcrSettings s = fast_polling();
    s.poll_interval = interval;
    static_cast<void>(bench.run(bench.meter->configure(s)));
    std::vector<double> out;
    for (int i = 0; i < 40; ++i) out.push_back(bench.run(bench.meter->measure())->primary.value());
    return out;
  };
  EXPECT_EQ(readings(1, 5ms), readings(1, 5ms));
  EXPECT_NE(readings(1, 5ms), readings(2, 5ms));
}

TEST(Lcr6100Sim, NoiseHasTheConfiguredWidth) {
  MeterBench bench;
  LcrSettings s = fast_polling();
  s.frequency = Frequency::from_si(20e3);
  ASSERT_TRUE(bench.run(bench.meter->configure(s)));
  double sum = 0, squares = 0;
  constexpr int kReadings = 2000;
  for (int i = 0; i < kReadings; ++i) {
    const double c = *bench.run(bench.meter->measure())->primary - 7.2914e-12;
    sum += c;
    squares += c * c;
  }
  const double sigma = std::sqrt(squares / kReadings);
  EXPECT_NEAR(sigma, 3e-15, 0.2e-15);
  EXPECT_LT(std::abs(sum / kReadings), 3 * 3e-15 / std::sqrt(kReadings));
}

}  // namespace
}  // namespace lcrig::lcr6100
