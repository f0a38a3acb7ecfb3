// SPDX-License-Identifier: Apache-2.0
// The daemon records who asked it for something: in the run, or in the log where there is no run.
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <sstream>

#include "base/strict_json.hpp"
#include "storage/chain.hpp"
#include "storage/runs.hpp"
#include "tests/support/daemon_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// Asks a person first and moves nothing.
constexpr const char* kAsking = R"({ "format": "load-protocol/1", "name": "asking",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "look", "do": "record", "until": "confirmed", "timeout_s": 600 },
             { "id": "after", "do": "record", "for_s": 60 } ],
  "finally": [] })";

class Daemon : public support::DaemonWorld {
 protected:
  // The requests of all runs in order, each with the user that the kernel reports.
  std::vector<std::string> kinds() const {
    std::vector<std::string> out;
    for (const json& row : requests()) {
      out.push_back(row["request"]);
      EXPECT_EQ(row["uid"], ::getuid());
      EXPECT_EQ(row["pid"], ::getpid());
      EXPECT_FALSE(row["user"].get<std::string>().empty());
    }
    return out;
  }
  void wait_until_asked(PlainClient& client) {
    wait_for(client, [](const json& m) {
      return m.value("method", "") == "status" && m["params"]["prompt"] != "";
    });
  }
  void wait_until_over(PlainClient& client) {
    client.call("watch");
    wait_for(client, [](const json& m) {
      return m.value("method", "") == "run_ended" ||
             (m.contains("result") && m["result"].contains("run") && m["result"]["run"].is_null());
    });
  }
};

TEST_F(Daemon, EveryRequestStandsInTheRunWithTheKernelsWordOnWhoAsked) {
  PlainClient client(socket_path());
  auto request = start_request();
  request["operator"] = "somebody else";
  ASSERT_TRUE(answer(client, "run.start", request).contains("result"));
  ASSERT_TRUE(answer(client, "run.pause").contains("result"));
  clock.run_for(io, 2s);
  ASSERT_TRUE(answer(client, "run.resume").contains("result"));
  ASSERT_TRUE(answer(client, "run.abort", {{"why", "=1+1\x1b[31m\n"}}).contains("result"));
  wait_until_over(client);
  EXPECT_THAT(kinds(), ElementsAre("run.start", "run.pause", "run.resume", "run.abort"));
  EXPECT_EQ(requests().back()["why"], "=1+1\x1b[31m\n");
  EXPECT_TRUE(verify_chain(open_read_only(dir.file("d.db")).value(), 1).value().intact);
}

TEST_F(Daemon, FreezeAndConfirmStandInTheRunToo) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "watch").contains("result"));
  ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
  wait_until_asked(client);
  ASSERT_TRUE(answer(client, "run.confirm").contains("result"));
  clock.run_for(io, 2s);
  ASSERT_TRUE(answer(client, "run.freeze", {{"why", "smoke"}}).contains("result"));
  wait_until_over(client);
  EXPECT_THAT(kinds(), ElementsAre("run.start", "run.confirm", "run.freeze"));
  EXPECT_EQ(requests().back()["why"], "smoke");
}

// Both lines are in the socket at once, so the step ends and the run is stopped in one turn of the
// loop.
TEST_F(Daemon, AStopInTheInstantInWhichAStepEndsIsObeyed) {
  PlainClient client(socket_path());
  for (const char* stop : {"run.abort", "run.freeze"}) {
    ASSERT_TRUE(answer(client, "watch").contains("result"));
    ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
    wait_until_asked(client);
    client.send(request_line(100, "run.confirm", {}) + request_line(101, stop, {}));
    const json ended =
        wait_for(client, [](const json& m) { return m.value("method", "") == "run_ended"; });
    EXPECT_EQ(ended["params"]["exit_status"], "abort") << stop << ": " << ended;
    EXPECT_LT(ended["params"]["duration_s"], 30) << stop;
  }
}

TEST_F(Daemon, ARequestThatIsRefusedStandsNowhere) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
  EXPECT_TRUE(answer(client, "run.resume").contains("error"));
  EXPECT_TRUE(answer(client, "run.resume", {{"run", 7}}).contains("error"));
  EXPECT_EQ(answer(client, "run.start", start_request(kAsking))["error"]["data"]["errc"], "busy");
  ASSERT_TRUE(answer(client, "run.abort").contains("result"));
  wait_until_over(client);
  for (const char* verb : {"run.abort", "run.freeze", "run.confirm", "run.pause", "run.resume"}) {
    const json error = answer(client, verb)["error"];
    EXPECT_THAT(error.value("/data/hint"_json_pointer, ""),
                StartsWith("lcrig status   (what goes on"))
        << verb;
  }
  EXPECT_THAT(kinds(), ElementsAre("run.start", "run.abort"));
}

