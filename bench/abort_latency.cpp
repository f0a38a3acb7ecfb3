// SPDX-License-Identifier: Apache-2.0
// Measures how long an abort takes: from the message on the control socket to the frame's STOP on
// the wire, and to the answer (standstill confirmed). Also for a freeze in `finally`, and for an
// abort while a run is being prepared. Client, daemon and simulators (behind loopback TCP) run in
// real time in three threads. Then it measures the same for a SIGTERM to a separate lcrigd process,
// the program beside this one. With CROWDED also for a client that connects anew, while others take
// every place and more. Usage: abort_latency_bench [ABORTS [SIGTERMS [CROWDED]]]
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <thread>

#include "base/log.hpp"
#include "daemon/app.hpp"
#include "daemon/record/latency.hpp"
#include "drivers/fd_transport.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_file.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig {
namespace {

using asio::ip::tcp;
using nlohmann::json;

constexpr const char* kProtocol = R"({ "format": "load-protocol/1", "name": "abort-latency",
  "limits": { "force_N": [-1, 1], "travel_mm": [-20, 1] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "away", "do": "ramp", "to": { "travel_mm": -10 }, "speed_mm_s": 0.05,
    "timeout_s": 300 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -18 }, "speed_mm_s": 0.5,
    "timeout_s": 60 } ] })";

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().what);
  return std::move(*result);
}
template <class T>
T must(cli::Outcome<T> outcome) {
  if (!outcome) throw std::runtime_error(outcome.error().what);
  return std::move(*outcome);
}

// Records when an expected STOP arrives at the gateway.
class StopWatch final : public Transport {
 public:
  StopWatch(std::unique_ptr<Transport> inner, std::atomic<std::int64_t>& stop_ns)
      : inner_(std::move(inner)), stop_ns_(stop_ns) {}
  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override {
    auto n = co_await inner_->read_some(buffer, deadline);
    if (n && std::string_view(buffer.data(), *n).find("STOP\n") != std::string_view::npos) {
      std::int64_t none = 0;
      stop_ns_.compare_exchange_strong(none, clock_.now().time_since_epoch().count());
    }
    co_return n;
  }
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override {
    auto written = co_await inner_->write_all(bytes, deadline);
    co_return written;
  }
  void close() override { inner_->close(); }
  const std::string& name() const override { return inner_->name(); }

 private:
  std::unique_ptr<Transport> inner_;
  RealClock clock_;
  std::atomic<std::int64_t>& stop_ns_;
};

void rethrow(std::exception_ptr error) {
  if (error) std::rethrow_exception(error);
}

