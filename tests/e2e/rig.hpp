// SPDX-License-Identifier: Apache-2.0
// A whole rig of processes in a folder of its own: lcrig-sim, lcrigd, lcrig.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "storage/database.hpp"
#include "tests/e2e/child.hpp"
#include "tests/e2e/standstill.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig::e2e {

using nlohmann::json;

// The daemon's control socket.
class Control {
 public:
  explicit Control(const std::string& socket) : client_(socket) {}
  // The whole answer; notifications that come before it are kept.
  json call(const std::string& method, const json& params = json::object());
  // The next notification of this method that `fits`, out of those not yet looked at. Fails the
  // test when none comes in time.
  json wait_for(const std::string& method, const std::function<bool(const json&)>& fits,
                Timeout timeout = 15s);
  json run_ended(Timeout timeout = 15s);
  // Everything that arrives within this time.
  std::vector<json> listen(Timeout time);
  // Everything that arrives until the daemon hangs up.
  std::vector<json> drain();

 private:
  std::optional<json> next(Timeout timeout);
  LineClient client_;
  std::vector<json> kept_;
  int id_ = 0;
};

// Where systemd would listen (sd_notify).
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path);
  ~NotifySocket();
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  // False: no message with this word in time.
  bool wait(std::string_view word, Timeout timeout) const;

 private:
  int fd_;
};

struct Ended {
  int code = -1;
  std::string out, err;
  json last_line() const;
};

class Rig : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;  // nothing may be left running

  std::string file(const std::string& name) const { return dir_.file(name); }
  void write(const std::string& name, const std::string& text) const;

  // lcrig-sim with the quick bench; its ports are in `ports` afterwards.
  void start_sim(const std::vector<std::string>& options = {});
  json sim(const std::string& command);  // on its back door
  void wait_until_standing();  // the simulated drive

  json config() const;  // of the ports that the simulator offered
  // Waits for READY=1. `name` tells several daemons apart.
  Child& start_daemon(const json& config, const std::string& name = "d1",
                      Child::Rights rights = Child::Rights::as_we_are);
  Child& launch_daemon(const json& config, const std::string& name,
                       Child::Rights rights = Child::Rights::as_we_are);  // does not wait
  Ended lcrig(std::vector<std::string> arguments, Timeout timeout = 30s);
  Control control() const { return Control(file("control.sock")); }

  // Through the socket; returns the answer.
  json start_run(Control& control, const std::string& protocol_text) const;
  // Of the database; a text with the rows' first columns, one a line.
  std::string query(const std::string& sql) const;
  double number(const std::string& sql) const;
  // An instrument that is there is not lost: every loss in the database needs a machine that stood
  // still just before it.
  void expect_losses_only_while_it_stood_still(const StandstillWatch& machine) const;

  json ports_;
  Child::Variables daemon_variables_;  // of the daemons started from now on
  std::unique_ptr<Child> sim_;
  std::vector<std::unique_ptr<Child>> daemons_;

 private:
  TempDir dir_;
  std::unique_ptr<LineClient> back_door_;
  int commands_ = 0;
};

// Contact at 0.3 mm; goes down fast to 0.3 N and up again. About 4 s.
extern const char* const kQuickProtocol;
// The same approach, then a ramp over a minute.
extern const char* const kSlowProtocol;

}  // namespace lcrig::e2e
