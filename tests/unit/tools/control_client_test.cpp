// SPDX-License-Identifier: Apache-2.0
// The command line against a real control server in another thread.
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "storage/database.hpp"
#include "tests/unit/tools/served.hpp"

namespace lcrig {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using support::Cli;
using support::Served;

TEST_F(Served, StatusShowsVersionAndRun) {
  on_server([this] {
    handler.state.run.emplace();
    handler.state.run->run = 4;
    handler.state.run->prompt = "place 50 g";
    handler.state.run->simulated = true;
  });
  EXPECT_EQ(cli.run({"status"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("lcrigd 9.9"), HasSubstr("run 4"),
                    HasSubstr("preparing (simulated)\n"), HasSubstr("waits for: place 50 g")));
  EXPECT_EQ(cli.run({"status", "--json"}), 0);
  EXPECT_EQ(nlohmann::json::parse(cli.out.str())["run"]["run"], 4);
}

TEST_F(Served, StatusSaysWhatIsKnownOfTheInstrumentsAndFromWhere) {
  on_server([this] {
    handler.state.instruments.resize(2);
    InstrumentState &lcr = handler.state.instruments[0], &frame = handler.state.instruments[1];
    lcr.port = "serial:/dev/ttyUSB0";
    lcr.condition = InstrumentCondition::absent;
    lcr.why = "no such port";
    lcr.age_s = 2;
    lcr.since_s = 28;
    lcr.learned_by = LearnedBy::look;
    frame.which = Instrument::frame;
    frame.port = "tcp:h:1";
    frame.condition = InstrumentCondition::ready;
    frame.identity = "Zwick";
    frame.simulated = true;
    frame.learned_by = LearnedBy::run;
    frame.run = 12;
    frame.age_s = 200;
    handler.state.last_run.emplace();
    handler.state.last_run->run = 12;
    handler.state.last_run->exit_status = ExitStatus::success;
    handler.state.last_run->simulated = true;
  });
  EXPECT_EQ(cli.run({"status"}), 0) << cli.err.str();
  EXPECT_EQ(cli.out.str(),
            "lcrigd 9.9  database \n"
            "lcr    absent for 28 s: no such port; asked 2 s ago  serial:/dev/ttyUSB0\n"
            "frame  ready (simulated), seen 3 min ago in run 12  tcp:h:1  Zwick\n"
            "no run in progress\n"
            "last: run 12 success (simulated)\n");
  EXPECT_EQ(cli.run({"status", "--json"}), 0);
  const auto lcr = nlohmann::json::parse(cli.out.str())["instruments"][0];
  EXPECT_EQ(lcr["state"], "absent");
  EXPECT_EQ(lcr["since_s"], 28);
  EXPECT_EQ(lcr["learned_by"], "look");
  EXPECT_TRUE(lcr["run"].is_null());
}

TEST_F(Served, TheLastLineOfASimulatedRunSaysSo) {
  ended.simulated = true;
  ended.anchor = "57:" + std::string(64, 'a');
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "mine"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("run 7: success (simulated)\n"),
                                   HasSubstr("\nanchor " + ended.anchor + "\n")));
}

