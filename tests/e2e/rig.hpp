// SPDX-License-Identifier: Apache-2.0
// A whole rig of processes in a temporary folder: lcrig-sim, lcrigd and lcrig. The fixture of all
// end-to-end tests.
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

// A client of the daemon's control socket.
class Control {
 public:
  explicit Control(const std::string& socket) : client_(socket) {}
  // Returns the whole answer. Notifications that arrive before it are kept.
  json call(const std::string& method, const json& params = json::object());
  // The next notification of this method that `fits`, including those kept. The test fails if none
  // comes in time.
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

// Listens in place of systemd (sd_notify).
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path);
  ~NotifySocket();
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  // False: no message with this word came in time.
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
  // Fails the test if a process is left. After a failed test it prints for how long the machine had
  // no processor for the test.
  void TearDown() override;

  std::string file(const std::string& name) const { return dir_.file(name); }
  void write(const std::string& name, const std::string& text) const;

  // Starts lcrig-sim with the quick bench and stores its ports in `ports_`. The meter's port there
  // is only to be looked at. Daemons open a link in this test's folder, which disappears with the
  // pty. The kernel gives the number of a closed pty to the next one that opens, which may belong
  // to another test.
  void start_sim(const std::vector<std::string>& options = {});
  json sim(const std::string& command);  // sends a command to the back door
  void wait_until_standing();  // waits for the simulated drive

  json config() const;  // with the ports that the simulator offers
  // Starts a daemon and waits for READY=1. `name` distinguishes several daemons.
  Child& start_daemon(const json& config, const std::string& name = "d1",
                      Child::Rights rights = Child::Rights::as_we_are);
  Child& launch_daemon(const json& config, const std::string& name,
                       Child::Rights rights = Child::Rights::as_we_are);  // does not wait
  Ended lcrig(std::vector<std::string> arguments, Timeout timeout = 30s);
  Ended program(const std::vector<std::string>& command, Timeout timeout = 30s);  // any program
  Control control() const { return Control(file("control.sock")); }

  // Starts a run through the socket and returns the answer.
  json start_run(Control& control, const std::string& protocol_text) const;
  // Queries the database. Returns the first column of each row, one per line.
  std::string query(const std::string& sql) const;
  double number(const std::string& sql) const;
  // Every loss in the database must follow a time in which the machine stood still, because the
  // instruments never disappeared.
  void expect_losses_only_while_it_stood_still(const StandstillWatch& machine) const;

  json ports_;
  Child::Variables daemon_variables_;  // for daemons that are started later
  std::unique_ptr<Child> sim_;
  std::vector<std::unique_ptr<Child>> daemons_;

 private:
  void tell_of_standstills() const;

  TempDir dir_;
  MonoTime begin_{};
  std::unique_ptr<StandstillWatch> machine_;
  double waited_s_ = 0;  // time for which daemon and simulator waited for a processor
  std::unique_ptr<LineClient> back_door_;
  int commands_ = 0;
};

// Contact at 0.3 mm; goes down fast to 0.3 N and up again. About 4 s.
extern const char* const kQuickProtocol;
// The same approach, then a ramp over a minute.
extern const char* const kSlowProtocol;

}  // namespace lcrig::e2e
