// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/rig.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "base/clock.hpp"

namespace lcrig::e2e {

namespace {

constexpr const char* kBench = R"({ "format": "bench/1", "name": "quick", "error_tolerance": 0.01,
  "fixture": { "probe_diameter_mm": 4.0 },
  "frame": { "contact_travel_mm": 0.3, "stiffness_N_mm": 200, "force_nominal_N": 20,
    "travel_min_mm": -20, "travel_max_mm": 20, "speed_max_mm_s": 10 },
  "meter": {} })";

// How long the threads of a process were ready but did not run. 0: the process has ended.
double waited_for_processor_s(pid_t pid) {
  double sum_ns = 0;
  std::error_code ended;
  const auto folder = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& thread : std::filesystem::directory_iterator(folder, ended)) {
    double ran_ns = 0, waited_ns = 0;
    std::ifstream(thread.path() / "schedstat") >> ran_ns >> waited_ns;
    sum_ns += waited_ns;
  }
  return sum_ns * 1e-9;
}

}  // namespace

NotifySocket::NotifySocket(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("bind " + path);
  }
}

NotifySocket::~NotifySocket() {
  ::close(fd_);
}

bool NotifySocket::wait(std::string_view word, Timeout timeout) const {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  std::array<char, 512> text;
  for (;;) {
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    if (left <= 0ms || !readable(fd_, left)) return false;
    const ssize_t n = ::recv(fd_, text.data(), text.size(), 0);
    if (n <= 0) return false;
    const std::string_view got(text.data(), static_cast<std::size_t>(n));
    if (got.find(word) != got.npos) return true;
  }
}

const char* const kQuickProtocol = R"({ "format": "load-protocol/1", "name": "quick",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05,
      "back_off_mm": 0.05, "timeout_s": 20 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.3 }, "speed_mm_s": 0.05,
      "overshoot_N": 0.1, "timeout_s": 20 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.2 }, "speed_mm_s": 1, "timeout_s": 20 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 1,
    "timeout_s": 20 } ] })";

const char* const kSlowProtocol = R"({ "format": "load-protocol/1", "name": "slow",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.5, "force_N": 0.05,
      "back_off_mm": 0.2, "timeout_s": 20 },
    { "id": "away", "do": "ramp", "to": { "gap_mm": 3.2 }, "speed_mm_s": 0.05,
      "timeout_s": 120 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 2,
    "timeout_s": 20 } ] })";

std::optional<json> Control::next(Timeout timeout) {
  const auto line = client_.next(timeout);
  if (!line) return std::nullopt;
  return json::parse(*line);
}

json Control::call(const std::string& method, const json& params) {
  const int id = ++id_;
  client_.send(json{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}.dump());
  while (auto message = next(20s)) {
    if (message->contains("id")) return *message;
    kept_.push_back(std::move(*message));
  }
  ADD_FAILURE() << "no answer to " << method;
  return json::object();
}

json Control::wait_for(const std::string& method, const std::function<bool(const json&)>& fits,
                       Timeout timeout) {
  const RealClock clock;
  const MonoTime limit = clock.now() + timeout;
  for (;;) {
    for (auto it = kept_.begin(); it != kept_.end(); ++it) {
      if (it->value("method", "") != method || !fits(it->at("params"))) continue;
      json found = it->at("params");
      kept_.erase(kept_.begin(), it + 1);
      return found;
    }
    kept_.clear();
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    auto message = left > 0ms ? next(left) : std::nullopt;
    if (!message) {
      ADD_FAILURE() << "no such `" << method << "` in " << timeout.count() << " ms";
      return json::object();
    }
    kept_.push_back(std::move(*message));
  }
}

json Control::run_ended(Timeout timeout) {
  return wait_for("run_ended", [](const json&) { return true; }, timeout);
}

std::vector<json> Control::listen(Timeout time) {
  const RealClock clock;
  const MonoTime limit = clock.now() + time;
  for (;;) {
    const auto left = std::chrono::duration_cast<Timeout>(limit - clock.now());
    auto message = left > 0ms ? next(left) : std::nullopt;
    if (!message) return std::exchange(kept_, {});
    kept_.push_back(std::move(*message));
  }
}

std::vector<json> Control::drain() {
  while (auto message = next(5s)) kept_.push_back(std::move(*message));
  return std::exchange(kept_, {});
}

json Ended::last_line() const {
  std::string text = out;
  while (text.ends_with('\n')) text.pop_back();
  const auto begin = text.rfind('\n');
  return json::parse(begin == std::string::npos ? text : text.substr(begin + 1), nullptr, false);
}

void Rig::SetUp() {
  begin_ = RealClock().now();
  machine_ = std::make_unique<StandstillWatch>();
  write("bench.json", kBench);
}

void Rig::TearDown() {
  if (sim_) waited_s_ += waited_for_processor_s(sim_->pid());
  for (const auto& daemon : daemons_) waited_s_ += waited_for_processor_s(daemon->pid());
  for (auto& daemon : daemons_) {
    daemon->signal(SIGTERM);
    EXPECT_TRUE(daemon->wait(20s)) << "lcrigd does not end on SIGTERM";
    if (HasFailure()) std::cerr << "--- lcrigd\n" << daemon->log();
  }
  if (sim_) {
    sim_->signal(SIGTERM);
    EXPECT_EQ(sim_->wait(10s), 0) << "lcrig-sim does not end well on SIGTERM";
    if (HasFailure()) std::cerr << "--- lcrig-sim\n" << sim_->log();
  }
  daemons_.clear();
  sim_.reset();
  EXPECT_TRUE(::waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD) << "a process is left";
  if (HasFailure()) tell_of_standstills();
  machine_.reset();
}

