// SPDX-License-Identifier: Apache-2.0
// The whole daemon on a real socket in virtual time, among clients that do not read: the run goes
// on as without them, whoever reads is told in time, and memory stays bounded. And who asked for
// what stands in the run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "daemon/app.hpp"
#include "model/specimen_file.hpp"
#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "tests/support/hostile_texts.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ElementsAre;

// A client without an io_context: what the daemon sent lies in the socket until somebody takes it.
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

  void send(const std::string& line) {
    EXPECT_EQ(::send(fd_, line.data(), line.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(line.size()));
  }
  void call(const std::string& method, const json& params = json::object()) {
    send(request_line(++id_, method, params));
  }
  // What is there now.
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

constexpr const char* kProtocol = R"({ "format": "load-protocol/1", "name": "watched",
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

class Daemon : public testing::Test {
 protected:
  void SetUp() override {
    Config config;
    config.database = dir.file("d.db");
    config.socket = dir.file("d.sock");
    config.bench = "paper";
    app = std::make_unique<App>(io, clock, config);
    const auto started = app->start();
    ASSERT_TRUE(started) << started.error().what;
  }
  void TearDown() override {
    bool down = false;
    asio::co_spawn(io, app->shut_down("test"), [&](const std::exception_ptr&) { down = true; });
    EXPECT_TRUE(clock.run(io, [&] { return down; }));
    app.reset();
  }
  std::string socket_path() const { return dir.file("d.sock"); }
  // A text of 1000 characters in every mark, so that events soon fill a buffer.
  static json start_request() {
    std::string text = kProtocol;
    text.replace(text.find("LONG"), 4, std::string(1000, 'x'));
    return json{{"protocol", "watched"},
                {"protocol_text", text},
                {"specimen", "paper-1"},
                {"specimen_text", std::string(shipped_specimens().front().text)}};
  }
  // Pumps until `client` got a message that `wanted` likes.
  template <class Wanted>
  json wait_for(PlainClient& client, Wanted wanted) {
    json found;
    const MonoTime end = clock.now() + 10min;
    clock.run(io, [&] {
      for (const json& message : client.take()) {
        if (found.is_null() && wanted(message)) found = message;
      }
      return !found.is_null() || client.gone() || clock.now() > end;
    });
    EXPECT_FALSE(found.is_null());
    return found;
  }
  json answer(PlainClient& client, const std::string& method, const json& params = json::object()) {
    client.call(method, params);
    return wait_for(client, [](const json& m) { return m.contains("id"); });
  }
  std::int64_t count(const std::string& sql) const {
    return open_read_only(dir.file("d.db")).value().integer(sql).value();
  }
  std::vector<json> requests() const {
    const Database db = open_read_only(dir.file("d.db")).value();
    auto s = db.prepare("SELECT detail FROM event WHERE kind = 'request' ORDER BY seq").value();
    std::vector<json> out;
    while (s.step().value()) out.push_back(json::parse(s.text(0)));
    return out;
  }

  TempDir dir;
  VirtualClock clock;
  asio::io_context io{1};
  std::unique_ptr<App> app;
};

// What a client that reads saw of a run.
struct Seen {
  std::int64_t events = 0, statuses = 0;
  Duration longest_silence{};
  json ended;
  std::size_t clients = 0;  // at the end, itself included
};

class Watchers : public Daemon {
 protected:
  Seen watch_a_run(std::size_t stalled) {
    std::vector<std::unique_ptr<PlainClient>> deaf;
    for (std::size_t i = 0; i < stalled; ++i) {
      deaf.push_back(std::make_unique<PlainClient>(socket_path()));
      deaf.back()->call("watch");
    }
    PlainClient healthy(socket_path());
    healthy.call("watch");
    healthy.call("run.start", start_request());
    Seen seen;
    MonoTime last = clock.now();
    const MonoTime end = last + 1h;
    clock.run(io, [&] {
      for (const json& message : healthy.take()) take(message, seen, last);
      most_waiting = std::max(most_waiting, app->waiting_bytes());
      return !seen.ended.is_null() || healthy.gone() || clock.now() > end;
    });
    seen.clients = app->clients();
    return seen;
  }
  void take(const json& message, Seen& seen, MonoTime& last) {
    const std::string method = message.value("method", "");
    if (method == "event") ++seen.events;
    if (method == "status") {
      if (seen.statuses++ > 0) {
        seen.longest_silence = std::max(seen.longest_silence, clock.now() - last);
      }
      last = clock.now();
    }
    if (method == "run_ended") seen.ended = message["params"];
  }
  std::size_t most_waiting = 0;
};

TEST_F(Watchers, FiftyThatDoNotReadHoldUpNothing) {
  constexpr std::size_t kStalled = 50;
  const Seen alone = watch_a_run(0);
  const Seen among = watch_a_run(kStalled);
  ASSERT_FALSE(alone.ended.is_null());
  ASSERT_FALSE(among.ended.is_null());
  EXPECT_EQ(among.ended["exit_status"], "success") << among.ended;
  // The same bench, seed and protocol: the same run, to the reading and the nanosecond.
  for (const char* field : {"lcr_readings", "measure_readings", "frame_samples", "duration_s"}) {
    EXPECT_EQ(among.ended[field], alone.ended[field]) << field;
  }
  EXPECT_EQ(count("SELECT count(*) FROM lcr_reading WHERE run_id = 2"),
            count("SELECT count(*) FROM lcr_reading WHERE run_id = 1"));
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'lag'"), 0);
  // Whoever reads got every event, and a status ten times a second.
  EXPECT_EQ(among.events, count("SELECT count(*) FROM event WHERE run_id = 2"));
  EXPECT_EQ(among.statuses, alone.statuses);
  EXPECT_LE(among.longest_silence, 150ms);
  // Bounded, and those who took nothing for 10 s are gone.
  EXPECT_LE(most_waiting, (kStalled + 1) * (ControlOptions().max_queue_bytes + 4096));
  EXPECT_GT(most_waiting, 50 * 1000U) << "they were not stalled: the test shows nothing";
  EXPECT_EQ(among.clients, 1U);
}

TEST_F(Daemon, EveryRequestStandsInTheRunWithTheKernelsWordOnWhoAsked) {
  PlainClient client(socket_path());
  auto request = start_request();
  request["operator"] = "somebody else";
  ASSERT_TRUE(answer(client, "run.start", request).contains("result"));
  ASSERT_TRUE(answer(client, "run.pause").contains("result"));
  clock.run_for(io, 2s);
  ASSERT_TRUE(answer(client, "run.resume").contains("result"));
  ASSERT_TRUE(answer(client, "run.abort", {{"why", "=1+1\x1b[31m\n"}}).contains("result"));
  client.call("watch");
  wait_for(client, [](const json& m) {
    return m.value("method", "") == "run_ended" ||
           (m.contains("result") && m["result"]["run"].is_null());
  });
  const auto rows = requests();
  std::vector<std::string> kinds;
  for (const json& row : rows) {
    kinds.push_back(row["request"]);
    EXPECT_EQ(row["uid"], ::getuid());
    EXPECT_EQ(row["pid"], ::getpid());
    EXPECT_FALSE(row["user"].get<std::string>().empty());
  }
  EXPECT_THAT(kinds, ElementsAre("run.start", "run.pause", "run.resume", "run.abort"));
  EXPECT_EQ(rows.back()["why"], "=1+1\x1b[31m\n");
  EXPECT_TRUE(verify_chain(open_read_only(dir.file("d.db")).value(), 1).value().intact);
}

TEST_F(Daemon, TextsThatAreTooLongAreRefusedAndTheDaemonGoesOn) {
  PlainClient client(socket_path());
  for (const char* field : {"operator", "note", "specimen"}) {
    auto request = start_request();
    request[field] = std::string(100'000, 'x');
    const auto refused = answer(client, "run.start", request);
    ASSERT_TRUE(refused.contains("error")) << field;
    EXPECT_THAT(refused["error"]["message"].get<std::string>(),
                testing::StartsWith(std::string("/params/") + field + ": 100000 bytes"));
    EXPECT_EQ(refused["error"]["code"], rpc_code::kInvalidParams);
  }
  EXPECT_EQ(count("SELECT count(*) FROM run"), 0);
  EXPECT_TRUE(answer(client, "status").contains("result"));
}

}  // namespace
}  // namespace lcrig
