// SPDX-License-Identifier: Apache-2.0
#include "daemon/control.hpp"
#include "base/decimal.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tests/support/control_fixture.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

Task<bool> close_server(ControlServer& server, Duration grace) {
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
    run_task(io, close_server(*server, 2s));
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

TEST_F(Control, EveryMethodReachesItsHandler) {
  RawClient client(io, path);
  client.call(request("run.pause"));
  client.call(request("run.resume"));
  const auto resumed = client.call(request("run.resume", R"({"run":12})"));
  client.call(request("run.resume", R"({"run":12,"confirm_specimen":true})"));
  client.call(request("run.abort", R"({"why":"smoke"})"));
  client.call(request("run.freeze", R"({"why":"look"})"));
  client.call(request("run.confirm"));
  const auto added = client.call(request("specimen.add", R"({"text":"{}"})"));
  EXPECT_THAT(handler.calls,
              ElementsAre("pause", "resume present", "resume 12", "resume 12 confirmed",
                          "abort smoke", "freeze look", "confirm", "specimen {}"));
  EXPECT_EQ(resumed["result"]["run"], 13) << "the run that goes on";
  EXPECT_EQ(added["result"]["name"], "paper-9");
  EXPECT_EQ(added["id"], 1);
  EXPECT_EQ(added["jsonrpc"], "2.0");
}

TEST_F(Control, TheOperatorOfARunIsThePeerUnlessNamed) {
  RawClient client(io, path);
  const auto started = client.call(
      request("run.start", R"({"protocol":"creep","specimen":"s","parameters":{"force_N":0.5}})"));
  EXPECT_EQ(started["result"]["run"], 7);
  EXPECT_EQ(handler.last_peer.uid, ::getuid());
  EXPECT_EQ(handler.last_peer.pid, ::getpid());
  EXPECT_FALSE(handler.last_start.operator_name.empty());
  EXPECT_EQ(handler.last_start.operator_name, handler.last_peer.user);
  EXPECT_EQ(handler.last_start.parameters.at("force_N"), "0.5");
  client.call(request("run.start", R"({"protocol":"creep","specimen":"s","operator":"Ada"})"));
  EXPECT_EQ(handler.last_start.operator_name, "Ada");
}

TEST_F(Control, AnErrorCarriesCodeMessageAndHint) {
  handler.next_error = Error(Errc::busy, "run 3 is going on");
  RawClient client(io, path);
  const auto answer = client.call(request("run.pause"));
  EXPECT_EQ(answer["error"]["code"], -32006);
  EXPECT_EQ(answer["error"]["message"], "run 3 is going on");
  EXPECT_EQ(answer["error"]["data"]["errc"], "busy");
  EXPECT_THAT(answer["error"]["data"]["hint"].get<std::string>(), HasSubstr("lcrig status"));
}

TEST_F(Control, BytesThatAreNoUtf8DoNotBreakAnAnswer) {
  handler.next_error = Error(Errc::garbled, "lcr0: IDN? -> \xff\xfe");
  RawClient client(io, path);
  EXPECT_EQ(client.call(request("run.pause"))["error"]["code"], -32003);
}

TEST_F(Control, WrongRequestsAreRefusedWithThePointerAndTheConnectionLives) {
  RawClient client(io, path);
  struct Case {
    const char* line;
    int code;
    const char* says;
  };
  const Case cases[] = {
      {"\x01\x02garbage", -32700, "not JSON"},
      {"{\"jsonrpc\":\"2.0\",", -32700, "not JSON"},
      {"{\"id\":1e999}", -32700, "not JSON"},
      {"\xff\xfe\xfd", -32700, "not JSON"},
      {"[]", -32600, "batches"},
      {"42", -32600, "object"},
      {R"({"id":1,"method":"status"})", -32600, "/jsonrpc"},
      {R"({"jsonrpc":"2.0","id":{},"method":"status"})", -32600, "/id"},
      {R"({"jsonrpc":"2.0","id":1,"method":3})", -32600, "/method"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.explode"})", -32601, "run.explode"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.abort","params":[]})", -32602, "/params"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.abort","params":{"why":3}})", -32602,
       "/params/why"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.abort","params":{"wy":"x"}})", -32602,
       "/params/wy"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.resume","params":{"run":1.5}})", -32602,
       "/params/run"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.start","params":{"specimen":"s"}})", -32602,
       "/params/protocol"},
      {R"({"jsonrpc":"2.0","id":1,"method":"run.start","params":)"
       R"({"protocol":"p","specimen":"s","parameters":{"a":[1]}}})",
       -32602, "/params/parameters/a"},
  };
  for (const auto& c : cases) {
    const auto answer = client.call(c.line);
    ASSERT_TRUE(answer.contains("error")) << c.line << " -> " << answer;
    EXPECT_EQ(answer["error"]["code"], c.code) << c.line;
    EXPECT_THAT(answer["error"]["message"].get<std::string>(), HasSubstr(c.says));
    EXPECT_FALSE(answer["error"]["data"]["hint"].get<std::string>().empty());
  }
  EXPECT_TRUE(handler.calls.empty());
  EXPECT_TRUE(client.call(request("status")).contains("result"));
}

TEST_F(Control, DeepNestingIsHarmless) {
  RawClient client(io, path);
  const auto deep = std::string(400'000, '[') + std::string(400'000, ']');
  EXPECT_EQ(client.call(deep)["error"]["code"], -32600);
  EXPECT_TRUE(client.call(request("version")).contains("result"));
}

TEST_F(Control, ATenMegabyteLineIsAnsweredAndTheClientCutOff) {
  RawClient hostile(io, path);
  hostile.send(std::string(10'000'000, 'x') + "\n");
  EXPECT_EQ(hostile.read()["error"]["code"], rpc_code::kLineTooLong);
  EXPECT_TRUE(hostile.sees_end());
  RawClient next(io, path);
  EXPECT_TRUE(next.call(request("status")).contains("result"));
}

TEST_F(Control, HalfAMessageIsDroppedAtEndOfFile) {
  RawClient client(io, path);
  client.send(R"({"jsonrpc":"2.0","id":1,"method":"run.abort")");
  client.half_close();
  EXPECT_TRUE(client.sees_end());
  EXPECT_TRUE(handler.calls.empty());
  EXPECT_EQ(server->clients(), 0U);
}

TEST_F(Control, AMessageInPiecesAndTwoInOnePieceAreBothUnderstood) {
  RawClient client(io, path);
  const auto line = request("run.pause") + "\r\n";
  for (const char c : line) client.send(std::string(1, c));
  EXPECT_TRUE(client.read().contains("result"));
  client.send(request("run.pause") + "\n\n" + request("run.confirm") + "\n");
  client.read();
  client.read();
  EXPECT_THAT(handler.calls, ElementsAre("pause", "pause", "confirm"));
}

TEST_F(Control, AHalfClosedClientStillGetsItsAnswer) {
  RawClient client(io, path);
  client.send(request("status") + "\n");
  client.half_close();
  EXPECT_TRUE(client.read().contains("result"));
  EXPECT_TRUE(client.sees_end());
}

TEST_F(Control, ANotificationIsObeyedAndNotAnswered) {
  RawClient client(io, path);
  client.send(R"({"jsonrpc":"2.0","method":"run.abort","params":{"why":"n"}})"
              "\n");
  EXPECT_EQ(client.call(request("run.confirm"))["id"], 1);  // the first line that comes back
  EXPECT_THAT(handler.calls, ElementsAre("abort n", "confirm"));
}

TEST_F(Control, AnAbortIsNotQueuedBehindAStartOfTheSameClient) {
  handler.hold_start = true;
  RawClient client(io, path);
  client.send(request("run.start", R"({"protocol":"p","specimen":"s"})") + "\n");
  client.send(R"({"jsonrpc":"2.0","id":2,"method":"run.abort","params":{}})"
              "\n");
  EXPECT_EQ(client.read()["id"], 2);
  EXPECT_EQ(client.read()["id"], 1);
}

TEST_F(Control, ACallSurvivesItsClient) {
  handler.hold_start = true;
  {
    RawClient client(io, path);
    client.send(request("run.start", R"({"protocol":"p","specimen":"s"})") + "\n");
    RawClient other(io, path);
    other.call(request("status"));
  }
  RawClient other(io, path);
  other.call(request("run.abort"));
  EXPECT_THAT(handler.calls, ElementsAre(HasSubstr("start p"), "abort "));
}

TEST_F(Control, AWatcherGetsStatusEventsAndTheEndInOrder) {
  RawClient watcher(io, path);
  RawClient bystander(io, path);
  watcher.call(request("watch"));
  bystander.call(request("status"));
  RunStatus status;
  status.run = 7;
  status.capacitance_F = 1.84249e-11;
  status.pressure_Pa = 12345.6;
  server->publish_status(status);
  const auto first = watcher.read();
  EXPECT_EQ(first["method"], "status");
  EXPECT_EQ(first["params"]["capacitance_pF"].dump(), "18.4249");
  EXPECT_EQ(first["params"]["pressure_kPa"].dump(), "12.3456");
  RunEventNote note;
  note.run = 7;
  note.event = RunEvent(MonoTime(5ns), "limit", "load", "force");
  server->publish_event(note);
  EXPECT_EQ(watcher.read()["params"]["kind"], "limit");
  server->publish_status(status);  // overtaken by the end
  RunEnded ended;
  ended.run = 7;
  ended.exit_status = "abort";
  ended.code = Errc::limit_tripped;
  server->publish_run_ended(ended);
  const auto last = watcher.read();
  EXPECT_EQ(last["method"], "run_ended");
  EXPECT_EQ(last["params"]["code"], "limit_tripped");
  EXPECT_TRUE(bystander.call(request("status")).contains("result"));  // and nothing before it
}

TEST_F(Control, ASlowWatcherSeesOnlyTheNewestStatus) {
  RawClient watcher(io, path);
  watcher.call(request("watch"));
  RunStatus status;
  for (int i = 1; i <= 1'000; ++i) {
    status.run = i;
    server->publish_status(status);  // the io_context does not run in between
  }
  EXPECT_EQ(watcher.read()["params"]["run"], 1'000);
}

TEST_F(Control, AWatcherThatNeverReadsIsCutOffAndTheOthersAreNot) {
  ControlOptions options;
  options.max_queue_bytes = 100'000;
  start(options);
  RawClient deaf(io, path);
  RawClient fine(io, path);
  deaf.call(request("watch"));
  RunEventNote note;
  note.event = RunEvent(MonoTime(), "mark", "s", std::string(1000, 'x'));
  for (int i = 0; i < 200; ++i) server->publish_event(note);
  EXPECT_TRUE(fine.call(request("status")).contains("result"));
  EXPECT_EQ(server->clients(), 1U);
  EXPECT_TRUE(deaf.sees_end());
}

TEST_F(Control, AClientThatTakesNoBytesIsCutOffAfterTheWriteTimeout) {
  ControlOptions options;
  options.write_timeout = 20ms;
  options.max_queue_bytes = 100'000'000;
  start(options);
  RawClient deaf(io, path);
  deaf.call(request("watch"));
  RunEventNote note;
  note.event = RunEvent(MonoTime(), "mark", "s", std::string(1'000'000, 'x'));
  for (int i = 0; i < 5; ++i) server->publish_event(note);  // more than a socket buffer holds
  const auto end = clock.now() + 20s;
  while (server->clients() > 0 && clock.now() < end) io.run_one_for(50ms);
  EXPECT_EQ(server->clients(), 0U);
}

TEST_F(Control, OneClientTooManyIsToldSo) {
  ControlOptions options;
  options.max_clients = 2;
  start(options);
  RawClient a(io, path);
  RawClient b(io, path);
  a.call(request("status"));
  b.call(request("status"));
  RawClient c(io, path);
  EXPECT_EQ(c.read()["error"]["code"], rpc_code::kTooManyClients);
  EXPECT_TRUE(c.sees_end());
  EXPECT_TRUE(a.call(request("status")).contains("result"));
}

TEST_F(Control, TooManyCallsOfOneClientAreRefused) {
  ControlOptions options;
  options.max_calls = 2;
  start(options);
  handler.hold_start = true;
  RawClient client(io, path);
  const auto line = request("run.start", R"({"protocol":"p","specimen":"s"})") + "\n";
  client.send(line + line + line);
  EXPECT_EQ(client.read()["error"]["code"], rpc_code::kTooManyCalls);
  RawClient other(io, path);
  EXPECT_TRUE(other.call(request("run.abort")).contains("result"));  // and lets the two go on
}

TEST_F(Control, AFloodIsReadSlowly) {
  ControlOptions options;
  options.burst = 5;
  options.calls_per_s = 200;
  start(options);
  RawClient client(io, path);
  std::string flood;
  for (int i = 0; i < 25; ++i) flood += request("status") + "\n";
  const MonoTime begin = clock.now();
  client.send(flood);
  for (int i = 0; i < 25; ++i) EXPECT_TRUE(client.read().contains("result"));
  EXPECT_GE(clock.now() - begin, 95ms);  // 20 calls beyond the burst, 5 ms each
}

TEST_F(Control, TheSocketIsForOwnerAndGroupOnly) {
  struct stat info{};
  ASSERT_EQ(::stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777U, 0660U);
}

TEST_F(Control, ASecondServerOnTheSamePathIsRefused) {
  ControlServer second(io.get_executor(), clock, handler);
  const auto listening = second.listen(path);
  ASSERT_FALSE(listening);
  EXPECT_EQ(listening.error().code, Errc::busy);
  EXPECT_THAT(listening.error().what, HasSubstr(path));
  RawClient client(io, path);
  EXPECT_TRUE(client.call(request("status")).contains("result"));
}

TEST_F(Control, ASocketLeftByACrashIsReplaced) {
  stop();
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(fd);  // the file stays, nobody answers
  start(ControlOptions());
  RawClient client(io, path);
  EXPECT_TRUE(client.call(request("status")).contains("result"));
}

TEST_F(Control, AFileThatIsNoSocketIsNeverRemoved) {
  const auto file = dir.file("precious");
  std::ofstream(file) << "data";
  ControlServer other(io.get_executor(), clock, handler);
  const auto listening = other.listen(file);
  ASSERT_FALSE(listening);
  EXPECT_EQ(listening.error().code, Errc::io);
  EXPECT_TRUE(std::filesystem::exists(file));
}

TEST_F(Control, APathTooLongForASocketIsRefused) {
  ControlServer other(io.get_executor(), clock, handler);
  const auto listening = other.listen(dir.file(std::string(200, 'p')));
  ASSERT_FALSE(listening);
  EXPECT_EQ(listening.error().code, Errc::invalid_request);
}

TEST_F(Control, CloseSendsWhatIsQueuedAndRemovesTheFile) {
  RawClient watcher(io, path);
  watcher.call(request("watch"));
  RunEnded ended;
  ended.run = 3;
  ended.exit_status = "success";
  server->publish_run_ended(ended);
  stop();
  EXPECT_EQ(watcher.read()["params"]["run"], 3);
  EXPECT_TRUE(watcher.sees_end());
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ControlMessages, EveryStructSurvivesTheWire) {
  DaemonStatus s;
  s.version = "1.2";
  s.database = "/x.db";
  s.instruments.resize(1);
  s.instruments[0].name = "lcr";
  s.instruments[0].state = "absent";
  s.run.emplace();
  s.run->run = 4;
  s.run->state = RunState::waiting_for_operator;
  s.run->prompt = "place 50 g";
  s.run->travel_m = -1.25e-4;
  s.last_run.emplace();
  s.last_run->exit_status = "fail";
  s.last_run->code = Errc::no_reply;
  const auto back = parse_daemon_status(json::parse(to_json(s).dump()));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(to_json(*back), to_json(s));
  EXPECT_EQ(back->run->travel_m, -1.25e-4);
  EXPECT_EQ(back->run->force_N, std::nullopt);
}

TEST(ControlMessages, AWrongTypeInAnAnswerIsGarbledAndNamed) {
  const auto back = parse_run_status(json::parse(R"({"run":1,"state":"flying"})"));
  ASSERT_FALSE(back);
  EXPECT_THAT(back.error().what, HasSubstr("/state"));
  EXPECT_FALSE(parse_run_status(json::parse(R"({"run":"1","state":"running"})")));
  EXPECT_FALSE(parse_run_ended(json::parse(R"([])")));
}

TEST(ControlMessages, ShiftingTheDecimalPointKeepsTheDigits) {
  EXPECT_EQ(json(shift_decimal(1.84249e-11, 12)).dump(), "18.4249");
  EXPECT_EQ(json(shift_decimal(3.6457e-12, 12)).dump(), "3.6457");
  EXPECT_EQ(shift_decimal(0, 12), 0);
  EXPECT_EQ(shift_decimal(-2.5e-3, 3), -2.5);
}

}  // namespace
}  // namespace lcrig
