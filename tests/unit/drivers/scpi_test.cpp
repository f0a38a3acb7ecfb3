// SPDX-License-Identifier: Apache-2.0
#include "drivers/scpi.hpp"
#include "base/either.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "drivers/memory_pipe.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kIdentity = "LCR-6100,REV E8.13,GEZ883880,Good Will Co., Ltd.";

// Trouble with one answer. The instrument answers in order, so a late answer delays the next one.
struct Fault {
  Fault() = default;
  explicit Fault(Duration d) : delay(d) {}
  Duration delay{};
  bool twice = false, echo = false, drop = false;
  std::size_t cut = std::string::npos;  // bytes kept of the line, without its end
  std::string instead;
};

// Answers `Qn?` with `An`, `*IDN?` with its identity, and nothing else.
class Instrument {
 public:
  Instrument(Transport& far, Clock& clock) : far_(far), clock_(clock) {}
  std::deque<Fault> faults;
  int asked = 0;
  int late_every = 0;  // every nth answer comes 1.5 s late; 0: none

  Task<> run() {
    std::string in;
    std::array<char, 256> chunk{};
    while (true) {
      auto n = co_await far_.read_some(chunk, MonoTime::max());
      if (!n) co_return;
      in.append(chunk.data(), *n);
      for (auto end = in.find('\n'); end != in.npos; end = in.find('\n')) {
        const std::string command = in.substr(0, end);
        in.erase(0, end + 1);
        if (command.ends_with('?')) co_await answer(command);
      }
    }
  }

 private:
  Task<> answer(std::string command) {
    ++asked;
    Fault fault;
    if (!faults.empty()) {
      fault = faults.front();
      faults.pop_front();
    }
    if (late_every > 0 && asked % late_every == 0) fault.delay = 1500ms;
    if (fault.delay > 0s) co_await clock_.wait_for(fault.delay);
    if (fault.drop) co_return;
    std::string text = fault.instead;
    if (text.empty()) {
      text = command == "*IDN?" ? std::string(kIdentity) : "A" + command.substr(1);
      if (text.ends_with('?')) text.pop_back();
    }
    std::string line = text.substr(0, fault.cut);
    if (fault.cut == std::string::npos) line += "\r\n";
    if (fault.twice) line += line;
    if (fault.echo) line = command + "\r\n" + line;
    auto written = co_await far_.write_all(line, clock_.now() + 1s);
    static_cast<void>(written);
  }

  Transport& far_;
  Clock& clock_;
};

class ScpiTest : public ::testing::Test {
 protected:
  ScpiTest() {
    auto pair = make_memory_pipe(io.get_executor(), clock, "sim:lcr");
    far = std::move(pair.far);
    instrument.emplace(*far, clock);
    link.emplace(std::move(pair.near), clock);
    link->set_identity(std::string(kIdentity));
    asio::co_spawn(io, instrument->run(), asio::detached);
  }
  ~ScpiTest() override {
    far->close();
    io.poll();
  }
  Result<Reply> ask(std::string_view command, Duration timeout = 1s) {
    return run_task(io, clock, link->query(command, timeout));
  }
  // Asks ten questions; every answer must belong to its question.
  void expect_in_step() {
    for (int i = 10; i < 20; ++i) {
      const std::string n = std::to_string(i);
      const auto r = ask("Q" + n + "?");
      ASSERT_TRUE(r) << r.error().what;
      EXPECT_EQ(r->text, "A" + n);
    }
  }

  asio::io_context io;
  VirtualClock clock;
  std::unique_ptr<Transport> far;
  std::optional<Instrument> instrument;
  std::optional<ScpiLink> link;
};

TEST_F(ScpiTest, AnAnswerHasItsThreeTimes) {
  instrument->faults = {Fault(300ms)};
  const auto r = ask("Q1?");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->text, "A1");
  EXPECT_EQ(r->first_byte - r->asked, 300ms);
  EXPECT_EQ(r->last_byte - r->asked, 300ms);
  EXPECT_FALSE(link->dirty());
  EXPECT_EQ(instrument->asked, 1);
}

TEST_F(ScpiTest, SilenceBecomesNoReply) {
  Fault drop;
  drop.drop = true;
  instrument->faults = {drop};
  const auto r = ask("Q1?", 500ms);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::no_reply);
  EXPECT_EQ(r.error().what, "sim:lcr: Q1? -> no reply in 500 ms");
  expect_in_step();
}

TEST_F(ScpiTest, ALateAnswerIsNeverTakenForAnotherQuestions) {
  instrument->faults = {Fault(1500ms)};
  const auto late = ask("Q1?");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Errc::no_reply);
  expect_in_step();
  EXPECT_TRUE(link->take_resynced());
  EXPECT_FALSE(link->take_resynced());
}

