// SPDX-License-Identifier: Apache-2.0
// A protocol may have two million steps. The thread that runs the instruments therefore does not
// plan, and during a run no thread does.
#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "daemon/rig/sim.hpp"
#include "daemon/session.hpp"
#include "tests/support/daemon_world.hpp"
#include "tests/support/run_task.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using support::PlainClient;

// Instruments of the simulated bench that record which thread asks for the specimen's compression.
class WatchedInstruments final : public Instruments {
 public:
  WatchedInstruments(std::unique_ptr<Instruments> inner, std::set<std::thread::id>& planners)
      : inner_(std::move(inner)) {
    info_ = inner_->info();
    info_.compression_m = [&planners, reckon = info_.compression_m](double force_N) {
      planners.insert(std::this_thread::get_id());
      return reckon(force_N);
    };
  }
  LcrMeter& meter() override { return inner_->meter(); }
  LoadFrame& frame() override { return inner_->frame(); }
  Operator& person() override { return inner_->person(); }
  Task<> close() override { return inner_->close(); }

 private:
  std::unique_ptr<Instruments> inner_;
};

PreparedRun prepared_run() {
  RunRequest request;
  request.protocol_name = "watched";
  request.protocol_text = support::kWatchedProtocol;
  request.specimen_name = "paper-1";
  request.specimen_text = std::string(shipped_specimens().front().text);
  return prepare_run(std::move(request)).value();
}

Task<bool> open_and_close(Session& session) {
  auto opened = co_await session.open();
  co_await session.close();
  co_return opened.has_value();
}

TEST(Planning, IsNotDoneByTheThreadThatRunsTheInstruments) {
  TempDir dir;
  asio::io_context io{1};
  VirtualClock clock;
  auto recorder = Recorder::open(io, clock, Recorder::Options(dir.file("t.db"))).value();
  PreparedRun prepared = prepared_run();
  SimRequest sim;
  sim.bench = *find_bench("paper");
  sim.specimen = *prepared.specimen;
  auto bench = make_sim_instruments(io.get_executor(), clock, sim).value();
  std::set<std::thread::id> planners;
  Session session(io.get_executor(), clock, *recorder,
                  std::make_unique<WatchedInstruments>(std::move(bench), planners),
                  std::move(prepared));
  EXPECT_TRUE(run_task(io, clock, open_and_close(session)));
  EXPECT_FALSE(planners.empty());
  EXPECT_FALSE(planners.contains(std::this_thread::get_id()));
}

class DaemonThatRuns : public support::DaemonWorld {};

TEST_F(DaemonThatRuns, RefusesAnotherStartBeforeItReadsTheTexts) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  for (const char* text : {"protocol_text", "specimen_text"}) {
    auto request = start_request();
    request[text] = "no JSON at all";
    const json refused = answer(client, "run.start", request);
    EXPECT_EQ(refused["error"]["data"]["errc"], "busy") << refused;
  }
  EXPECT_EQ(answer(client, "run.abort").count("result"), 1U);
}

}  // namespace
}  // namespace lcrig
