// SPDX-License-Identifier: Apache-2.0
// The whole daemon on a real socket in virtual time, with clients that do not read. The run is the
// same as without them, clients that read are told in time, and memory stays bounded.
#include "tests/support/daemon_world.hpp"

#include <algorithm>
#include <deque>
#include <functional>
#include <utility>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;

// The messages of a run that a reading client received.
struct Seen {
  std::int64_t events = 0, statuses = 0;
  Duration longest_silence{};
  json ended;
  std::size_t clients = 0;  // at the end, including itself
};

class Watchers : public support::DaemonWorld {
 protected:
  // `meanwhile` is called whenever the daemon has nothing to do.
  Seen watch_a_run(std::size_t stalled, const std::function<void()>& meanwhile = [] {}) {
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
      meanwhile();
      most_held = std::max(most_held, app->control().held_bytes());
      most_waiting = std::max(most_waiting, app->control().waiting_bytes());
      return !seen.ended.is_null() || healthy.gone() || clock.now() > end;
    });
    seen.clients = app->control().clients();
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
  // With the same bench, seed and protocol, the run must be the same in every reading and
  // nanosecond.
  void expect_same_run(const Seen& among, const Seen& alone) const {
    EXPECT_EQ(among.ended["exit_status"], "success") << among.ended;
    for (const char* field : {"lcr_readings", "measure_readings", "frame_samples", "duration_s"}) {
      EXPECT_EQ(among.ended[field], alone.ended[field]) << field;
    }
    EXPECT_EQ(count("SELECT count(*) FROM lcr_reading WHERE run_id = 2"),
              count("SELECT count(*) FROM lcr_reading WHERE run_id = 1"));
    EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'lag'"), 0);
    // A reading client got every event that is shown, and a status ten times a second.
    EXPECT_EQ(among.events,
              count(std::string("SELECT count(*) FROM event WHERE run_id = 2 AND ") + kIsShown));
    EXPECT_LE(among.longest_silence, 150ms);
  }
  std::size_t most_waiting = 0, most_held = 0;
};

TEST_F(Watchers, FiftyThatDoNotReadHoldUpNothing) {
  constexpr std::size_t kStalled = 50;
  const Seen alone = watch_a_run(0);
  const Seen among = watch_a_run(kStalled);
  ASSERT_FALSE(alone.ended.is_null());
  ASSERT_FALSE(among.ended.is_null());
  expect_same_run(among, alone);
  EXPECT_EQ(among.statuses, alone.statuses);
  // Memory is bounded, and clients that took nothing for 10 s are disconnected.
  EXPECT_LE(most_waiting, (kStalled + 1) * (ControlOptions().max_queue_bytes + 4096));
  EXPECT_GT(most_waiting, 50 * 1000U) << "they were not stalled: the test shows nothing";
  EXPECT_EQ(among.clients, 1U);
}

// As many clients as are allowed beside the one that is served. All of them send the longest lines
// as fast as they can, and read nothing.
class Flood {
 public:
  Flood(const std::string& path, std::size_t clients) {
    for (std::size_t i = 0; i < clients; ++i) {
      clients_.push_back(std::make_unique<PlainClient>(path));
      bytes_.push_back(text_of(i % 3));
      left_.emplace_back(bytes_.back());
    }
  }
  void push() {
    for (std::size_t i = 0; i < clients_.size(); ++i) left_[i] = clients_[i]->push(left_[i]);
  }
  bool is_sent() const {
    return std::ranges::all_of(left_, [](std::string_view left) { return left.empty(); });
  }

 private:
  static std::string text_of(std::size_t kind) {
    if (kind == 0) return std::string(kControlLineLimit, 'x');  // never ends
    json params{{"protocol", "p"}, {"specimen", "s"}};
    params["protocol_text"] = std::string(kControlLineLimit - 200, ' ');
    std::string line = request_line(1, "run.start", params);
    if (kind == 2) {
      const std::string deep(kControlLineLimit / 2 - 200, '[');
      line = R"({"jsonrpc":"2.0","id":1,"method":"status","params":)" + deep + "\n";
    }
    return line + line;
  }

  std::vector<std::unique_ptr<PlainClient>> clients_;
  std::deque<std::string> bytes_;  // addresses must not change
  std::vector<std::string_view> left_;
};

TEST_F(Watchers, AsManyAsMayComeWhoSendTheLongestLinesHoldUpNothing) {
  const ControlOptions options;
  const Seen alone = watch_a_run(0);
  ASSERT_FALSE(alone.ended.is_null());
  Flood flood(socket_path(), options.max_clients - 1);
  const Seen among = watch_a_run(0, [&] { flood.push(); });
  ASSERT_FALSE(among.ended.is_null());
  expect_same_run(among, alone);
  EXPECT_TRUE(flood.is_sent()) << "what a client may send, it must get rid of";
  EXPECT_EQ(among.clients, options.max_clients);
  constexpr std::size_t kOfOne = kControlLineLimit + 16384;  // one line, and what is read at once
  EXPECT_LE(most_held, options.max_clients * kOfOne + options.max_all_call_bytes);
  EXPECT_GT(most_held, (options.max_clients - 1) / 2 * kOfOne) << "the test shows nothing";
  EXPECT_LE(most_waiting, options.max_clients * (options.max_queue_bytes + 4096));
}

