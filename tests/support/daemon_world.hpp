// SPDX-License-Identifier: Apache-2.0
// The whole daemon on a real socket in virtual time, and a plain client, for scenario tests.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/app.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig::support {

using nlohmann::json;

// A client without an io_context. Messages of the daemon stay in the socket until take().
class PlainClient {
 public:
  explicit PlainClient(const std::string& path) {
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~PlainClient() { ::close(fd_); }
  PlainClient(const PlainClient&) = delete;
  PlainClient& operator=(const PlainClient&) = delete;

  // Sends as much as the socket takes now, and returns the rest.
  std::string_view push(std::string_view bytes) {
    while (!bytes.empty()) {
      const auto n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) break;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return bytes;
  }
  void send(const std::string& line) {
    EXPECT_EQ(::send(fd_, line.data(), line.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(line.size()));
  }
  void call(const std::string& method, const json& params = json::object()) {
    send(request_line(++id_, method, params));
  }
  // All complete messages that have arrived.
  std::vector<json> take() {
    char buffer[65536];
    for (;;) {
      const auto n = ::recv(fd_, buffer, sizeof buffer, 0);
      if (n <= 0) {
        gone_ = n == 0;
        break;
      }
      in_.append(buffer, static_cast<std::size_t>(n));
    }
    std::vector<json> out;
    for (auto end = in_.find('\n'); end != std::string::npos; end = in_.find('\n')) {
      out.push_back(json::parse(in_.substr(0, end)));
      in_.erase(0, end + 1);
    }
    return out;
  }
  bool gone() const { return gone_; }

 private:
  int fd_ = -1;
  std::int64_t id_ = 0;
  std::string in_;
  bool gone_ = false;
};

inline constexpr const char* kWatchedProtocol = R"({ "format": "load-protocol/1", "name": "watched",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "loop", "do": "repeat", "count": 20, "steps": [
      { "id": "load", "do": "ramp", "to": { "force_N": 0.4 }, "force_rate_N_s": 0.5, "timeout_s": 60 },
      { "id": "often", "do": "repeat", "count": 10, "steps": [
        { "id": "say", "do": "mark", "text": "LONG" } ] },
      { "id": "level", "do": "measure", "count": 10, "within_s": 4 },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

class DaemonWorld : public testing::Test {
 protected:
  void SetUp() override { start("d.db"); }
  void TearDown() override { stop(); }
  virtual AppParts parts() { return AppParts(); }
  virtual void configure(Config& /*config*/) {}
  void start(const std::string& database) {
    database_ = dir.file(database);
    Config config;
    config.database = database_;
    config.socket = socket_path();
    config.bench = "paper";
    configure(config);
    app = std::make_unique<App>(io, clock, config, parts());
    const auto started = app->start();
    ASSERT_TRUE(started) << started.error().what;
  }
  void stop() {
    bool down = false;
    asio::co_spawn(io, app->shut_down("test"),
                   [&](const std::exception_ptr&, bool) { down = true; });
    // All tasks must have ended, as in `main`.
    EXPECT_TRUE(clock.run(io, [&] { return down && clock.pending() == 0; }));
    io.poll();
    app.reset();
  }
  std::string socket_path() const { return dir.file("d.sock"); }
  // Each mark has a text of 1000 characters, so that events soon fill a buffer.
  static json start_request(const std::string& protocol = kWatchedProtocol) {
    std::string text = protocol;
    if (const auto at = text.find("LONG"); at != std::string::npos) {
      text.replace(at, 4, std::string(1000, 'x'));
    }
    return json{{"protocol", "watched"},
                {"protocol_text", text},
                {"specimen", "paper-1"},
                {"specimen_text", std::string(shipped_specimens().front().text)}};
  }
  // Runs the daemon until `client` receives a message for which `wanted` is true.
  template <class Wanted>
  json wait_for(PlainClient& client, Wanted wanted) {
    json found;
    const MonoTime end = clock.now() + std::chrono::minutes(10);
    clock.run(io, [&] {
      for (const json& message : client.take()) {
        if (found.is_null() && wanted(message)) found = message;
      }
      return !found.is_null() || client.gone() || clock.now() > end;
    });
    EXPECT_FALSE(found.is_null());
    return found;
  }
  json wait_for_end(PlainClient& client) {
    const json ended =
        wait_for(client, [](const json& m) { return m.value("method", "") == "run_ended"; });
    return ended.is_null() ? json() : ended["params"];
  }
  // Lets time pass while the client reads. A client that does not read would be disconnected.
  void pass(PlainClient& client, Duration time) {
    const MonoTime end = clock.now() + time;
    clock.run(io, [&] {
      client.take();
      return clock.now() >= end;
    });
  }
  json answer(PlainClient& client, const std::string& method, const json& params = json::object()) {
    client.call(method, params);
    return wait_for(client, [](const json& m) { return m.contains("id"); });
  }
  std::int64_t count(const std::string& sql) const {
    return open_read_only(database_).value().integer(sql).value();
  }
  std::vector<json> requests() const {
    const Database db = open_read_only(database_).value();
    auto s =
        db.prepare("SELECT detail FROM event WHERE kind = 'request' ORDER BY run_id, seq").value();
    std::vector<json> out;
    while (s.step().value()) out.push_back(json::parse(s.text(0)));
    return out;
  }

  TempDir dir;
  VirtualClock clock;
  asio::io_context io{1};
  std::unique_ptr<App> app;

 private:
  std::string database_;
};

}  // namespace lcrig::support