// Both instruments. Each serves one client at a time.
class Simulators {
 public:
  Simulators() : world_(make_world()), scene_(world_->plant()), meter_(io_), frame_(io_) {
    for (auto* acceptor : {&meter_, &frame_}) {
      acceptor->open(tcp::v4());
      acceptor->bind(tcp::endpoint(asio::ip::address_v4::loopback(), 0));
      acceptor->listen();
    }
    asio::co_spawn(io_, serve_meter(), rethrow);
    asio::co_spawn(io_, serve_frame(), rethrow);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Simulators() {
    io_.stop();
    thread_.join();
  }
  static std::string url(const tcp::acceptor& acceptor) {
    return fmt::format("tcp://127.0.0.1:{}", acceptor.local_endpoint().port());
  }
  std::string meter_url() const { return url(meter_); }
  std::string frame_url() const { return url(frame_); }

  std::atomic<std::int64_t> stop_ns{0};  // time of the first STOP since this was set to 0

 private:
  static std::unique_ptr<BenchWorld> make_world() {
    const ShippedSpecimen& first = shipped_specimens().front();
    const Specimen specimen = must(parse_specimen(first.text, std::string(first.name)));
    PlantConfig mounting;
    mounting.contact_travel_m = 5e-3;
    return must(
        BenchWorld::make(specimen, specimen.disc_diameter_m, 0.01, Force::from_si(2), mounting));
  }
  Task<std::unique_ptr<Transport>> next_client(tcp::acceptor& acceptor) {
    auto socket = co_await acceptor.async_accept(asio::use_awaitable);
    socket.set_option(tcp::no_delay(true));
    const int fd = socket.release();
    co_return std::make_unique<FdTransport>(io_.get_executor(), clock_, fd, "sim");
  }
  Task<> serve_meter() {
    for (;;) {
      auto wire = co_await next_client(meter_);
      const auto source = [this](MonoTime t) { return world_->plant().electrical(t); };
      lcr6100::Lcr6100Sim sim(std::move(wire), clock_, lcr6100::SimConfig(),
                              lcr6100::Lcr6100Sim::Source(source));
      co_await sim.run();
    }
  }
  Task<> serve_frame() {
    for (;;) {
      auto wire = co_await next_client(frame_);
      auto watch = std::make_unique<StopWatch>(std::move(wire), stop_ns);
      ZwickSim sim(std::move(watch), clock_, scene_);
      co_await sim.run();
    }
  }

  RealClock clock_;
  asio::io_context io_{1};
  std::unique_ptr<BenchWorld> world_;
  PlantScene scene_;
  tcp::acceptor meter_, frame_;
  std::thread thread_;
};

class Daemon {
 public:
  explicit Daemon(Config config) : app_(io_, clock_, std::move(config)) {
    if (auto started = app_.start(); !started) throw std::runtime_error(started.error().what);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Daemon() {
    asio::co_spawn(io_, end(), rethrow);
    thread_.join();
  }

 private:
  Task<> end() {
    co_await app_.shut_down("the bench is over");
    io_.stop();
  }
  RealClock clock_;
  asio::io_context io_{1};
  App app_;
  std::thread thread_;
};

class Client {
 public:
  explicit Client(const std::string& socket)
      : client_(must(cli::ControlClient::connect(socket, clock_))) {
    must(client_.call("watch", json::object()));
  }
  cli::Outcome<json> try_start() {
    const json run{
        {"protocol", "abort-latency"}, {"protocol_text", kProtocol}, {"specimen", "paper-1"}};
    return client_.call("run.start", run, std::chrono::seconds(60));
  }
  void start() {
    must(try_start());
    wait([](const cli::ControlNews& news) {
      const auto* status = std::get_if<RunStatus>(&news);
      return status != nullptr && status->step_id == "away" && status->lcr_readings > 0;
    });
  }
  struct Stop {
    MonoTime begin, answered;
    std::string state;
  };
  Stop stop(const char* method) {
    Stop out;
    out.begin = clock_.now();
    const json answer = must(client_.call(method, json{{"why", "bench"}}));
    out.answered = clock_.now();
    out.state = answer.value("state", "");
    return out;
  }
  void wait_for_end() {
    wait([](const cli::ControlNews& news) { return std::holds_alternative<RunOutcome>(news); });
  }
  // Waits, so that aborts come at any time between samples and conversions.
  void let_pass(int ms) { ::poll(nullptr, 0, ms); }

