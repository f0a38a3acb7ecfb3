// SPDX-License-Identifier: Apache-2.0
// Who gets a place at the control socket, and who gives it up: a stop is always taken.
#include <sys/resource.h>

#include <fstream>

#include "daemon/control/places.hpp"
#include "tests/unit/daemon/control_server.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

ControlPlace place_of(std::uint32_t uid, std::int32_t pid, Duration came, bool busy = false) {
  ControlPlace out;
  out.uid = uid;
  out.pid = pid;
  out.came = out.quiet_since = MonoTime(came);
  out.busy = busy;
  return out;
}

TEST(ControlPlaces, TheLongestIdleYieldsAndNobodyWhoWaitsOrJustCame) {
  const std::vector<ControlPlace> places{place_of(1, 1, 0s, true), place_of(1, 2, 5s),
                                         place_of(1, 3, 3s), place_of(1, 4, 9s)};
  EXPECT_EQ(longest_idle(places, MonoTime(10s), 1s), 2U);
  EXPECT_EQ(longest_idle(places, MonoTime(10s), 7s), 2U);
  EXPECT_EQ(longest_idle(places, MonoTime(10s), 8s), std::nullopt);
  EXPECT_EQ(longest_idle({}, MonoTime(10s), 0s), std::nullopt);
}

TEST(ControlPlaces, WhoHoldsMostYieldsFirst) {
  const auto mine = place_of(1000, 7, 0s);  // the first of all, and its user has one
  EXPECT_EQ(greediest(std::vector{mine, place_of(1001, 8, 2s), place_of(1001, 9, 1s)}), 2U);
  // Of the same user: the process with most.
  EXPECT_EQ(greediest(std::vector{mine, place_of(1000, 8, 3s), place_of(1000, 8, 2s)}), 2U);
  // Of the same process: one whose answer is under way is the last.
  EXPECT_EQ(greediest(std::vector{place_of(1, 1, 0s, true), place_of(1, 1, 1s)}), 1U);
  EXPECT_EQ(greediest(std::vector{mine}), 0U);
}

// Several clients in the places of a server with few.
class Places : public Control {
 protected:
  static ControlOptions few() {
    ControlOptions options;
    options.max_clients = 2;
    options.reserve = 4;
    options.idle = 20ms;
    options.reserve_patience = 20ms;
    return options;
  }
  void SetUp() override { start(few()); }
  RawClient& add() {
    clients.push_back(std::make_unique<RawClient>(io, path));
    return *clients.back();
  }
  void fill_with_watchers() {
    for (std::size_t i = 0; i < few().max_clients; ++i) add().call(request("watch"));
  }
  void pass(Duration time) {
    const MonoTime end = clock.now() + time;
    while (clock.now() < end) io.run_one_for(5ms);
  }
  nlohmann::json stop_anew(const char* method) {
    RawClient person(io, path);
    return person.call(request(method));
  }

  std::vector<std::unique_ptr<RawClient>> clients;
};

TEST_F(Places, TheLongestIdleClientYieldsToTheNext) {
  RawClient& first = add();
  first.call(request("status"));
  pass(25ms);
  RawClient& second = add();
  second.call(request("status"));
  RawClient third(io, path);
  EXPECT_TRUE(third.call(request("version")).contains("result"));
  EXPECT_EQ(first.read()["error"]["code"], rpc_code::kTooManyClients);
  EXPECT_TRUE(first.sees_end());
  EXPECT_TRUE(second.call(request("version")).contains("result"));
}

TEST_F(Places, AClientThatWaitsForItsAnswerDoesNotYield) {
  handler.hold_start = true;
  for (int i = 0; i < 2; ++i) {
    add().send(request("run.start", R"({"protocol":"p","specimen":"s"})") + "\n");
  }
  pass(40ms);
  EXPECT_EQ(handler.calls.size(), 2U);
  EXPECT_TRUE(stop_anew("run.abort").contains("result"));  // and lets them go on
  for (auto& client : clients) EXPECT_TRUE(client->read().contains("result"));
}

