// SPDX-License-Identifier: Apache-2.0
// `status` tells the newest knowledge about the instruments, whoever asked them. It never calls an
// instrument ready that nobody has asked.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "drivers/zwick/sim.hpp"
#include "tests/support/daemon_world.hpp"
#include "tests/support/loss_world.hpp"
#include "tests/support/protocol_text.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::HasSubstr;

// A run whose session reports what it learns of the instruments.
class ReportingWorld final : public SessionWorld {
 public:
  explicit ReportingWorld(std::string text) : SessionWorld(std::move(text)) {
    known.declare(Instrument::lcr, "sim", "nobody did", false);
    known.declare(Instrument::frame, "sim", "nobody did", false);
  }
  InstrumentState seen(Instrument which, std::optional<std::int64_t> run = std::nullopt) const {
    return known.states(run).at(static_cast<std::size_t>(which));
  }
  void look_at(const std::string& step, Duration after, Instrument which) {
    acts.push_back({step, after, [this, which](SessionWorld&) { saw.push_back(seen(which, 1)); }});
  }
  KnownRig known{clock};
  std::vector<InstrumentState> saw;

 private:
  void built() override { session->report_to(known, LearnedBy::start); }
};

constexpr const char* kRecord = R"({ "id": "record", "do": "record", "for_s": 20 })";

void expect_loss_is_known(Which which) {
  const Instrument lost = which == Which::meter ? Instrument::lcr : Instrument::frame;
  ReportingWorld world(loss_protocol("wait", kRecord));
  world.look_at("record", 2s, lost);
  away(world, "record", which, 5s, 6s);
  world.look_at("record", 9s, lost);
  world.look_at("record", 15s, lost);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  ASSERT_EQ(world.saw.size(), 3U);
  const InstrumentState &before = world.saw[0], &during = world.saw[1], &after = world.saw[2];
  EXPECT_EQ(before.condition, InstrumentCondition::in_use);
  EXPECT_NE(before.identity, "");
  EXPECT_TRUE(before.simulated);
  EXPECT_LT(before.age_s.value_or(99), 0.5) << "it sends data";
  EXPECT_EQ(during.condition, InstrumentCondition::absent);
  EXPECT_EQ(during.learned_by, LearnedBy::run);
  EXPECT_EQ(during.run, 1);
  EXPECT_NE(during.why, "");
  EXPECT_EQ(during.identity, before.identity) << "what was there";
  EXPECT_GT(during.since_s.value_or(0), 2);
  EXPECT_LT(during.since_s.value_or(99), 4.1);
  EXPECT_EQ(after.condition, InstrumentCondition::in_use);
  const auto ended = world.seen(lost);
  EXPECT_EQ(ended.condition, InstrumentCondition::ready);
  EXPECT_EQ(ended.learned_by, LearnedBy::run);
  EXPECT_EQ(ended.run, 1);
}

TEST(KnownOfARun, AMeterThatVanishedAndCameBack) {
  expect_loss_is_known(Which::meter);
}

TEST(KnownOfARun, AFrameThatVanishedAndCameBack) {
  expect_loss_is_known(Which::frame);
}

TEST(KnownOfARun, ALossThatEndedItIsKnownAfterwards) {
  ReportingWorld world(loss_protocol("abort", kRecord));
  world.acts.push_back({"record", 5s, [](SessionWorld& w) { unplug(w, Which::meter); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_EQ(world.seen(Instrument::lcr).condition, InstrumentCondition::absent);
  EXPECT_EQ(world.seen(Instrument::frame).condition, InstrumentCondition::ready);
}

TEST(KnownOfARun, AFrameThatDoesNotConfirmStandstillIsAtFault) {
  ReportingWorld world(kLoad);
  world.acts.push_back({"clear", 500ms, [](SessionWorld& w) {
                          frame(w).faults.lose_stopped = 1000;
                          frame(w).poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  ASSERT_EQ(r->code, Errc::not_standing) << r->reason;
  const auto known = world.seen(Instrument::frame);
  EXPECT_EQ(known.condition, InstrumentCondition::fault);
  EXPECT_EQ(known.why, r->reason);
}

TEST(KnownOfARun, AStartThatAnInstrumentRefusedIsKnown) {
  class Unplugged final : public SessionWorld {
   public:
    using SessionWorld::SessionWorld;
    KnownRig known{clock};

   private:
    void built() override {
      known.declare(Instrument::lcr, "sim", "", false);
      session->report_to(known, LearnedBy::start);
      unplug(*this, Which::meter);
    }
  };
  Unplugged world(kLoad);
  EXPECT_FALSE(world.run());
  const auto known = world.known.states(std::nullopt).at(0);
  EXPECT_EQ(known.condition, InstrumentCondition::absent);
  EXPECT_EQ(known.learned_by, LearnedBy::start);
}

class KnownSimulatedRig : public support::DaemonWorld {
 protected:
  json instruments(PlainClient& client) {
    return answer(client, "status")["result"].value("instruments", json::array());
  }
  void expect_both(const json& list, const std::string& state, const std::string& by) {
    ASSERT_EQ(list.size(), 2U);
    for (const json& i : list) {
      EXPECT_EQ(i["state"].get<std::string>(), state) << i;
      EXPECT_EQ(i["learned_by"].get<std::string>(), by) << i;
      EXPECT_TRUE(i["simulated"].get<bool>()) << i;
    }
  }
};

TEST_F(KnownSimulatedRig, IsReadyOnceItWasUsed) {
  PlainClient client(socket_path());
  expect_both(instruments(client), "unasked", "nothing");
  EXPECT_TRUE(answer(client, "run.plan", start_request()).contains("result"));
  expect_both(instruments(client), "ready", "plan");
  client.call("watch");
  wait_for(client, [](const json& m) { return m.contains("id"); });
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  const json status =
      wait_for(client, [](const json& m) { return m.value("method", "") == "status"; });
  EXPECT_TRUE(status["params"]["simulated"].get<bool>());
  const json used = instruments(client);
  expect_both(used, "in_use", "run");
  for (const json& i : used) EXPECT_NE(i["identity"].get<std::string>(), "");
  client.call("run.abort");
  const json ended =
      wait_for(client, [](const json& m) { return m.value("method", "") == "run_ended"; });
  EXPECT_TRUE(ended["params"]["simulated"].get<bool>());
  expect_both(instruments(client), "ready", "run");
  const json last = answer(client, "status")["result"]["last_run"];
  EXPECT_TRUE(last["simulated"].get<bool>());
}

TEST_F(KnownSimulatedRig, IsNotReadyWhenItsBenchIsGone) {
  stop();
  const auto file = dir.file("bench.json");
  std::ofstream(file) << "{}";
  Config config;
  config.database = dir.file("d.db");
  config.socket = socket_path();
  config.bench = file;
  app = std::make_unique<App>(io, clock, config);
  ASSERT_TRUE(app->start());
  PlainClient client(socket_path());
  EXPECT_TRUE(answer(client, "instruments.ask").contains("result"));
  expect_both(instruments(client), "fault", "look");
  std::filesystem::remove(file);
  EXPECT_TRUE(answer(client, "run.start", start_request()).contains("error"));
  expect_both(instruments(client), "fault", "start");
  EXPECT_THAT(instruments(client).at(0)["why"].get<std::string>(), HasSubstr("bench.json"));
}

}  // namespace
}  // namespace lcrig