TEST_F(Watchers, AnAbortAmongThemIsObeyedAtOnce) {
  PlainClient person(socket_path());
  ASSERT_TRUE(answer(person, "run.start", start_request()).contains("result"));
  Flood flood(socket_path(), ControlOptions().max_clients - 1);
  const MonoTime begun = clock.now();
  clock.run(io, [&] {
    flood.push();
    return clock.now() > begun + 2s;
  });
  EXPECT_FALSE(flood.is_sent()) << "the flood is over: the test shows nothing";
  const MonoTime asked = clock.now();
  EXPECT_TRUE(answer(person, "run.abort").contains("result"));
  EXPECT_LE(clock.now() - asked, 500ms) << "the samples have to agree before it is called stopped";
  const auto stopped = count(
      "SELECT min(at_mono_ns) FROM event WHERE kind = 'stopped' AND "
      "at_mono_ns >= " +
      std::to_string(asked.time_since_epoch().count()));
  EXPECT_LE(MonoTime(Duration(stopped)) - asked, 100ms);
}

// Clients who take every place and more, and do not give it back.
class Crowd {
 public:
  virtual ~Crowd() = default;
  virtual void act(MonoTime /*now*/) {}  // whenever the daemon has nothing to do
};

class Idle : public Crowd {
 public:
  explicit Idle(const std::string& path) {
    for (int i = 0; i < 64; ++i) clients_.push_back(std::make_unique<PlainClient>(path));
  }

 protected:
  std::vector<std::unique_ptr<PlainClient>> clients_;
};

// They watch, and never read.
class Stalled : public Idle {
 public:
  explicit Stalled(const std::string& path) : Idle(path) {
    for (auto& client : clients_) client->call("watch");
  }
};

// They watch, read, and call as fast as they are read.
class Calling : public Idle {
 public:
  explicit Calling(const std::string& path) : Idle(path) {
    for (auto& client : clients_) client->call("watch");
  }
  void act(MonoTime now) override {
    if (now == std::exchange(last_, now)) return;  // they may call 25 times a second each
    for (auto& client : clients_) {
      client->push(text_);
      client->take();
    }
  }

 private:
  const std::string text_ = request_line(1, "status", json::object());
  MonoTime last_;
};

class LongLines : public Crowd {
 public:
  explicit LongLines(const std::string& path) : flood_(path, 64) {}
  void act(MonoTime /*now*/) override { flood_.push(); }

 private:
  Flood flood_;
};

// 64 watch, 300 more are open at any time, of which 20 are closed for new ones whenever time
// passes.
class Connections : public Stalled {
 public:
  explicit Connections(const std::string& path) : Stalled(path), path_(path) {
    for (int i = 0; i < 300; ++i) open();
  }
  void act(MonoTime now) override {
    if (now == std::exchange(last_, now)) return;  // what is opened has to be taken
    for (int i = 0; i < 20; ++i) {
      others_.pop_front();
      open();
    }
  }

 private:
  void open() {
    others_.push_back(std::make_unique<PlainClient>(path_));
    if (others_.size() % 2 == 0) others_.back()->call("status");
  }
  std::string path_;
  MonoTime last_;
  std::deque<std::unique_ptr<PlainClient>> others_;
};

template <class Kind>
std::unique_ptr<Crowd> make_crowd(const std::string& path) {
  return std::make_unique<Kind>(path);
}
struct CrowdKind {
  const char* name;
  std::unique_ptr<Crowd> (*make)(const std::string& path);
};
constexpr CrowdKind kCrowds[] = {{"Idle", make_crowd<Idle>},
                                 {"Stalled", make_crowd<Stalled>},
                                 {"Calling", make_crowd<Calling>},
                                 {"LongLines", make_crowd<LongLines>},
                                 {"Connections", make_crowd<Connections>}};

class UnderACrowd : public Watchers, public testing::WithParamInterface<CrowdKind> {
 protected:
  // A person who was not connected before stops the run; the time until the answer.
  Duration stop_anew(const char* method, Crowd& crowd) {
    const MonoTime asked = clock.now();
    PlainClient person(socket_path());
    person.call(method);
    json said;
    clock.run(io, [&] {
      crowd.act(clock.now());
      for (const json& message : person.take()) said = message;
      return !said.is_null() || person.gone() || clock.now() > asked + 10s;
    });
    EXPECT_TRUE(said.contains("result")) << method << ": " << said;
    return clock.now() - asked;
  }
  void expect_stopped_from(const char* method, Duration into_the_run) {
    auto owner = std::make_unique<PlainClient>(socket_path());
    ASSERT_TRUE(answer(*owner, "run.start", start_request()).contains("result"));
    owner.reset();
    auto crowd = GetParam().make(socket_path());
    const MonoTime begun = clock.now();
    clock.run(io, [&] {
      crowd->act(clock.now());
      return clock.now() > begun + into_the_run;
    });
    // STOP goes out at once; the answer waits for samples that show standstill.
    EXPECT_LE(stop_anew(method, *crowd), 500ms) << method;
    clock.run(io, [&] {
      crowd->act(clock.now());
      return !app->status().run || clock.now() > begun + 10min;
    });
    crowd.reset();
    clock.run_for(io, 2s);  // the session is closed, and whoever was connected is gone
    ASSERT_TRUE(app->status().last_run);
    EXPECT_EQ(app->status().last_run->exit_status, ExitStatus::abort);
  }
};

TEST_P(UnderACrowd, AnAbortAndAFreezeOfANewClientAreObeyedAtOnce) {
  for (const Duration instant : {Duration(500ms), Duration(2500ms), Duration(6s)}) {
    expect_stopped_from("run.abort", instant);
    expect_stopped_from("run.freeze", instant);
  }
}

INSTANTIATE_TEST_SUITE_P(EachCrowd, UnderACrowd, testing::ValuesIn(kCrowds),
                         [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace
}  // namespace lcrig