TEST_F(Places, WhenAllAreBusyOnlyStopsAndTheStatusAreTaken) {
  fill_with_watchers();
  RawClient person(io, path);
  const auto refused = person.call(request("run.start", R"({"protocol":"p","specimen":"s"})"));
  EXPECT_EQ(refused["error"]["code"], rpc_code::kTooManyClients);
  EXPECT_THAT(refused["error"]["data"]["hint"].get<std::string>(), HasSubstr("stop the run"));
  EXPECT_EQ(person.call(request("watch"))["error"]["code"], rpc_code::kTooManyClients);
  EXPECT_TRUE(person.call(request("status")).contains("result"));
  for (const char* method : {"run.abort", "run.freeze", "run.pause"}) {
    EXPECT_TRUE(stop_anew(method).contains("result")) << method;
  }
  const auto later = R"({"after":"level"})";
  RawClient other(io, path);
  EXPECT_TRUE(other.call(request("run.stop", later)).contains("result"));
  EXPECT_EQ(handler.calls.size(), 4U);
}

TEST_F(Places, WhoTakesAPlaceForStopsAndIsSilentLosesIt) {
  fill_with_watchers();
  RawClient silent(io, path);
  EXPECT_EQ(silent.read()["error"]["code"], rpc_code::kTooManyClients);
  EXPECT_TRUE(silent.sees_end());
  RawClient endless(io, path);
  endless.send(std::string(5000, 'x'));
  EXPECT_EQ(endless.read()["error"]["code"], rpc_code::kLineTooLong);
}

TEST_F(Places, AnyNumberOfConnectionsLeavesOneForAStop) {
  fill_with_watchers();
  for (int i = 0; i < 300; ++i) {
    RawClient& hostile = add();
    ASSERT_TRUE(hostile.connected());
    if (i % 3 == 0) hostile.send(request("status") + "\n");  // reads nothing
    if (i % 3 == 1) hostile.send("{");
    if (i % 50 != 0) continue;
    EXPECT_TRUE(stop_anew("run.abort").contains("result")) << i;
    EXPECT_LE(server->clients(), few().max_clients + few().reserve + 1);
  }
}

TEST_F(Places, AStopIsTakenFromBehindHundredsInTheBacklog) {
  fill_with_watchers();
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(add().connected());  // the server does not run yet
  EXPECT_TRUE(stop_anew("run.freeze").contains("result"));
  EXPECT_EQ(handler.calls.size(), 1U);
}

TEST_F(Places, AStopIsTakenWhereTooManyCallsAreUnderWay) {
  auto options = ControlOptions();
  options.max_calls = 1;
  options.max_all_call_bytes = 200;
  start(options);
  handler.hold_start = true;
  RawClient client(io, path);
  const auto long_start = request("run.start", R"({"protocol":"p","specimen":"s"})") + "\n";
  client.send(long_start + long_start);
  EXPECT_EQ(client.read()["error"]["code"], rpc_code::kTooManyCalls);
  client.send(request("run.abort") + "\n");
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(client.read().contains("result"));  // of both
  EXPECT_EQ(handler.calls.back(), "abort ");
}

// Every file that the process may open is open: an idle client has to give one back.
TEST_F(Places, AStopIsTakenWhereNoFileDescriptorIsLeft) {
  add().call(request("status"));
  pass(25ms);
  RawClient person(io, path);  // in the backlog
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const int lowest = ::dup(0);  // the lowest number that is free
  ASSERT_GE(lowest, 0);
  ::close(lowest);
  rlimit none = before;
  none.rlim_cur = static_cast<rlim_t>(lowest);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto answer = person.call(request("run.abort"));
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_TRUE(answer.contains("result")) << answer;
  EXPECT_TRUE(clients.front()->sees_end());
}

