// SPDX-License-Identifier: Apache-2.0
// The command line against a real control server in another thread.
#include <gmock/gmock.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/control/server.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/control_fixture.hpp"

namespace lcrig {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Served : public ::testing::Test {
 protected:
  void SetUp() override {
    handler.state.version = "9.9";
    ended.run = 7;
    ended.exit_status = ExitStatus::success;
    handler.after_start = [this] { end_run(); };
    cli.env.daemon_socket = path;
    cli.add_data("protocols/press.json", "{}");
    const auto listening = server.listen(path);
    ASSERT_TRUE(listening) << listening.error().what;
    thread = std::thread([this] { io.run(); });
  }
  void TearDown() override {
    std::promise<void> closed;
    asio::co_spawn(io, server.close(std::chrono::seconds(2)),
                   [&](const std::exception_ptr&) { closed.set_value(); });
    closed.get_future().wait();
    work.reset();
    thread.join();
  }
  // At once, so that `lcrig run` has something to follow.
  void end_run() {
    RunEventNote note;
    note.run = 7;
    note.event = RunEvent(MonoTime(), EventKind::mark, "load", "half way");
    server.publish_event(note);
    server.publish_run_ended(ended);
  }
  // Runs `f` where the server runs, and waits.
  template <class F>
  void on_server(F f) {
    std::promise<void> done;
    asio::post(io, [&] {
      f();
      done.set_value();
    });
    done.get_future().wait();
  }

  support::Cli cli;
  std::string path = cli.dir.file("control.sock");
  asio::io_context io;
  asio::executor_work_guard<asio::io_context::executor_type> work = asio::make_work_guard(io);
  RealClock clock;
  support::FakeHandler handler;
  RunOutcome ended;
  ControlServer server{io.get_executor(), clock, handler};
  std::thread thread;
};

TEST_F(Served, StatusShowsVersionAndRun) {
  on_server([this] {
    handler.state.run.emplace();
    handler.state.run->run = 4;
    handler.state.run->prompt = "place 50 g";
  });
  EXPECT_EQ(cli.run({"status"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("lcrigd 9.9"), HasSubstr("run 4"),
                                   HasSubstr("waits for: place 50 g")));
  EXPECT_EQ(cli.run({"status", "--json"}), 0);
  EXPECT_EQ(nlohmann::json::parse(cli.out.str())["run"]["run"], 4);
}

TEST_F(Served, VerbsReachTheDaemon) {
  EXPECT_EQ(cli.run({"pause"}), 0);
  EXPECT_EQ(cli.run({"resume"}), 0);
  EXPECT_EQ(cli.run({"resume", "12"}), 0);
  EXPECT_THAT(cli.err.str(), HasSubstr("lcrig confirm"));
  EXPECT_EQ(cli.run({"resume", "12", "--confirm-specimen"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 13 continues run 12"));
  EXPECT_EQ(cli.run({"abort", "--why", "smoke"}), 0);
  EXPECT_EQ(cli.run({"freeze"}), 0);
  EXPECT_EQ(cli.run({"confirm"}), 0);
  on_server([this] {
    EXPECT_THAT(handler.calls,
                ElementsAre("pause", "resume present", "resume 12", "resume 12 confirmed",
                            "abort smoke", "freeze ", "confirm"));
  });
}

TEST_F(Served, TheDaemonsRefusalKeepsItsWordsAndHint) {
  on_server([this] { handler.next_error = Error(Errc::no_reply, "lcr0: *IDN? -> no reply"); });
  EXPECT_EQ(cli.run({"pause"}), cli::kInstrument);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("lcr0: *IDN? -> no reply"), HasSubstr("next: ")));
}

TEST_F(Served, RunFollowsToTheEndAndPrintsTheResultLast) {
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "mine", "-p", "cycles=2", "--json"}), 0)
      << cli.err.str();
  const auto result = nlohmann::json::parse(cli.out.str());
  EXPECT_EQ(result["run"], 7);
  EXPECT_EQ(result["exit_status"], "success");
  EXPECT_THAT(cli.err.str(), HasSubstr("mark (load): half way"));
  on_server([this] {
    EXPECT_EQ(std::get<std::string>(handler.last_start.parameters.at("cycles")), "2");
    EXPECT_EQ(handler.last_start.protocol_text, "{}");
    EXPECT_EQ(handler.last_start.specimen_name, "mine");
    EXPECT_EQ(handler.last_start.specimen_text, "");  // the daemon's database knows it
  });
}

TEST_F(Served, ATrippedLimitIsFive) {
  on_server([this] {
    ended.exit_status = ExitStatus::fail;
    ended.code = Errc::limit_tripped;
    ended.reason = "force 1.6 N";
  });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), cli::kStopped);
  EXPECT_THAT(cli.out.str(), HasSubstr("force 1.6 N"));
}

TEST_F(Served, ARefusedProtocolIsSix) {
  on_server([this] { handler.next_error = Error(Errc::invalid_request, "/steps/0: too fast"); });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), cli::kProtocol);
  EXPECT_THAT(cli.err.str(), HasSubstr("/steps/0: too fast"));
}

TEST_F(Served, DetachReturnsAtOnce) {
  on_server([this] { handler.after_start = nullptr; });  // a run that does not end
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1", "--detach", "--json"}), 0);
  EXPECT_EQ(nlohmann::json::parse(cli.out.str())["run"], 7);
}

}  // namespace
}  // namespace lcrig
