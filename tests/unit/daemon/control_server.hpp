// SPDX-License-Identifier: Apache-2.0
// A control server on a socket of its own, and clients that can send anything. Used by the tests of
// the control socket.
#pragma once

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "daemon/control/server.hpp"
#include "tests/support/control_fixture.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {

// Drives `io` by itself, so a test needs no thread and no sleep.
class RawClient {
 public:
  RawClient(asio::io_context& io, const std::string& path) : io_(io) {
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    connected_ = ::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~RawClient() { ::close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool connected() const { return connected_; }
  void send(std::string_view bytes) {
    const auto end = deadline();
    while (!bytes.empty() && std::chrono::steady_clock::now() < end) {
      const auto n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
      if (n < 0 && errno != EAGAIN) return;  // the server hung up; the test looks at the answers
      pump();
    }
  }
  void half_close() { ::shutdown(fd_, SHUT_WR); }
  // Fails the test if no line comes.
  nlohmann::json read() {
    const auto end = deadline();
    for (;;) {
      if (const auto n = in_.find('\n'); n != std::string::npos) {
        auto message = nlohmann::json::parse(in_.substr(0, n));
        in_.erase(0, n + 1);
        return message;
      }
      if (!receive() || std::chrono::steady_clock::now() > end) break;
    }
    ADD_FAILURE() << "no answer; received so far: " << in_.substr(0, 200);
    return nlohmann::json::object();
  }
  nlohmann::json call(const std::string& line) {
    send(line + "\n");
    return read();
  }
  // True if the server closed the connection. What arrived before is discarded.
  bool sees_end() {
    const auto end = deadline();
    while (receive()) {
      in_.clear();
      if (std::chrono::steady_clock::now() > end) return false;
    }
    return true;
  }

 private:
  static std::chrono::steady_clock::time_point deadline() {
    return std::chrono::steady_clock::now() + std::chrono::seconds(20);
  }
  void pump() {
    io_.restart();
    io_.run_one_for(std::chrono::milliseconds(20));
    io_.poll();
  }
  bool receive() {  // false: end of file or reset
    pump();
    char buffer[65536];
    const auto n = ::recv(fd_, buffer, sizeof buffer, 0);
    if (n > 0) in_.append(buffer, static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EAGAIN);
  }

  asio::io_context& io_;
  int fd_ = -1;
  bool connected_ = false;
  std::string in_;
};

inline Task<bool> close_server(ControlServer& server, Duration grace) {
  co_await server.close(grace);
  co_return true;
}

class Control : public ::testing::Test {
 protected:
  void SetUp() override { start(ControlOptions()); }
  void TearDown() override {
    if (server) stop();
  }
  void start(const ControlOptions& options) {
    if (server) stop();
    server = std::make_unique<ControlServer>(io.get_executor(), clock, handler, options);
    const auto listening = server->listen(path);
    ASSERT_TRUE(listening) << listening.error().what;
  }
  void stop() {
    run_task(io, close_server(*server, std::chrono::seconds(2)));
    server.reset();
  }
  static std::string request(const std::string& method, const std::string& params = "{}") {
    return R"({"jsonrpc":"2.0","id":1,"method":")" + method + R"(","params":)" + params + "}";
  }

  TempDir dir;
  std::string path = dir.file("control.sock");
  asio::io_context io;
  RealClock clock;
  support::FakeHandler handler;
  std::unique_ptr<ControlServer> server;
};

}  // namespace lcrig