// The server in virtual time: it looks at its file once a second.
class SocketFile : public Control {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder);
    mine = std::make_unique<ControlServer>(io.get_executor(), virtual_clock, handler);
    ASSERT_TRUE(mine->listen(file));
  }
  void TearDown() override {
    bool closed = false;
    asio::co_spawn(io, close_server(*mine, 1s),
                   [&closed](const std::exception_ptr&, bool) { closed = true; });
    virtual_clock.run(io, [&closed] { return closed; });
    mine.reset();
    virtual_clock.run_for(io, 2s);
    EXPECT_EQ(virtual_clock.pending(), 0U);
  }
  void pass(Duration time) { virtual_clock.run_for(io, time); }
  bool answers() {
    RawClient client(io, file);
    return client.connected() && client.call(request("run.abort")).contains("result");
  }

  VirtualClock virtual_clock;
  std::string folder = dir.file("run"), file = folder + "/control.sock";
  std::unique_ptr<ControlServer> mine;
};

TEST_F(SocketFile, ThatIsDeletedComesBackAndWhoWasConnectedStays) {
  RawClient watcher(io, file);
  watcher.call(request("watch"));
  RawClient waiting(io, file);  // in the backlog
  std::filesystem::remove(file);
  pass(2s);
  EXPECT_EQ(mine->trouble(), "");
  EXPECT_TRUE(answers());
  struct stat info{};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777U, 0660U);
  EXPECT_TRUE(watcher.call(request("status")).contains("result"));
  EXPECT_TRUE(waiting.call(request("status")).contains("result"));
}

TEST_F(SocketFile, WhoseFolderVanishedIsReportedAndComesBackWithIt) {
  std::filesystem::remove_all(folder);
  pass(5s);
  EXPECT_EQ(mine->trouble(), file + " was deleted");
  std::filesystem::create_directory(folder);
  pass(2s);
  EXPECT_EQ(mine->trouble(), "");
  EXPECT_TRUE(answers());
}

TEST_F(SocketFile, OfAnotherDaemonIsNeverTaken) {
  std::filesystem::remove(file);
  ControlServer other(io.get_executor(), virtual_clock, handler);
  ASSERT_TRUE(other.listen(file));
  pass(10s);
  EXPECT_EQ(mine->trouble(), file + " was replaced by another file");
  EXPECT_EQ(other.trouble(), "");
  EXPECT_TRUE(answers());
  bool closed = false;
  asio::co_spawn(io, close_server(other, 1s),
                 [&closed](const std::exception_ptr&, bool) { closed = true; });
  virtual_clock.run(io, [&closed] { return closed; });
  EXPECT_FALSE(std::filesystem::exists(file));
  pass(2s);
  EXPECT_EQ(mine->trouble(), "");
  EXPECT_TRUE(answers());
}

TEST_F(SocketFile, ThatIsReplacedByNoSocketIsReportedAndTheFileIsKept) {
  std::filesystem::remove(file);
  std::ofstream(file) << "data";
  pass(10s);
  EXPECT_EQ(mine->trouble(), file + " was replaced by another file");
  EXPECT_EQ(std::filesystem::file_size(file), 4U);
  std::filesystem::remove(file);
  pass(2s);
  EXPECT_TRUE(answers());
}

// A daemon that starts has such a file for a moment, so the first look leaves it alone.
TEST_F(SocketFile, ThatIsReplacedByADeadSocketComesBackAtTheSecondLook) {
  std::filesystem::remove(file);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, file.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(fd);
  pass(1500ms);
  EXPECT_EQ(mine->trouble(), file + " was replaced by another file");
  pass(2s);
  EXPECT_EQ(mine->trouble(), "");
  EXPECT_TRUE(answers());
}

// A listener whose queue is full would hold up whoever waits to connect to it.
TEST_F(SocketFile, OfOneThatAcceptsNobodyHoldsUpNothing) {
  std::filesystem::remove(file);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, file.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(fd, 0), 0);
  RawClient first(io, file);  // fills the queue
  pass(10s);
  EXPECT_EQ(mine->trouble(), file + " was replaced by another file");
  ::close(fd);
}

}  // namespace
}  // namespace lcrig
