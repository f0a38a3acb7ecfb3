// SPDX-License-Identifier: Apache-2.0
// The command line, and a real control server in another thread. Used by the tests of commands that
// talk to a daemon.
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>

#include "daemon/control/server.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/control_fixture.hpp"

namespace lcrig::support {

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
  // Ends the run at once, so that `lcrig run` has something to follow.
  void end_run() {
    RunEventNote note;
    note.run = 7;
    note.event = RunEvent(MonoTime(), EventKind::mark, "load", "half way");
    server.publish_event(note);
    server.publish_run_ended(ended);
  }
  // Runs `f` in the server's thread, and waits for it.
  template <class F>
  void on_server(F f) {
    std::promise<void> done;
    asio::post(io, [&] {
      f();
      done.set_value();
    });
    done.get_future().wait();
  }

  Cli cli;
  std::string path = cli.dir.file("control.sock");
  asio::io_context io;
  asio::executor_work_guard<asio::io_context::executor_type> work = asio::make_work_guard(io);
  RealClock clock;
  FakeHandler handler;
  RunOutcome ended;
  ControlServer server{io.get_executor(), clock, handler};
  std::thread thread;
};

}  // namespace lcrig::support