void Rig::tell_of_standstills() const {
  const MonoTime now = RealClock().now();
  const double stood_s = to_seconds(machine_->within(begin_, now));
  const double longest_s = to_seconds(machine_->longest()), all_s = to_seconds(now - begin_);
  std::cerr << "the machine stood still for " << stood_s << " of " << all_s << " s, at longest "
            << longest_s << " s; daemon and simulator waited " << waited_s_
            << " s for a processor\n";
}

void Rig::write(const std::string& name, const std::string& text) const {
  std::ofstream out(file(name));
  out << text;
}

void Rig::start_sim(const std::vector<std::string>& options) {
  std::vector<std::string> command{
      LCRIG_BIN "/lcrig-sim", "--bench",    file("bench.json"), "--control",
      file("sim.sock"),       "--lcr-link", file("lcr")};
  command.insert(command.end(), options.begin(), options.end());
  sim_ = std::make_unique<Child>(command, file("sim.log"));
  const auto line = sim_->out().next(20s);
  ASSERT_TRUE(line) << "lcrig-sim does not start: " << sim_->log();
  ports_ = json::parse(*line);
  back_door_ = std::make_unique<LineClient>(file("sim.sock"));
}

json Rig::sim(const std::string& command) {
  back_door_->send(command);
  const auto line = back_door_->next(15s);
  const json answer = line ? json::parse(*line) : json::object();
  EXPECT_TRUE(answer.value("ok", false)) << command << ": " << answer;
  return answer;
}

void Rig::wait_until_standing() {
  EXPECT_FALSE(sim("settle").value("moving", true)) << "the drive does not stop";
}

json Rig::config() const {
  const json rod{{"driver", "dead_weight"}};
  const json& port = ports_.at("frame");
  const json frame =
      port.is_null() ? rod : json{{"driver", "zwick"}, {"port", port}, {"stiffness_N_mm", 200}};
  return json{{"format", "lcrigd-config/1"},
              {"database", file("lcrig.db")},
              {"socket", file("control.sock")},
              {"meter", {{"driver", "lcr6100"}, {"port", file("lcr")}}},
              {"frame", frame},
              {"fixture", {{"probe_diameter_mm", 4.0}}}};
}

Child& Rig::launch_daemon(const json& config, const std::string& name, Child::Rights rights) {
  write(name + ".json", config.dump());
  const std::vector<std::string> command{LCRIG_BIN "/lcrigd", "--config", file(name + ".json")};
  Child::Variables variables = daemon_variables_;
  variables["NOTIFY_SOCKET"] = file(name + ".notify");
  daemons_.push_back(std::make_unique<Child>(command, file(name + ".log"), variables, rights));
  return *daemons_.back();
}

Child& Rig::start_daemon(const json& config, const std::string& name, Child::Rights rights) {
  const NotifySocket ready(file(name + ".notify"));
  Child& daemon = launch_daemon(config, name, rights);
  EXPECT_TRUE(ready.wait("READY=1", 20s)) << "lcrigd is not ready: " << daemon.log();
  ::unlink(file(name + ".notify").c_str());
  return daemon;
}

Ended Rig::lcrig(std::vector<std::string> arguments, Timeout timeout) {
  arguments.insert(arguments.begin(), LCRIG_BIN "/lcrig");
  return program(arguments, timeout);
}

Ended Rig::program(const std::vector<std::string>& command, Timeout timeout) {
  const Child::Variables variables{{"HOME", file("home")}};
  Child child(command, file("program" + std::to_string(++commands_) + ".log"), variables);
  Ended ended;
  ended.out = child.out().rest(timeout);
  ended.code = child.wait(timeout).value_or(-1);
  ended.err = child.log();
  return ended;
}

json Rig::start_run(Control& control, const std::string& protocol_text) const {
  return control.call(
      "run.start",
      json{{"protocol", "e2e"}, {"protocol_text", protocol_text}, {"specimen", "paper-1"}});
}

std::string Rig::query(const std::string& sql) const {
  auto db = open_read_only(file("lcrig.db"));
  if (!db) throw std::runtime_error(db.error().what);
  auto rows = db->prepare(sql);
  if (!rows) throw std::runtime_error(rows.error().what);
  std::string out;
  while (rows->step().value_or(false)) out += std::string(rows->text(0)) + "\n";
  return out;
}

void Rig::expect_losses_only_while_it_stood_still(const StandstillWatch& machine) const {
  std::istringstream losses(
      query("SELECT at_mono_ns || ' ' || detail FROM event WHERE kind = 'loss'"));
  std::string why;
  for (std::int64_t at = 0; losses >> at && std::getline(losses, why);) {
    const MonoTime then{Duration(at)};
    EXPECT_GE(machine.within(then - 1500ms, then), 300ms) << why;
  }
}

double Rig::number(const std::string& sql) const {
  return std::stod(query(sql));
}

}  // namespace lcrig::e2e