TEST_F(Served, VerbsReachTheDaemon) {
  on_server([this] { handler.state.run.emplace(); });
  EXPECT_EQ(cli.run({"pause"}), 0);
  EXPECT_EQ(cli.run({"resume"}), 0);
  EXPECT_EQ(cli.run({"resume", "12"}), 0);
  EXPECT_THAT(cli.err.str(), HasSubstr("lcrig confirm"));
  EXPECT_EQ(cli.run({"resume", "12", "--confirm-specimen"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 13 continues run 12"));
  EXPECT_EQ(cli.run({"abort", "--why", "smoke"}), 0);
  EXPECT_EQ(cli.run({"freeze"}), 0);
  EXPECT_EQ(cli.run({"confirm"}), 0);
  EXPECT_EQ(cli.run({"stop", "--after", "level", "--why", "tea"}), 0);
  EXPECT_EQ(cli.out.str(), "it stops later\n");
  EXPECT_EQ(cli.run({"pause", "--at", "safe_point"}), 0);
  EXPECT_EQ(cli.run({"stop"}), cli::kUsage);
  on_server([this] {
    EXPECT_THAT(
        handler.calls,
        ElementsAre("pause", "resume present", "resume 12", "resume 12 confirmed", "abort smoke",
                    "freeze ", "confirm", "stop after level tea", "pause at safe_point"));
  });
}

TEST_F(Served, AnAnswerNamesTheQuestionThatItIsFor) {
  EXPECT_EQ(cli.run({"answer"}), 0) << "nothing is known of a question: the daemon says what waits";
  on_server([this] {
    OpenQuestion open;
    open.number = 3;
    open.question.step_id = "thickness";
    open.question.text = "Thickness by gauge";
    open.question.type = AnswerType::number;
    open.question.unit = "um";
    open.question.min = 20;
    open.question.max = 400;
    handler.state.run.emplace();
    handler.state.run->question = open;
  });
  EXPECT_EQ(cli.run({"answer", "125.5"}), 0) << cli.err.str();
  EXPECT_EQ(cli.out.str(), "step thickness: 125.5 um\n");
  EXPECT_EQ(cli.run({"answer"}), cli::kUsage);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("step thickness asks \"Thickness by gauge\""),
                                   HasSubstr("expected a number from 20 to 400 um"),
                                   HasSubstr("lcrig answer VALUE")));
  EXPECT_EQ(cli.run({"answer", "-5"}), 0) << "a number below zero is no option";
  on_server([this] {
    EXPECT_THAT(handler.calls,
                ElementsAre("answer confirmed", "answer 125.5 to 3", "answer -5 to 3"));
  });
}

TEST_F(Served, TheDaemonsRefusalKeepsItsWordsAndHint) {
  on_server([this] { handler.next_error = Error(Errc::no_reply, "lcr0: *IDN? -> no reply"); });
  EXPECT_EQ(cli.run({"pause"}), cli::kInstrument);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("lcr0: *IDN? -> no reply"), HasSubstr("next: ")));
}

// The daemon parses a text without a path, and reports its first mistake.
TEST_F(Served, ABrokenProtocolIsToldAsACheckTellsIt) {
  const auto file = cli.dir.file("broken.json");
  std::ofstream(file) << R"({ "format": "load-protocol/1", "name": "my press",
  "limits": { "force_N": [2, 1] } })";
  EXPECT_EQ(cli.run({"protocol", "check", file}), cli::kProtocol);
  const auto checked = cli.err.str();
  EXPECT_THAT(checked,
              AllOf(HasSubstr("broken.json:1:"), HasSubstr("broken.json:2:"), HasSubstr("^")));
  on_server([this] {
    handler.next_error = Error(Errc::invalid_request, "broken.json:1:38 /name: \"my press\"");
  });
  for (const bool dry : {false, true}) {
    std::vector<std::string> words{"run", file, "--specimen", "paper-1"};
    if (dry) words.emplace_back("--dry-run");
    EXPECT_EQ(cli.run(words), cli::kProtocol);
    EXPECT_EQ(cli.err.str(), checked);
  }
}

TEST_F(Served, TheLineOfAStandstillSaysWhatStopped) {
  on_server([this] {
    handler.after_start = [this] {
      RunEventNote note;
      note.run = 7;
      note.event = RunEvent(MonoTime(), EventKind::stopped, "load", "");
      server.publish_event(note);
      end_run();
    };
  });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "mine"}), 0) << cli.err.str();
  EXPECT_THAT(cli.err.str(), HasSubstr("stopped (load): the frame confirmed standstill\n"));
}

TEST_F(Served, RunFollowsToTheEndAndPrintsTheResultLast) {
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "mine", "-p", "cycles=2", "--json"}), 0)
      << cli.err.str();
  const auto result = nlohmann::json::parse(cli.out.str());
  EXPECT_EQ(result["run"], 7);
  EXPECT_EQ(result["exit_status"], "success");
  EXPECT_THAT(cli.err.str(), HasSubstr("mark (load): half way"));
  on_server([this] {
    EXPECT_EQ(std::get<std::string>(handler.last_start.parameters.at("cycles")), "2");
    EXPECT_EQ(handler.last_start.protocol_text, "{}");
    EXPECT_EQ(handler.last_start.specimen_name, "mine");
    EXPECT_EQ(handler.last_start.specimen_text, "");  // the daemon's database knows it
  });
}

TEST_F(Served, ATrippedLimitIsFive) {
  on_server([this] {
    ended.exit_status = ExitStatus::fail;
    ended.code = Errc::limit_tripped;
    ended.reason = "force 1.6 N";
  });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), cli::kStopped);
  EXPECT_THAT(cli.out.str(), HasSubstr("force 1.6 N"));
}

TEST_F(Served, ARunThatWasStoppedWhereSomebodyAskedIsEight) {
  on_server([this] {
    ended.exit_status = ExitStatus::stopped;
    ended.reason = "after the level, step level: by lab";
  });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), cli::kStoppedEarly);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 7: stopped (after the level, step level: by lab)"));
}

