// SPDX-License-Identifier: Apache-2.0
// A directory service that does not answer holds up only those who wait for its answer.
#include "daemon/control/user_names.hpp"

#include <atomic>
#include <future>
#include <utility>

#include "tests/unit/daemon/control_server.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// Answers "ada" for everybody, once it is released.
class HangingDirectory {
 public:
  ~HangingDirectory() { release(); }
  void release() {
    if (!std::exchange(is_released_, true)) released_.set_value();
  }
  UserNames::Lookup lookup() {
    return [asked = asked, answers = answers_](std::uint32_t) -> std::optional<std::string> {
      ++*asked;
      answers.wait();
      return "ada";
    };
  }
  const std::shared_ptr<std::atomic<int>> asked = std::make_shared<std::atomic<int>>(0);

 private:
  bool is_released_ = false;
  std::promise<void> released_;
  std::shared_future<void> answers_ = released_.get_future().share();
};

TEST(UserNames, WhoAsksWaitsOnceAndThenTheUidHasToDo) {
  HangingDirectory directory;
  asio::io_context io;
  RealClock clock;
  UserNames names(io.get_executor(), clock, directory.lookup());
  EXPECT_EQ(run_task(io, names.find(1000, 30ms)), "uid 1000");
  const MonoTime begin = clock.now();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(run_task(io, names.find(1000, 30ms)), "uid 1000");
  EXPECT_LT(clock.now() - begin, 1s);
  directory.release();
  EXPECT_EQ(run_task(io, names.find(1000, 20s)), "ada");
  EXPECT_EQ(names.known(1000), "ada");
  EXPECT_EQ(*directory.asked, 1) << "one thread for each user";
}

TEST(UserNames, AThreadTakesNoVirtualTime) {
  asio::io_context io{1};
  VirtualClock clock;
  UserNames names(io.get_executor(), clock, [](std::uint32_t) { return "ada"; });
  EXPECT_EQ(run_task(io, clock, names.find(1000, 1ns)), "ada");
  EXPECT_EQ(clock.now(), MonoTime());
}

TEST(UserNames, AUserWithoutANameStaysTheUid) {
  asio::io_context io;
  RealClock clock;
  UserNames names(io.get_executor(), clock, [](std::uint32_t) { return std::nullopt; });
  EXPECT_EQ(run_task(io, names.find(77, 20s)), "uid 77");
  EXPECT_EQ(UserNames::of_system(0), "root");
}

TEST(UserNames, AnAnswerThatComesAfterTheEndIsNobodys) {
  HangingDirectory directory;
  asio::io_context io;
  RealClock clock;
  {
    UserNames names(io.get_executor(), clock, directory.lookup());
    names.look_up(1000);
  }
  directory.release();
  EXPECT_EQ(io.poll(), 0U);
}

TEST_F(Control, ADirectoryThatHangsDelaysNoClient) {
  HangingDirectory directory;
  ControlOptions options;
  options.user_name = directory.lookup();
  start(options);
  for (int i = 0; i < 3; ++i) {
    RawClient client(io, path);
    EXPECT_TRUE(client.call(request("run.abort")).contains("result"));
  }
  RawClient first(io, path);
  first.call(request("run.start", R"({"protocol":"creep","specimen":"s"})"));
  EXPECT_EQ(handler.last_peer.user, uid_words(::getuid()));
  directory.release();
  PeerCredentials peer;
  peer.uid = ::getuid();
  EXPECT_EQ(run_task(io, server->user_name(peer, 20s)), "ada");
  RawClient second(io, path);
  second.call(request("run.start", R"({"protocol":"creep","specimen":"s"})"));
  EXPECT_EQ(handler.last_peer.user, "ada");
}

}  // namespace
}  // namespace lcrig
