// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "tests/unit/daemon/control_server.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(Control, EveryMethodReachesItsHandler) {
  RawClient client(io, path);
  client.call(request("run.pause"));
  client.call(request("run.resume"));
  const auto resumed = client.call(request("run.resume", R"({"run":12})"));
  client.call(request("run.resume", R"({"run":12,"confirm_specimen":true})"));
  client.call(request("run.abort", R"({"why":"smoke"})"));
  client.call(request("run.freeze", R"({"why":"look"})"));
  client.call(request("run.confirm"));
  const auto noted = client.call(request("run.note", R"({"run":3,"text":"dusty"})"));
  const auto tagged = client.call(request("run.tag", R"({"run":3,"tags":["a","b"]})"));
  client.call(request("run.tag", R"({"run":3,"tags":["a"],"remove":true})"));
  for (const char* wrong : {R"({"run":3,"tags":[]})", R"({"run":3,"tags":[1]})", R"({"run":3})",
                            R"({"tags":["a"]})", R"({"run":3,"tags":"a"})"}) {
    EXPECT_TRUE(client.call(request("run.tag", wrong)).contains("error")) << wrong;
  }
  const auto added = client.call(request("specimen.add", R"({"text":"{}"})"));
  handler.corrections.meter = "LCR-6100 A";
  handler.corrections.open.on = true;
  const auto corrected = client.call(request("lcr.correct", R"({"kind":"short"})"));
  client.call(request("lcr.show"));
  for (const char* wrong : {"{}", R"({"kind":"load"})", R"({"kind":1})"}) {
    EXPECT_TRUE(client.call(request("lcr.correct", wrong)).contains("error")) << wrong;
  }
  EXPECT_THAT(handler.calls,
              ElementsAre("pause", "resume present", "resume 12", "resume 12 confirmed",
                          "abort smoke", "freeze look", "confirm", "note 3 dusty", "tag 3 a b",
                          "untag 3 a", "specimen {}", "correct short", "look at corrections"));
  EXPECT_EQ(corrected["result"]["meter"], "LCR-6100 A");
  EXPECT_EQ(corrected["result"]["open"]["on"], true);
  EXPECT_TRUE(corrected["result"]["short"]["on"].is_null());
  EXPECT_EQ(tagged["result"]["tags"].dump(), R"(["a","b"])");
  EXPECT_EQ(noted["result"]["run"], 3);
  EXPECT_EQ(resumed["result"]["run"], 13) << "the run that goes on";
  EXPECT_EQ(added["result"]["name"], "paper-9");
  EXPECT_EQ(added["id"], 1);
  EXPECT_EQ(added["jsonrpc"], "2.0");
}

TEST_F(Control, AStartSaysWhoAsksAndWhoOperates) {
  RawClient client(io, path);
  const auto started = client.call(
      request("run.start", R"({"protocol":"creep","specimen":"s","parameters":{"force_N":0.5}})"));
  EXPECT_EQ(started["result"]["run"], 7);
  EXPECT_EQ(handler.last_peer.uid, ::getuid());
  EXPECT_EQ(handler.last_peer.pid, ::getpid());
  EXPECT_EQ(handler.last_start.operator_name, "") << "the handler knows the peer's name later";
  EXPECT_EQ(std::get<double>(handler.last_start.parameters.at("force_N")), 0.5);
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
  const auto& data = answer["error"]["data"];
  EXPECT_EQ(data["hint"], "lcrig status   (what goes on)");
  EXPECT_EQ(data["before"], "");
  EXPECT_EQ(data["command"], "lcrig status");
  EXPECT_EQ(data["remark"], "what goes on");
}

// Words alone contain no command that a client could complete.
TEST_F(Control, AHintWithoutACommandIsWordsAlone) {
  handler.next_error = Error(Errc::limit_tripped, "force");
  RawClient client(io, path);
  const auto answer = client.call(request("run.pause"));
  EXPECT_FALSE(answer["error"]["data"].contains("command"));
  EXPECT_THAT(answer["error"]["data"]["hint"].get<std::string>(), HasSubstr("a limit was reached"));
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
  note.event = RunEvent(MonoTime(5ns), EventKind::limit, "load", "force");
  server->publish_event(note);
  EXPECT_EQ(watcher.read()["params"]["kind"], "limit");
  server->publish_status(status);  // this is overtaken by the end
  RunOutcome ended;
  ended.run = 7;
  ended.exit_status = ExitStatus::abort;
  ended.code = Errc::limit_tripped;
  server->publish_run_ended(ended);
  const auto last = watcher.read();
  EXPECT_EQ(last["method"], "run_ended");
  EXPECT_EQ(last["params"]["code"], "limit_tripped");
  EXPECT_TRUE(bystander.call(request("status")).contains("result"));  // and nothing before it
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
  RunOutcome ended;
  ended.run = 3;
  ended.exit_status = ExitStatus::success;
  server->publish_run_ended(ended);
  stop();
  EXPECT_EQ(watcher.read()["params"]["run"], 3);
  EXPECT_TRUE(watcher.sees_end());
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace lcrig