 private:
  template <class Wanted>
  void wait(Wanted wanted) {
    for (;;) {
      const auto news = must(client_.take());
      if (news && wanted(*news)) return;
      pollfd readable{client_.fd(), POLLIN, 0};
      if (!news && ::poll(&readable, 1, 20'000) <= 0) throw std::runtime_error("no news for 20 s");
    }
  }
  RealClock clock_;
  cli::ControlClient client_;
};

void print_row(const char* what, const LatencyHistogram& h) {
  const auto ms = [](Duration d) { return to_seconds(d) * 1e3; };
  fmt::print("{:<50} {:>8} {:>8.3f} {:>8.3f} {:>8.3f}\n", what, h.count(), ms(h.percentile(0.5)),
             ms(h.percentile(0.99)), ms(h.max()));
}

struct Latencies {
  LatencyHistogram to_stop, to_answer;
};

// Makes one stop that the frame has to confirm. False when the frame already stood.
bool stop_and_note(Simulators& sims, Client& client, const char* method, Latencies& l) {
  sims.stop_ns = 0;
  const auto stop = client.stop(method);
  if (sims.stop_ns == 0) return false;
  if (stop.state != "standing") throw std::runtime_error("not standing: " + stop.state);
  l.to_stop.add(Duration(sims.stop_ns) - stop.begin.time_since_epoch());
  l.to_answer.add(stop.answered - stop.begin);
  return true;
}

// One client starts a run, and another one aborts it before the run has begun.
void stop_a_start(const std::string& socket, Client& client, int after_ms, LatencyHistogram& l,
                  int& begun) {
  std::thread starter([&socket] { static_cast<void>(Client(socket).try_start()); });
  client.let_pass(after_ms);
  try {
    const auto stop = client.stop("run.abort");
    l.add(stop.answered - stop.begin);
    if (stop.state == "standing") {
      ++begun;
      client.wait_for_end();
    }
  } catch (const std::runtime_error&) {
    // The abort came before the start, when there was nothing to abort.
  }
  starter.join();
}

void measure(const std::string& folder, int aborts) {
  Simulators sims;
  Config config;
  config.database = folder + "/bench.db";
  config.socket = folder + "/bench.sock";
  config.log_level = "warn";
  config.meter_driver = std::ranges::find(kMeterDrivers, "lcr6100", &MeterDriver::name);
  config.meter_port = sims.meter_url();
  config.frame_port = sims.frame_url();
  const Daemon daemon(config);
  Client client(config.socket);
  Latencies step, clearing;
  LatencyHistogram preparing;
  std::mt19937 random(1);
  int over = 0;
  for (int i = 0; i < aborts; ++i) {
    client.start();
    client.let_pass(static_cast<int>(random() % 70));
    if (!stop_and_note(sims, client, "run.abort", step)) {
      throw std::runtime_error("no STOP arrived");
    }
    client.let_pass(static_cast<int>(100 + random() % 500));
    if (!stop_and_note(sims, client, "run.freeze", clearing)) ++over;
    client.wait_for_end();
  }
  int begun = 0;
  for (int i = 0; i < aborts; ++i) {
    stop_a_start(config.socket, client, static_cast<int>(1 + random() % 2500), preparing, begun);
  }
  fmt::print("{:<50} {:>8} {:>8} {:>8} {:>8}\n", "ms", "n", "p50", "p99", "max");
  print_row("abort to STOP at the gateway", step.to_stop);
  print_row("abort to answer (standstill)", step.to_answer);
  print_row("freeze in `finally` to STOP", clearing.to_stop);
  print_row("freeze in `finally` to answer", clearing.to_answer);
  print_row("abort in preparation to answer", preparing);
  fmt::print("{} of them had begun and were stopped before a step\n", begun);
  fmt::print("{} freezes came when `finally` was over\n", over);
}

// Starts and ends lcrigd as systemd does.
class DaemonProcess {
 public:
  explicit DaemonProcess(const std::string& config) {
    const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "lcrigd";
    pid_ = ::fork();
    if (pid_ != 0) return;
    ::execl(program.c_str(), "lcrigd", "--config", config.c_str(), "--log-level", "error", nullptr);
    ::_exit(127);
  }
  ~DaemonProcess() {
    if (pid_ > 0) ::kill(pid_, SIGKILL);
    end();
  }
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;
  void terminate() const { ::kill(pid_, SIGTERM); }
  int end() {
    int status = -1;
    if (pid_ > 0) ::waitpid(std::exchange(pid_, -1), &status, 0);
    return status;
  }

 private:
  pid_t pid_ = -1;
};

void write_config(const std::string& path, const std::string& folder, const Simulators& sims) {
  const json config{{"format", "lcrigd-config/1"},
                    {"database", folder + "/term.db"},
                    {"socket", folder + "/term.sock"},
                    {"meter", {{"driver", "lcr6100"}, {"port", sims.meter_url()}}},
                    {"frame", {{"driver", "zwick"}, {"port", sims.frame_url()}}},
                    {"fixture", {{"probe_diameter_mm", 4.0}}}};
  std::ofstream(path) << config.dump();
}

// The socket file exists a moment before the daemon listens.
void wait_for_daemon(const std::string& socket) {
  const RealClock clock;
  for (int i = 0; i < 2000; ++i) {
    if (cli::ControlClient::connect(socket, clock)) return;
    ::poll(nullptr, 0, 10);
  }
  throw std::runtime_error("lcrigd does not start");
}

void measure_sigterm(const std::string& folder, int signals) {
  Simulators sims;
  const RealClock clock;
  const std::string config = folder + "/term.json";
  write_config(config, folder, sims);
  LatencyHistogram to_stop, to_exit;
  std::mt19937 random(2);
  for (int i = 0; i < signals; ++i) {
    DaemonProcess daemon(config);
    wait_for_daemon(folder + "/term.sock");
    Client client(folder + "/term.sock");
    client.start();
    client.let_pass(static_cast<int>(random() % 70));
    sims.stop_ns = 0;
    const MonoTime begin = clock.now();
    daemon.terminate();
    if (daemon.end() != 0) throw std::runtime_error("lcrigd did not end well");
    if (sims.stop_ns == 0) throw std::runtime_error("no STOP arrived");
    to_stop.add(Duration(sims.stop_ns) - begin.time_since_epoch());
    to_exit.add(clock.now() - begin);
  }
  print_row("SIGTERM to STOP at the gateway", to_stop);
  print_row("SIGTERM to the end of lcrigd", to_exit);
}

// Clients who take every place, in a thread of their own.
enum class Crowd { idle, stalled, calling, connecting, backlog };
constexpr const char* kCrowdWords[] = {"64 idle", "64 stalled", "64 flooding with calls",
                                       "64 stalled, others connect and leave",
                                       "64 stalled, 400 more connections kept"};

class Crowded {
 public:
  Crowded(std::string socket, Crowd kind) : path_(std::move(socket)), kind_(kind) {
    const std::string watch = request_line(1, "watch", json::object());
    for (int i = 0; i < 64; ++i) {
      members_.push_back(open());
      if (kind != Crowd::idle) ::send(members_.back(), watch.data(), watch.size(), MSG_NOSIGNAL);
    }
    thread_ = std::thread([this] {
      while (!over_) act();
    });
  }
  ~Crowded() {
    over_ = true;
    thread_.join();
    for (const int fd : members_) ::close(fd);
  }
  Crowded(const Crowded&) = delete;
  Crowded& operator=(const Crowded&) = delete;

 private:
  // Not connected where the backlog is full.
  int open() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    static_cast<void>(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address));
    return fd;
  }
  void act() {
    switch (kind_) {
      case Crowd::idle:
      case Crowd::stalled: ::poll(nullptr, 0, 10); break;
      case Crowd::calling: call(); break;
      case Crowd::connecting: ::close(open()); break;
      case Crowd::backlog:
        members_.push_back(open());
        if (members_.size() < 464) break;
        ::close(members_[64]);
        members_.erase(members_.begin() + 64);
        break;
    }
  }
  void call() {
    const std::string text = request_line(1, "status", json::object());
    char buffer[65536];
    for (const int fd : members_) {
      ::send(fd, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      while (::recv(fd, buffer, sizeof buffer, MSG_DONTWAIT) > 0) {
      }
    }
  }

  std::string path_;
  Crowd kind_;
  std::vector<int> members_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

// From before the connection to the answer.
Duration stop_anew(const std::string& socket, const char* method) {
  const RealClock clock;
  const MonoTime begin = clock.now();
  auto person = must(cli::ControlClient::connect(socket, clock));
  must(person.call(method, json{{"why", "bench"}}));
  return clock.now() - begin;
}

// The daemon may still be taking leave of the crowd before.
Client connect_when_free(const std::string& socket) {
  for (int i = 0;; ++i) {
    try {
      return Client(socket);
    } catch (const std::runtime_error&) {
      if (i == 100) throw;
      ::poll(nullptr, 0, 50);
    }
  }
}

void measure_crowded(const std::string& folder, int stops) {
  Simulators sims;
  Config config;
  config.database = folder + "/crowd.db";
  config.socket = folder + "/crowd.sock";
  config.meter_driver = std::ranges::find(kMeterDrivers, "lcr6100", &MeterDriver::name);
  config.meter_port = sims.meter_url();
  config.frame_port = sims.frame_url();
  const Daemon daemon(config);
  std::mt19937 random(3);
  for (const Crowd kind :
       {Crowd::idle, Crowd::stalled, Crowd::calling, Crowd::connecting, Crowd::backlog}) {
    for (const char* method : {"run.abort", "run.freeze"}) {
      LatencyHistogram latency;
      for (int i = 0; i < stops; ++i) {
        Client owner = connect_when_free(config.socket);
        owner.start();
        const Crowded crowd(config.socket, kind);
        owner.let_pass(static_cast<int>(20 + random() % 70));
        latency.add(stop_anew(config.socket, method));
        owner.wait_for_end();
      }
      print_row(fmt::format("{}, {}", method, kCrowdWords[static_cast<int>(kind)]).c_str(),
                latency);
    }
  }
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  std::string folder = (std::filesystem::temp_directory_path() / "lcrig-bench-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) return 1;
  lcrig::set_up_logging("warn");
  int code = 0;
  try {
    lcrig::measure(folder, argc > 1 ? std::atoi(argv[1]) : 100);
    if (argc > 2) lcrig::measure_sigterm(folder, std::atoi(argv[2]));
    if (argc > 3) lcrig::measure_crowded(folder, std::atoi(argv[3]));
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    code = 1;
  }
  std::filesystem::remove_all(folder);
  return code;
}
