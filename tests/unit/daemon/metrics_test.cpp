// SPDX-License-Identifier: Apache-2.0
#include "daemon/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

TEST(Metrics, HoldWhatIsKnownAndNothingElse) {
  Metrics metrics;
  metrics.status.version = "1.2";
  InstrumentState meter;
  metrics.status.instruments.push_back(meter);
  const auto idle = to_text(metrics);
  EXPECT_THAT(idle,
              AllOf(HasSubstr("lcrig_info{version=\"1.2\"} 1\n"), HasSubstr("lcrig_run_active 0\n"),
                    HasSubstr("lcrig_instrument_ready{instrument=\"lcr\"} 0\n")));
  EXPECT_THAT(idle, AllOf(Not(HasSubstr("data_age_seconds{")), Not(HasSubstr("lcrig_run_number")),
                          Not(HasSubstr("lcrig_queue")),
                          Not(HasSubstr("lcrig_wal_bytes "
                                        "0"))));
  metrics.status.instruments[0].condition = InstrumentCondition::in_use;
  metrics.status.instruments[0].age_s = 0.25;
  metrics.status.run.emplace();
  metrics.status.run->run = 12;
  metrics.status.run->lcr_readings = 345;
  metrics.status.queue.emplace();
  metrics.status.queue->count = 7;
  metrics.events["retry"] = 3;
  metrics.worst_lateness = 40ms;
  metrics.commits.queued.add(2ms);
  metrics.system.wal_bytes = 4096;
  const auto busy = to_text(metrics);
  EXPECT_THAT(busy, AllOf(HasSubstr("lcrig_run_active 1\n"), HasSubstr("lcrig_run_number 12\n"),
                          HasSubstr("lcrig_run_lcr_readings_total 345\n"),
                          HasSubstr("lcrig_instrument_data_age_seconds{instrument=\"lcr\"} 0.25\n"),
                          HasSubstr("lcrig_instrument_ready{instrument=\"lcr\"} 1\n"),
                          HasSubstr("lcrig_queue_entries 7\n")));
  EXPECT_THAT(busy, AllOf(HasSubstr("lcrig_events_total{kind=\"retry\"} 3\n"),
                          HasSubstr("lcrig_loop_lateness_seconds_max 0.04\n"),
                          HasSubstr("lcrig_commit_seconds{quantile=\"1\"} 0.002\n"),
                          HasSubstr("lcrig_wal_bytes 4096\n")));
}

// Every line is a comment or a sample, and every sample follows the type of its family.
TEST(Metrics, AreInTheFormatOfPrometheus) {
  Metrics metrics;
  metrics.status.version = "a\"b\\c\nz";
  metrics.system = read_system_figures("/no/such/database");
  EXPECT_FALSE(metrics.system.wal_bytes);
  EXPECT_TRUE(metrics.system.steal_s);
  const std::regex comment(R"(# (HELP|TYPE) (lcrig_\w+) .+)");
  const std::regex sample(R"((lcrig_\w+)(\{\w+="([^"\\]|\\.)*"\})? [-+.0-9e]+)");
  std::istringstream lines(to_text(metrics));
  std::string family;
  int samples = 0;
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (std::regex_match(line, found, comment)) {
      family = found[2];
    } else {
      ASSERT_TRUE(std::regex_match(line, found, sample)) << line;
      EXPECT_EQ(found[1], family);
      ++samples;
    }
  }
  EXPECT_GT(samples, 5);
}

TEST(Metrics, ReadTheSizesOfDatabaseAndLog) {
  const TempDir dir;
  std::ofstream(dir.file("a.db")) << std::string(1000, 'x');
  std::ofstream(dir.file("a.db-wal")) << std::string(50, 'x');
  const auto figures = read_system_figures(dir.file("a.db"));
  EXPECT_EQ(figures.database_bytes, 1000);
  EXPECT_EQ(figures.wal_bytes, 50);
  EXPECT_GT(figures.disk_free_bytes.value_or(0), 0);
}

}  // namespace
}  // namespace lcrig
