// SPDX-License-Identifier: Apache-2.0
// query_round_trip_bench [N]: times one query over a pty whose far end answers at once. It
// alternates between a bare write/poll/read loop and the driver stack (FdTransport, ScpiLink,
// reading parser), in real time. Prints queries/s and percentiles of both, and their ratio.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "drivers/lcr6100/codec.hpp"
#include "drivers/scpi.hpp"
#include "drivers/serial_transport.hpp"

namespace {

using namespace lcrig;

constexpr std::string_view kReading = "+1.84249e-12,+4.64627e-03,OUT ,AUX-NG,NG\r\n";
constexpr int kRounds = 10;  // alternating, so that a noisy machine disturbs both alike

// The far end. A thread of its own answers every line until the near end closes.
class InstantMeter {
 public:
  InstantMeter() {
    int slave = -1;
    std::array<char, 64> name{};
    termios raw{};
    ::cfmakeraw(&raw);
    if (::openpty(&master_, &slave, name.data(), &raw, nullptr) != 0) {
      throw std::runtime_error("openpty");
    }
    path_ = name.data();
    thread_ = std::thread([this, slave] { answer(slave); });
  }
  ~InstantMeter() {
    stop_ = true;
    thread_.join();
    ::close(master_);
  }
  const std::string& path() const { return path_; }

 private:
  void answer(int slave) {
    std::array<char, 256> buffer{};
    while (!stop_) {
      pollfd ready{master_, POLLIN, 0};
      if (::poll(&ready, 1, 50) <= 0) continue;
      const auto n = ::read(master_, buffer.data(), buffer.size());
      if (n <= 0) continue;
      const std::string_view got(buffer.data(), static_cast<std::size_t>(n));
      for (auto lines = std::count(got.begin(), got.end(), '\n'); lines > 0; --lines) {
        if (::write(master_, kReading.data(), kReading.size()) < 0) break;
      }
    }
    ::close(slave);
  }

  int master_ = -1;
  std::string path_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

std::vector<double> bare_loop(const std::string& path, int count) {
  const RealClock clock;
  const int fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::vector<double> out;
  std::array<char, 256> buffer{};
  for (int i = 0; i < count; ++i) {
    const MonoTime begin = clock.now();
    if (::write(fd, "*TRG\n", 5) != 5) throw std::runtime_error("write");
    for (std::size_t have = 0; have == 0 || buffer[have - 1] != '\n';) {
      pollfd ready{fd, POLLIN, 0};
      if (::poll(&ready, 1, 1000) <= 0) throw std::runtime_error("no answer");
      const auto n = ::read(fd, buffer.data() + have, buffer.size() - have);
      if (n <= 0) throw std::runtime_error("read");
      have += static_cast<std::size_t>(n);
    }
    out.push_back(to_seconds(clock.now() - begin));
  }
  ::close(fd);
  return out;
}

Task<> query_all(ScpiLink& link, Clock& clock, int count, std::vector<double>& out) {
  const std::string command = "*TRG";
  for (int i = 0; i < count; ++i) {
    const MonoTime begin = clock.now();
    auto reply = co_await link.query(command, std::chrono::seconds(1));
    if (!reply) throw std::runtime_error(reply.error().what);
    if (!lcr6100::parse_reading(reply->text)) throw std::runtime_error(reply->text);
    out.push_back(to_seconds(clock.now() - begin));
  }
}

std::vector<double> driver_stack(const std::string& path, int count) {
  asio::io_context io(1);
  RealClock clock;
  auto port = open_pty(path);
  if (!port) throw std::runtime_error(port.error().what);
  ScpiLink link(std::move(*port).to_transport(io.get_executor(), clock), clock);
  std::vector<double> out;
  asio::co_spawn(io, query_all(link, clock, count, out), [](std::exception_ptr e) {
    if (e) std::rethrow_exception(e);
  });
  io.run();
  return out;
}

struct Figures {
  double per_s = 0, p50_us = 0, p99_us = 0;
};

Figures figures(std::vector<double> seconds) {
  double sum = 0;
  for (const double s : seconds) sum += s;
  std::sort(seconds.begin(), seconds.end());
  const std::size_t n = seconds.size();
  Figures f;
  f.per_s = static_cast<double>(n) / sum;
  f.p50_us = seconds[n / 2] * 1e6;
  f.p99_us = seconds[n * 99 / 100] * 1e6;
  return f;
}

void print(const char* name, const Figures& f) {
  fmt::print("{:<14}{:>12.0f}{:>10.1f}{:>10.1f}\n", name, f.per_s, f.p50_us, f.p99_us);
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 50'000;
  const InstantMeter meter;
  std::vector<double> bare, stack;
  for (int round = 0; round < kRounds; ++round) {
    const auto a = bare_loop(meter.path(), count / kRounds);
    bare.insert(bare.end(), a.begin(), a.end());
    const auto b = driver_stack(meter.path(), count / kRounds);
    stack.insert(stack.end(), b.begin(), b.end());
  }
  const Figures a = figures(bare), b = figures(stack);
  fmt::print("{:<14}{:>12}{:>10}{:>10}\n", "", "queries/s", "p50 us", "p99 us");
  print("bare loop", a);
  print("driver stack", b);
  fmt::print("{:<14}{:>12.2f}{:>10.2f}{:>10.2f}\n", "stack / bare", a.per_s / b.per_s,
             b.p50_us / a.p50_us, b.p99_us / a.p99_us);
}
