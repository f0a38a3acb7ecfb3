// SPDX-License-Identifier: Apache-2.0
#include "base/log.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "base/clock.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// A journal that accepts nothing until it is released.
class HangingJournal final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  void release() { released_.set_value(); }
  std::vector<std::string> lines;  // read only when nobody writes any more

 protected:
  void sink_it_(const spdlog::details::log_msg& msg) override {
    is_released_.wait();
    lines.emplace_back(msg.payload.data(), msg.payload.size());
  }
  void flush_() override {}

 private:
  std::promise<void> released_;
  std::shared_future<void> is_released_ = released_.get_future().share();
};

class LogThreadTest : public testing::Test {
 protected:
  void SetUp() override {
    auto logger = std::make_shared<spdlog::logger>("test", journal);
    logger->flush_on(spdlog::level::info);
    spdlog::set_default_logger(std::move(logger));
  }
  void TearDown() override { spdlog::set_default_logger(before); }

  std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
  std::shared_ptr<HangingJournal> journal = std::make_shared<HangingJournal>();
};

TEST_F(LogThreadTest, AJournalThatTakesNothingHoldsNobodyUpAndWhatIsLostIsCounted) {
  constexpr int kMessages = 3000;
  {
    const LogThread log;
    for (int i = 0; i < kMessages; ++i) spdlog::info("message {}", i);
    journal->release();
  }
  spdlog::info("directly");
  std::size_t written = 0, lost = 0;
  for (const std::string& line : journal->lines) {
    if (line.starts_with("message ")) ++written;
    if (line.find("were left out here") != line.npos) lost += std::stoul(line);
  }
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(written + lost, std::size_t{kMessages});
  EXPECT_EQ(journal->lines.at(journal->lines.size() - 2), "message 2999") << "the newest are kept";
  EXPECT_EQ(journal->lines.back(), "directly");
}

TEST_F(LogThreadTest, AJournalThatNeverAnswersDelaysTheEndNoLongerThanItsPatience) {
  const RealClock clock;
  MonoTime begin;
  {
    const LogThread log;
    spdlog::info("never written");
    begin = clock.now();
  }
  spdlog::info("would hang");
  EXPECT_LT(clock.now() - begin, 20s);
  journal->release();
}

}  // namespace
}  // namespace lcrig