// The disk as a crash leaves it: copied in the middle of a run, and found by the next daemon.
TEST_F(Daemon, WhoContinuedAnInterruptedRunStandsInTheRunThatContinuesIt) {
  {
    PlainClient client(socket_path());
    ASSERT_TRUE(answer(client, "watch").contains("result"));
    ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
    wait_until_asked(client);
    clock.run_for(io, 5s);
    for (const char* suffix : {"", "-wal"}) {
      std::filesystem::copy_file(dir.file(std::string("d.db") + suffix),
                                 dir.file(std::string("crashed.db") + suffix));
    }
  }
  stop();
  start("crashed.db");
  PlainClient client(socket_path());
  const json watched = answer(client, "watch");
  EXPECT_EQ(watched.at("result").at("resumable"),
            json::parse(R"([{"run":1,"protocol":"asking","specimen":"paper-1","step":"look"}])"));
  const json going = answer(client, "run.resume", {{"run", 1}});
  ASSERT_TRUE(going.contains("result")) << going;
  EXPECT_EQ(going["result"]["run"], 2);
  EXPECT_EQ(app->status().resumable.size(), 0U);
  wait_until_asked(client);  // asked to look at the specimen
  ASSERT_TRUE(answer(client, "run.confirm").contains("result"));
  const json stopped = answer(client, "run.abort");
  ASSERT_TRUE(stopped.contains("result")) << stopped;
  wait_until_over(client);
  EXPECT_THAT(kinds(), ElementsAre("run.start", "run.resume", "run.confirm", "run.abort"));
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'request' AND run_id = 2"), 3);
  EXPECT_TRUE(verify_chain(open_read_only(dir.file("crashed.db")).value(), 2).value().intact);
}

TEST_F(Daemon, ASpecimenThatIsStoredIsLoggedWithWhoAsked) {
  std::ostringstream log;
  auto& sinks = spdlog::default_logger()->sinks();
  sinks.push_back(std::make_shared<spdlog::sinks::ostream_sink_mt>(log));
  const std::string text(shipped_specimens().front().text);
  PlainClient client(socket_path());
  const json stored = answer(client, "specimen.add", {{"text", text}});
  const json refused = answer(client, "specimen.add", {{"text", "{}"}});
  sinks.pop_back();
  EXPECT_EQ(stored["result"]["name"], "paper-1") << stored;
  EXPECT_TRUE(refused.contains("error"));
  EXPECT_EQ(count("SELECT count(*) FROM specimen"), 1);
  EXPECT_THAT(log.str(), HasSubstr("specimen paper-1 stored for "));
  EXPECT_THAT(log.str(), HasSubstr(fmt::format("(uid {}, pid {})", ::getuid(), ::getpid())));
}

TEST_F(Daemon, ATagIsPutOnARunThatGoesOnWithTheKernelsName) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
  const json tagged = answer(client, "run.tag", {{"run", 1}, {"tags", {"thesis", "ageing"}}});
  EXPECT_EQ(tagged["result"]["tags"].dump(), R"(["ageing","thesis"])");
  EXPECT_THAT(answer(client, "run.tag", {{"run", 1}, {"tags", {"two words"}}}).dump(),
              HasSubstr("a tag is one word"));
  EXPECT_THAT(answer(client, "run.tag", {{"run", 7}, {"tags", {"x"}}}).dump(),
              HasSubstr("no run 7"));
  ASSERT_TRUE(answer(client, "run.abort").contains("result"));
  wait_until_over(client);
  const Database db = open_read_only(dir.file("d.db")).value();
  EXPECT_EQ(count("SELECT count(*) FROM v_tag WHERE run = 1 AND operator = '" +
                  requests().front().at("user").get<std::string>() + "'"),
            2);
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
}

TEST_F(Daemon, ANoteOfAMemberHasTheKernelsNameAndIsPartOfTheChain) {
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request(kAsking)).contains("result"));
  const json early = answer(client, "run.note", {{"run", 1}, {"text", "too early"}});
  EXPECT_THAT(early.dump(), HasSubstr("run 1 is still going on"));
  EXPECT_THAT(answer(client, "run.note", {{"run", 7}, {"text", "x"}}).dump(),
              HasSubstr("no run 7"));
  ASSERT_TRUE(answer(client, "run.abort").contains("result"));
  wait_until_over(client);
  EXPECT_TRUE(
      answer(client, "run.note", {{"run", 1}, {"text", "dusty \x1b[31m"}}).contains("result"));
  EXPECT_TRUE(answer(client, "run.note", {{"run", 1}, {"text", ""}}).contains("error"));
  const Database db = open_read_only(dir.file("d.db")).value();
  const auto notes = get_run_notes(db, 1).value();
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].text, "dusty \x1b[31m");
  EXPECT_EQ(notes[0].operator_name, requests().front().at("user").get<std::string>());
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
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
