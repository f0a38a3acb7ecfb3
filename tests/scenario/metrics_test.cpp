// SPDX-License-Identifier: Apache-2.0
// The daemon's health, for a client and in a file.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>

#include "tests/support/daemon_world.hpp"

namespace lcrig::support {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

class DaemonHealth : public DaemonWorld {
 protected:
  void configure(Config& config) override { config.metrics_file = file(); }
  std::string file() const { return dir.file("lcrig.prom"); }
  std::string written() const {
    std::ifstream in(file());
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

TEST_F(DaemonHealth, IsToldToWhoAsksAndWrittenToAFile) {
  PlainClient client(socket_path());
  clock.run_for(io, 1s);
  EXPECT_THAT(written(), HasSubstr("lcrig_run_active 0\n"));
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  clock.run_for(io, 60s);
  const auto told = answer(client, "metrics")["result"]["text"].get<std::string>();
  EXPECT_THAT(told, AllOf(HasSubstr("lcrig_run_active 1\n"), HasSubstr("lcrig_run_number 1\n"),
                          HasSubstr("lcrig_events_total{kind=\"step_begin\"}"),
                          HasSubstr("lcrig_instrument_ready{instrument=\"frame\"} 1\n"),
                          HasSubstr("lcrig_wal_bytes ")));
  EXPECT_THAT(written(), HasSubstr("lcrig_run_active 1\n"));
}

TEST_F(DaemonHealth, IsReadByEverybodyAndNotServedAfterTheEnd) {
  const auto before = ::umask(0027);
  clock.run_for(io, 20s);
  ::umask(before);
  struct stat found{};
  ASSERT_EQ(::stat(file().c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0644U);
  EXPECT_THAT(written(), HasSubstr("lcrig_instrument_missing{instrument=\"frame\"} 0\n"));
  EXPECT_THAT(written(), HasSubstr("# TYPE lcrig_commit_seconds summary\n"));
}

TEST_F(DaemonHealth, IsToldToTwoWhoAskAtOnce) {
  PlainClient one(socket_path()), other(socket_path());
  one.call("metrics");
  other.call("metrics");
  clock.run_for(io, 2s);
  for (PlainClient* client : {&one, &other}) {
    const auto answers = client->take();
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_TRUE(answers[0].contains("result")) << answers[0];
  }
}

}  // namespace
}  // namespace lcrig::support
