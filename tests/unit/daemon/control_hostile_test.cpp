// SPDX-License-Identifier: Apache-2.0
// Garbage, floods, and clients that do not read: the server survives, and other clients are served.
#include "tests/support/hostile_texts.hpp"
#include "tests/unit/daemon/control_server.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::HasSubstr;

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
      {R"({"jsonrpc":"2.0","id":1,"method":"run.resume","params":{"confirm_specimen":true}})",
       -32602, "/params/confirm_specimen"},
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

// Copying such a value would recurse as deeply as the daemon's stack allows.
TEST_F(Control, TheStructureOfAMessageIsLimited) {
  RawClient client(io, path);
  const auto deep = std::string(400'000, '[') + std::string(400'000, ']');
  auto answer = client.call(request("run.start", deep));
  EXPECT_EQ(answer["error"]["code"], -32600);
  EXPECT_THAT(answer["error"]["message"].get<std::string>(), HasSubstr("16 objects and arrays"));
  std::string many = "[0";
  for (std::size_t i = 0; i < kControlValuesMax; ++i) many += ",0";
  answer = client.call(request("run.start", many + "]"));
  EXPECT_EQ(answer["error"]["code"], -32600);
  EXPECT_THAT(answer["error"]["message"].get<std::string>(), HasSubstr("more than 5000 values"));
  EXPECT_TRUE(handler.calls.empty());
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
  note.event = RunEvent(MonoTime(), EventKind::mark, "s", std::string(1000, 'x'));
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
  note.event = RunEvent(MonoTime(), EventKind::mark, "s", std::string(1'000'000, 'x'));
  for (int i = 0; i < 5; ++i) server->publish_event(note);  // more than a socket buffer holds
  const auto end = clock.now() + 20s;
  while (server->clients() > 0 && clock.now() < end) io.run_one_for(50ms);
  EXPECT_EQ(server->clients(), 0U);
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

// A call of more than 6000 bytes that the server holds up.
std::string long_start() {
  const nlohmann::json params{
      {"protocol", "p"}, {"specimen", "s"}, {"protocol_text", std::string(6'000, ' ')}};
  return request_line(1, "run.start", params);
}

TEST_F(Control, TooManyBytesOfCallsUnderWayAreRefused) {
  ControlOptions options;
  options.max_call_bytes = 10'000;
  start(options);
  handler.hold_start = true;
  RawClient client(io, path);
  client.send(long_start() + long_start());
  EXPECT_EQ(client.read()["error"]["code"], rpc_code::kTooManyCalls);
  RawClient other(io, path);
  EXPECT_TRUE(other.call(request("run.abort")).contains("result"));
  EXPECT_TRUE(client.read().contains("result")) << "the first one goes on";
}

TEST_F(Control, EveryHostileTextComesBackAsJson) {
  RawClient client(io, path);
  for (const auto& [name, text] : support::hostile_texts()) {
    handler.next_error = Error(Errc::refused, text);
    const nlohmann::json params{{"why", text.substr(0, 1000)}};
    client.send(request_line(1, "run.abort", params));
    const auto answer = client.read();
    EXPECT_EQ(answer["error"]["code"], -32004) << name;
    const auto message = answer["error"]["message"].get<std::string>();
    support::expect_harmless_on_a_terminal(message, 0, name);
    client.send(request_line(1, text.substr(0, 100'000), params));
    EXPECT_LT(client.read().dump().size(), 2'000U) << name;
  }
}

TEST_F(Control, TextsOfAPersonAreLimited) {
  RawClient client(io, path);
  const auto refused =
      client.call(request("run.abort", "{\"why\":\"" + std::string(kWhyMax + 1, 'x') + "\"}"));
  EXPECT_EQ(refused["error"]["code"], rpc_code::kInvalidParams);
  EXPECT_EQ(refused["error"]["message"], "/params/why: 2001 bytes, expected at most 2000");
  for (const char* key : {"operator", "specimen", "protocol", "note"}) {
    nlohmann::json params{{"protocol", "p"}, {"specimen", "s"}};
    params[key] = std::string(kNoteMax + 1, 'x');
    client.send(request_line(1, "run.start", params));
    EXPECT_EQ(client.read()["error"]["code"], rpc_code::kInvalidParams) << key;
  }
  EXPECT_EQ(client.call(request("run.freeze", R"({"why":"a\u0000b"})"))["error"]["message"],
            "/params/why: holds a NUL character");
  EXPECT_TRUE(handler.calls.empty());
}

// A line costs time of the thread that runs the instruments.
TEST_F(Control, LongLinesCountAsManyCalls) {
  ControlOptions options;
  options.burst = 5;
  options.calls_per_s = 200;
  start(options);
  RawClient client(io, path);
  const std::string line = std::string(100 * 4096, ' ') + "\n";  // nothing, at length
  const MonoTime begin = clock.now();
  client.send(line + request("status") + "\n");
  EXPECT_TRUE(client.read().contains("result"));
  EXPECT_GE(clock.now() - begin, 470ms);  // 97 calls beyond the burst, 5 ms each
}

TEST_F(Control, ManyClientsShareWhatEightMayAsk) {
  ControlOptions options;
  options.burst = 40;
  options.calls_per_s = 200;
  start(options);
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 15; ++i) {
    idle.push_back(std::make_unique<RawClient>(io, path));
    idle.back()->call(request("version"));
  }
  RawClient client(io, path);
  std::string flood;
  for (int i = 0; i < 40; ++i) flood += request("status") + "\n";
  const MonoTime begin = clock.now();
  client.send(flood);
  for (int i = 0; i < 40; ++i) EXPECT_TRUE(client.read().contains("result"));
  EXPECT_GE(clock.now() - begin, 195ms);  // 20 beyond half of the burst, at half of the rate
}

TEST_F(Control, TooManyBytesOfCallsOfAllClientsAreRefused) {
  ControlOptions options;
  options.max_all_call_bytes = 10'000;
  start(options);
  handler.hold_start = true;
  RawClient one(io, path);
  RawClient two(io, path);
  one.send(long_start());
  while (handler.calls.empty()) io.run_one_for(20ms);
  two.send(long_start());
  EXPECT_EQ(two.read()["error"]["code"], rpc_code::kTooManyCalls);
  EXPECT_TRUE(two.call(request("run.abort")).contains("result"));  // and lets the first one go on
  EXPECT_TRUE(one.read().contains("result"));
  two.send(long_start());
  EXPECT_TRUE(two.read().contains("result")) << "what is answered is no longer counted";
}

TEST(ControlAllowance, LongLinesOfAllClientsWaitForEachOtherAndShortOnesDoNot) {
  constexpr std::size_t kMiB = 1 << 20U;
  const MonoTime begin;
  ControlAllowance allowance(4 * kMiB, kMiB, begin);
  EXPECT_EQ(allowance.charge(kMiB, begin), Duration());
  EXPECT_EQ(allowance.charge(kMiB, begin), 250ms);
  EXPECT_EQ(allowance.charge(kMiB, begin), 500ms);
  EXPECT_EQ(allowance.charge(4096, begin), Duration());
  EXPECT_EQ(allowance.charge(kMiB, begin + 500ms), 250ms);
  EXPECT_EQ(allowance.charge(kMiB, begin + 1h), Duration()) << "no more than a line is saved up";
  EXPECT_EQ(allowance.charge(kMiB, begin + 1h), 250ms);
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

}  // namespace
}  // namespace lcrig
