// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/known.hpp"

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class Known : public testing::Test {
 protected:
  Known() {
    rig.declare(Instrument::lcr, "serial:/dev/ttyUSB0", "the daemon has just begun", false);
    identity.text = "GW Instek,LCR-6100,1,REV";
  }
  InstrumentState lcr(std::optional<std::int64_t> run = std::nullopt) const {
    return rig.states(run).at(0);
  }
  void pass(Duration time) { clock.run_for(io, time); }

  asio::io_context io{1};
  VirtualClock clock;
  KnownRig rig{clock};
  Identity identity;
  Error silent{Errc::no_reply, "*IDN? -> no reply"};
};

TEST_F(Known, NobodyWhoWasNotAskedIsReady) {
  EXPECT_EQ(lcr().condition, InstrumentCondition::unasked);
  EXPECT_EQ(lcr(3).condition, InstrumentCondition::unasked) << "a run of something else";
  EXPECT_EQ(lcr().age_s, std::nullopt);
  EXPECT_EQ(rig.states(std::nullopt).size(), 1U) << "only what was declared";
}

TEST_F(Known, AnAbsenceLastsSinceItWasFirstSeen) {
  rig.answered(Instrument::lcr, identity, Learned(LearnedBy::look));
  pass(60s);
  rig.failed(Instrument::lcr, silent, Learned(LearnedBy::look));
  pass(28s);
  rig.failed(Instrument::lcr, Error(Errc::disconnected, "no such port"), Learned(LearnedBy::start));
  pass(2s);
  EXPECT_EQ(lcr().condition, InstrumentCondition::absent);
  EXPECT_NEAR(lcr().since_s.value_or(0), 30, 1e-6);
  EXPECT_NEAR(lcr().age_s.value_or(0), 2, 1e-6);
  EXPECT_EQ(lcr().why, "no such port");
  EXPECT_EQ(lcr().learned_by, LearnedBy::start);
  EXPECT_EQ(lcr().identity, identity.text) << "who was there last";
}

TEST_F(Known, AnInstrumentThatAnswersNonsenseIsAtFault) {
  rig.failed(Instrument::lcr, Error(Errc::garbled, "?"), Learned(LearnedBy::look));
  EXPECT_EQ(lcr().condition, InstrumentCondition::fault);
  rig.failed(Instrument::lcr, Error(Errc::unsupported, "not without commanding it"),
             Learned(LearnedBy::look));
  EXPECT_EQ(lcr().condition, InstrumentCondition::unasked);
}

TEST_F(Known, APortThatCameBackWasNotAsked) {
  rig.answered(Instrument::lcr, identity, Learned(LearnedBy::run, 4));
  EXPECT_EQ(lcr().run, 4);
  EXPECT_TRUE(rig.set_port_there(Instrument::lcr, false));
  EXPECT_FALSE(rig.set_port_there(Instrument::lcr, false));
  pass(9s);
  EXPECT_EQ(lcr().condition, InstrumentCondition::absent);
  EXPECT_NEAR(lcr().since_s.value_or(0), 9, 1e-6);
  EXPECT_FALSE(rig.is_ready(Instrument::lcr));
  EXPECT_TRUE(rig.set_port_there(Instrument::lcr, true));
  EXPECT_EQ(lcr().condition, InstrumentCondition::unasked);
  EXPECT_FALSE(rig.is_known(Instrument::lcr));
  rig.answered(Instrument::lcr, identity, Learned(LearnedBy::look));
  EXPECT_TRUE(rig.is_ready(Instrument::lcr));
}

TEST_F(Known, DataMakeItFreshButBringNobodyBack) {
  rig.answered(Instrument::lcr, identity, Learned(LearnedBy::run, 4));
  pass(50s);
  rig.heard(Instrument::lcr);
  EXPECT_EQ(lcr(4).condition, InstrumentCondition::in_use);
  EXPECT_EQ(lcr(4).age_s, 0.0);
  rig.failed(Instrument::lcr, silent, Learned(LearnedBy::run, 4));
  pass(1s);
  rig.heard(Instrument::lcr);  // an answer that was still on its way
  EXPECT_EQ(lcr(4).condition, InstrumentCondition::absent);
  EXPECT_NEAR(lcr(4).age_s.value_or(0), 1, 1e-6);
}

}  // namespace
}  // namespace lcrig
