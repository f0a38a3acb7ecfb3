// SPDX-License-Identifier: Apache-2.0
// A control handler that remembers, and a raw client, for tests over a real Unix socket.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/control_handler.hpp"

namespace lcrig::support {

class TempDir {
 public:
  TempDir() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcrig-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    path_ = pattern;
  }
  ~TempDir() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

class FakeHandler : public ControlHandler {
 public:
  Task<Result<RunStarted>> start_run(StartRunRequest request, PeerCredentials peer) override {
    calls.push_back("start " + request.protocol + " by " + request.operator_name);
    last_start = request;
    last_peer = peer;
    while (hold_start) co_await clock.wait_for(std::chrono::milliseconds(1));
    if (next_error) co_return fail(*next_error);
    RunStarted started;
    started.run = 7;
    co_return started;
  }
  Task<Result<>> pause(PeerCredentials) override { co_return done("pause"); }
  Task<Result<>> resume(std::optional<std::int64_t> run, PeerCredentials) override {
    co_return done("resume " + (run ? std::to_string(*run) : std::string("present")));
  }
  Task<Result<>> abort(std::string why, PeerCredentials) override {
    hold_start = false;
    co_return done("abort " + why);
  }
  Task<Result<>> freeze(std::string why, PeerCredentials) override {
    co_return done("freeze " + why);
  }
  Task<Result<>> confirm(PeerCredentials) override { co_return done("confirm"); }
  Task<Result<std::string>> add_specimen(std::string text, PeerCredentials) override {
    calls.push_back("specimen " + text);
    if (next_error) co_return fail(*next_error);
    co_return std::string("paper-9");
  }
  DaemonStatus status() const override { return state; }

  std::vector<std::string> calls;
  StartRunRequest last_start;
  PeerCredentials last_peer;
  DaemonStatus state;
  std::optional<Error> next_error;
  bool hold_start = false;
  RealClock clock;

 private:
  Result<> done(std::string call) {
    calls.push_back(std::move(call));
    if (next_error) return fail(*next_error);
    return {};
  }
};

// Drives `io` by itself, so that a test needs no thread and no sleep.
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
      if (n < 0 && errno != EAGAIN) return;  // cut off by the server: the test looks at answers
      pump();
    }
  }
  void half_close() { ::shutdown(fd_, SHUT_WR); }
  // Fails the test when no line comes.
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
  // True when the server closed; what came before is thrown away.
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

}  // namespace lcrig::support