TEST_F(ScpiTest, SeveralLateAnswersAreAllThrownAway) {
  for (int round = 0; round < 5; ++round) instrument->faults.emplace_back(1500ms);
  for (int i = 1; i < 4; ++i) {
    const std::string n = std::to_string(i);
    const auto r = ask("Q" + n + "?");
    EXPECT_TRUE(!r || r->text == "A" + n);
  }
  expect_in_step();
}

TEST_F(ScpiTest, TenThousandQuestionsWithEveryTwentiethAnswerLateGiveNoWrongPair) {
  instrument->late_every = 20;
  int wrong = 0, right = 0, failed = 0;
  for (int i = 0; i < 10'000; ++i) {
    const std::string n = std::to_string(i);
    const auto r = ask("Q" + n + "?");
    if (!r) {
      ++failed;
    } else {
      (r->text == "A" + n ? right : wrong) += 1;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(right + failed, 10'000);
  EXPECT_GT(failed, 400) << "the late answers were not late";
  EXPECT_LT(failed, 1100);
}

TEST_F(ScpiTest, ALateIdentityIsNotTakenForTheSentinels) {
  instrument->faults = {Fault(1500ms), Fault(1500ms)};
  ASSERT_FALSE(ask("*IDN?"));
  expect_in_step();
}

TEST_F(ScpiTest, ACutAnswerIsNotSilence) {
  Fault cut;
  cut.cut = 1;
  instrument->faults = {cut};
  const auto r = ask("Q12345?");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::reply_cut_off);
  EXPECT_NE(r.error().what.find("cut off after \"A\""), std::string::npos) << r.error().what;
  expect_in_step();
}

TEST_F(ScpiTest, ADoubledAnswerDoesNotShiftTheNext) {
  Fault twice;
  twice.twice = true;
  instrument->faults = {twice, Fault(), twice};
  EXPECT_EQ(ask("Q1?")->text, "A1");
  EXPECT_EQ(ask("Q2?")->text, "A2");
  expect_in_step();
}

TEST_F(ScpiTest, AnEchoIsNotAnAnswer) {
  Fault echo;
  echo.echo = true;
  instrument->faults = {echo, echo};
  EXPECT_EQ(ask("Q1?")->text, "A1");
  EXPECT_EQ(ask("Q2?")->text, "A2");
  EXPECT_TRUE(link->take_echo_seen());
  expect_in_step();
}

TEST_F(ScpiTest, AGarbledSentinelIsAskedAgain) {
  Fault noise;
  noise.instead = "\x01\xff#7,,";
  instrument->faults = {Fault(1200ms), noise};
  ASSERT_FALSE(ask("Q1?"));
  expect_in_step();
}

TEST_F(ScpiTest, ALineWithoutEndIsGarbled) {
  Fault endless;
  endless.instead = std::string(3000, 'x');
  endless.cut = 3000;
  instrument->faults = {endless};
  const auto r = ask("Q1?");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::garbled);
  expect_in_step();
}

TEST_F(ScpiTest, UnaskedLinesBeforeAQuestionAreThrownAway) {
  ASSERT_TRUE(run_task(io, clock, far->write_all("A99\r\nA98\r\n", clock.now() + 1s)));
  EXPECT_EQ(ask("Q1?")->text, "A1");
  EXPECT_TRUE(link->take_stray_seen());
  expect_in_step();
}

Task<bool> cancelled_exchange(ScpiLink& link, Clock& clock) {
  auto r = co_await either(link.query("Q1?", 5s), clock.wait_for(200ms));
  co_return r.index() == 1;
}

TEST_F(ScpiTest, ACancelledExchangeLeavesTheLineDirty) {
  instrument->faults = {Fault(700ms)};
  EXPECT_TRUE(run_task(io, clock, cancelled_exchange(*link, clock)));
  EXPECT_TRUE(link->dirty());
  expect_in_step();
}

TEST_F(ScpiTest, AnInstrumentThatStaysSilentIsNoReplyAndNoTimeIsLostForever) {
  Fault drop;
  drop.drop = true;
  for (int i = 0; i < 20; ++i) instrument->faults.push_back(drop);
  ASSERT_FALSE(ask("Q1?"));
  const auto r = ask("Q2?");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::no_reply);
  EXPECT_LT(clock.now().time_since_epoch(), 30s);
}

TEST_F(ScpiTest, AClosedPortIsDisconnectedAtOnce) {
  far->close();
  const auto r = ask("Q1?", 10s);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::disconnected);
  EXPECT_EQ(clock.now().time_since_epoch(), 0s);
}

}  // namespace
}  // namespace lcrig