// A daemon may still refuse it because of its rig or its specimens.
void make_correct(Cli& cli) {
  std::ifstream in("protocols/library/follow.json");
  cli.add_data("protocols/press.json", {std::istreambuf_iterator<char>(in), {}});
}

TEST_F(Served, ARefusedProtocolIsSix) {
  make_correct(cli);
  on_server([this] { handler.next_error = Error(Errc::invalid_request, "/steps/0: too fast"); });
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), cli::kProtocol);
  EXPECT_THAT(cli.err.str(), HasSubstr("/steps/0: too fast"));
}

TEST_F(Served, DetachReturnsAtOnce) {
  on_server([this] { handler.after_start = nullptr; });  // a run that does not end
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1", "--detach", "--json"}), 0);
  EXPECT_EQ(nlohmann::json::parse(cli.out.str())["run"], 7);
}

// The daemon does not know by which options it was reached.
TEST_F(Served, TheCommandOfAHintGetsTheOptionsThatReachThisDaemon) {
  const auto next_of = [this](Errc code) {
    on_server([&] { handler.next_error = Error(code, "no"); });
    EXPECT_NE(cli.run({"pause", "--socket", path}), 0);
    return cli.err.str();
  };
  EXPECT_THAT(next_of(Errc::busy),
              HasSubstr("next: lcrig status --socket " + path + "   (what goes on)\n"));
  EXPECT_THAT(next_of(Errc::reply_cut_off),
              HasSubstr("next: check the cable, then: lcrig status --socket " + path + "\n"));
  EXPECT_THAT(next_of(Errc::limit_tripped), HasSubstr("limits, then run again\n"));
}

TEST_F(Served, ARunThatACrashLeftIsNamedAndOffered) {
  ResumableRun left;
  left.run = 12;
  left.protocol = "creep";
  left.specimen = "paper-1";
  left.step_id = "load";
  on_server([&] { handler.state.resumable = {left}; });
  EXPECT_EQ(cli.run({"status"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 12, creep on paper-1, in step load; lcrig resume 12"));
  EXPECT_EQ(cli.run({"status", "--socket", path}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("lcrig resume 12 --socket " + path + " continues it"));
  EXPECT_EQ(cli.run({"resume"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("run 13 continues run 12, creep on paper-1, in step load"));
  EXPECT_THAT(cli.err.str(), HasSubstr("lcrig confirm"));
  on_server([this] { EXPECT_THAT(handler.calls, ElementsAre("resume 12")); });
}

TEST_F(Served, WithNoneOrSeveralInterruptedRunsResumeRefusesAndSaysSo) {
  EXPECT_EQ(cli.run({"resume"}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("no run is paused"), HasSubstr("lcrig runs")));
  on_server([this] {
    handler.state.resumable.resize(2);
    handler.state.resumable[0].run = 11;
    handler.state.resumable[1].run = 12;
  });
  EXPECT_EQ(cli.run({"resume"}), cli::kFailed);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("say which"), HasSubstr("run 11"), HasSubstr("lcrig resume 12")));
  on_server([this] { EXPECT_THAT(handler.calls, testing::IsEmpty()); });
}

// The daemon does not propose similar names, so the command line does.
TEST_F(Served, AnUnknownSpecimenIsAnsweredWithTheNearest) {
  make_correct(cli);
  const auto db = cli.dir.file("daemons.db");
  ASSERT_TRUE(open_read_write(db));
  on_server([&] {
    handler.state.database = db;
    handler.next_error = Error(Errc::invalid_request, "no specimen `papr-1`");
  });
  for (const bool dry : {true, false}) {
    std::vector<std::string> words{"run", "press", "--specimen", "papr-1"};
    if (dry) words.emplace_back("--dry-run");
    EXPECT_EQ(cli.run(words), cli::kProtocol);
    EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("did you mean 'paper-1'?"),
                                     HasSubstr("next: lcrig specimen list")));
  }
}

TEST_F(Served, WhoLeavesWithoutARunIsToldThatNoneWasGoingOn) {
  sigset_t interrupt;
  sigemptyset(&interrupt);
  sigaddset(&interrupt, SIGINT);
  ::pthread_sigmask(SIG_BLOCK, &interrupt, nullptr);
  ASSERT_EQ(::raise(SIGINT), 0);
  EXPECT_EQ(cli.run({"watch"}), cli::kInterrupted);
  EXPECT_THAT(cli.err.str(), HasSubstr("next: lcrig status   (no run was going on)"));
}

}  // namespace
}  // namespace lcrig
