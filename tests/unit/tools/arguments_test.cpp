// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/protocol_text.hpp"
#include "tools/lcrig/argument_table.hpp"
#include "tools/lcrig/commands.hpp"

namespace lcrig {
namespace {

using support::Cli;
using support::FakeRehearsal;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

struct Mistake {
  std::vector<std::string> args;
  const char* says;
};

// The CLI11 of Debian 13 refuses a name with a blank when a command is declared, so every command
// would fail there; that of Debian 12 takes it.
TEST(Arguments, NoNameHasABlank) {
  for (const auto& command : cli::make_commands()) {
    for (const auto& argument : cli::arguments_of(*command)) {
      for (const auto& name : argument.names) {
        EXPECT_EQ(name.find(' '), name.npos) << command->name << ": " << name;
      }
    }
  }
}

TEST(Arguments, EveryMistakeIsUsageAndSaysWhatToTypeNext) {
  const Mistake mistakes[] = {
      {{}, "command is missing"},
      {{"rnu"}, "did you mean 'run'?"},
      {{"reherse", "static-frame"}, "did you mean 'rehearse'?"},
      {{"qqqqqqq"}, "unknown command 'qqqqqqq'"},
      {{"--jsn"}, "did you mean '--json'?"},
      {{"--db", "x.db"}, "command is missing"},
      {{"--db"}, "command is missing"},
      {{"protocol"}, "a verb is missing"},
      {{"protocol", "plna", "x"}, "did you mean 'plan'?"},
      {{"specimen", "--json"}, "a verb is missing"},
      {{"runs", "shwo", "1"}, "did you mean 'show'?"},
      {{"runs", "show"}, "RUN"},
      {{"run", "p"}, "specimen"},
      {{"run", "--specimn", "paper-1", "p"}, "did you mean '--specimen'?"},
      {{"run", "-x", "p"}, "unknown option -x"},
      {{"run", "p", "--specimen"}, "specimen"},
      {{"run", "p", "q", "--specimen", "s"}, "q"},
      {{"run", "p", "--specimen", "s", "-p", "cycles"}, "expected name=value"},
      {{"run", "p", "--specimen", "s", "-p", "=5"}, "expected name=value"},
      {{"run", "p", "--specimen", "s", "-p", "a=1", "-p", "a=2"}, "given twice"},
      {{"rehearse"}, "PROTOCOL"},
      {{"rehearse", "p", "--specimen", "s", "--seed", "many"}, "seed"},
      {{"rehearse", "p", "--specimen", "s", "--seed", "-1"}, "seed"},
      {{"status", "now"}, "now"},
      {{"status", "--why", "x"}, "unknown option --why"},
      {{"resume", "yesterday"}, "not the number of a run"},
      {{"resume", "0"}, "not the number of a run"},
      {{"resume", "--confirm-specimen"}, "RUN is missing"},
      {{"export", "1", "-o", "-", "--layout", "colums"}, "layout"},
      {{"export", "1", "-o", "x", "--layout", "frame"}, "--layout is for -o -"},
      {{"analyze", "1", "--range", "30"}, "expected FROM:TO"},
      {{"analyze", "1", "--confidence", "high"}, "--confidence"},
  };
  Cli cli;
  for (const auto& mistake : mistakes) {
    const int code = cli.run(mistake.args);
    const auto shown = ::testing::PrintToString(mistake.args);
    EXPECT_EQ(code, cli::kUsage) << shown << cli.err.str();
    EXPECT_THAT(cli.err.str(), HasSubstr(mistake.says)) << shown;
    EXPECT_THAT(cli.err.str(), HasSubstr("next: ")) << shown;
    EXPECT_THAT(cli.out.str(), IsEmpty()) << shown;
  }
}

// The options by which a number is analysed are the same wherever it is shown.
TEST(Arguments, AReportTakesTheOptionsOfAnAnalysis) {
  const auto options_of = [](cli::CommandFactory make) {
    std::set<std::string> out;
    const auto command = make();
    for (const cli::Argument& a : cli::arguments_of(*command)) {
      if (a.option) out.insert(a.names.back());
    }
    return out;
  };
  auto of_report = options_of(cli::kReportCommand);
  for (const char* of_its_file : {"--output", "--csv", "--batch"}) {
    EXPECT_EQ(of_report.erase(of_its_file), 1U) << of_its_file;
  }
  const auto of_analysis = options_of(cli::kAnalyzeCommand);
  EXPECT_EQ(of_report, of_analysis);
  EXPECT_TRUE(of_analysis.contains("--force-class"));
}

TEST(Arguments, HelpStartsWithAnExampleAndIsAResult) {
  Cli cli;
  for (const std::vector<std::string>& args :
       std::vector<std::vector<std::string>>{{"--help"},
                                             {"run", "--help"},
                                             {"protocol", "--help"},
                                             {"protocol", "plan", "-h"},
                                             {"runs", "--help"}}) {
    EXPECT_EQ(cli.run(args), 0);
    EXPECT_THAT(cli.out.str(), StartsWith("Example: lcrig "));
    EXPECT_THAT(cli.err.str(), IsEmpty());
  }
  cli.run({"run", "--help"});
  const std::string said = cli.out.str();
  cli.run({"help", "run"});
  EXPECT_EQ(cli.out.str(), said);
  EXPECT_EQ(cli.run({"help"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("Subcommands"));
  cli.run({"abort", "--help"});
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("--why"), HasSubstr("--json")));
}

TEST(Arguments, TheUsageLineCanBeTyped) {
  Cli cli;
  for (const auto& command : cli::make_commands()) {
    std::istringstream name(command->name);
    std::vector<std::string> args(std::istream_iterator<std::string>(name), {});
    args.emplace_back("--help");
    cli.run(args);
    EXPECT_THAT(cli.out.str(), HasSubstr(fmt::format("Usage: lcrig {}", command->name)));
  }
}

TEST(Arguments, HelpNamesEveryCommand) {
  Cli cli;
  cli.run({"--help"});
  for (const auto* word :
       {"run", "rehearse", "status", "watch", "pause", "resume", "abort", "freeze", "confirm",
        "answer", "stop", "protocol", "specimen", "runs", "export", "analyze", "verify"}) {
    EXPECT_THAT(cli.out.str(), HasSubstr(word));
  }
}

TEST(Arguments, VersionIsAResult) {
  Cli cli;
  EXPECT_EQ(cli.run({"--version"}), 0);
  EXPECT_THAT(cli.out.str(),
              MatchesRegex("lcrig " LCRIG_VERSION "(\\+[0-9]+\\.g[0-9a-f]+(\\.dirty)?)?\n"));
}

TEST(Arguments, AnUnreachableDaemonIsThreeAndSaysHowToGoOn) {
  Cli cli;
  const auto expect_unreachable = [&cli](const char* verb, const char* advice,
                                         const char* command = "systemctl status lcrigd") {
    EXPECT_EQ(cli.run({verb}), cli::kUnreachable) << verb;
    EXPECT_THAT(cli.err.str(),
                AllOf(HasSubstr("no-daemon.sock"), HasSubstr(command), HasSubstr(advice)));
  };
  for (const auto* verb : {"status", "watch", "resume"}) expect_unreachable(verb, "rehearse");
  for (const auto* verb : {"confirm", "answer"}) {
    expect_unreachable(verb, "");
    EXPECT_THAT(cli.err.str(), Not(HasSubstr("rehearse"))) << "it is about a run at the rig";
  }
  for (const auto* verb : {"pause", "abort", "freeze"}) {
    expect_unreachable(verb, "E-stop", "systemctl stop lcrigd");
  }
  EXPECT_EQ(cli.run({"status", "--socket", std::string(300, 's')}), cli::kUsage);
}

TEST(Arguments, ErrorsHaveNoEscapeCodesOffTheTerminalNorWithNoColor) {
  Cli cli;
  cli.run({"status"});
  EXPECT_THAT(cli.err.str(), Not(HasSubstr("\x1b")));
  cli.tty = true;
  cli.run({"status"});
  EXPECT_THAT(cli.err.str(), HasSubstr("\x1b[31m"));
  cli.variables["NO_COLOR"] = "1";
  cli.run({"status"});
  EXPECT_THAT(cli.err.str(), Not(HasSubstr("\x1b")));
}

TEST(Arguments, GlobalOptionsStandAnywhere) {
  Cli cli;
  const auto db = cli.dir.file("none.db");
  for (const auto& args : {std::vector<std::string>{"--db", db, "runs"},
                           {"runs", "--db", db},
                           {"runs", "list", "--db=" + db}}) {
    EXPECT_EQ(cli.run(args), cli::kFailed);
    EXPECT_THAT(cli.err.str(), HasSubstr(db));
  }
}

class Rehearse : public ::testing::Test {
 protected:
  void SetUp() override {
    FakeRehearsal::last = RehearseRequest();
    FakeRehearsal::answer = RehearseResult();
    FakeRehearsal::answer->run = 3;
    FakeRehearsal::answer->exit_status = ExitStatus::success;
    cli.add_data("protocols/press.json", kLoad);
  }
  Cli cli;
};

TEST_F(Rehearse, HandsEverythingOver) {
  EXPECT_EQ(cli.run({"rehearse", "press", "-p", "cycles=5", "-p", "force_N=0.50", "--specimen",
                     "paper-2", "--seed", "7", "--note", "-", "--operator", "Ada"}),
            0)
      << cli.err.str();
  const auto& r = FakeRehearsal::last;
  EXPECT_EQ(r.protocol_name, "press.json");
  EXPECT_EQ(r.protocol_text, kLoad);
  EXPECT_EQ(std::get<std::string>(r.parameters.at("force_N")), "0.50");
  EXPECT_EQ(r.specimen_name, "paper-2");
  EXPECT_THAT(r.specimen_text, HasSubstr("specimen/1"));
  EXPECT_EQ(r.seed, 7U);
  EXPECT_EQ(r.operator_name, "Ada");
  EXPECT_EQ(r.bench, "paper");
}

TEST_F(Rehearse, JsonIsTheOnlyLineOfStandardOutput) {
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1", "--json"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(StartsWith("{"), HasSubstr("\"exit_status\":\"success\""),
                                   HasSubstr("\"run\":3"), HasSubstr("\"reason\":\"\"")));
  const auto text = cli.out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST_F(Rehearse, SaysWhatOfItIsNoPhysics) {
  FakeRehearsal::answer->remarks = {"the bench went to 3 N"};
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("\nthe bench went to 3 N\n"));
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1", "--json"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr(R"("remarks":["the bench went to 3 N"])"));
}

TEST_F(Rehearse, NeverUsesTheDaemonsDatabase) {
  std::ofstream(cli.env.daemon_db) << "";
  cli.run({"rehearse", "press", "-s", "paper-1"});
  EXPECT_EQ(FakeRehearsal::last.db_path, cli.dir.file("home/.local/share/lcrig/lcrig.db"));
  cli.run({"rehearse", "press", "-s", "paper-1", "--db", cli.dir.file("x.db")});
  EXPECT_EQ(FakeRehearsal::last.db_path, cli.dir.file("x.db"));
}

TEST_F(Rehearse, AnEmptyFileBecomesTheDatabase) {
  const auto db = cli.dir.file("empty.db");
  std::ofstream(db) << "";
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1", "--db", db}), 0) << cli.err.str();
  EXPECT_EQ(FakeRehearsal::last.db_path, db);
}

TEST_F(Rehearse, OfAFileWithTwoNamesItIsNotTheProtocolThatIsWrong) {
  const auto db = cli.dir.file("a.db");
  ASSERT_TRUE(open_read_write(db));
  std::filesystem::create_hard_link(db, cli.dir.file("b.db"));
  FakeRehearsal::answer = fail(Errc::invalid_request, "a.db: this file has 2 names (hard links)");
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1", "--db", db}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("2 names"), HasSubstr("next: give another --db"),
                                   Not(HasSubstr("protocol show"))));
}

TEST_F(Rehearse, OfALogWithoutItsDatabaseItIsNotTheProtocolThatIsWrong) {
  const auto db = cli.dir.file("a.db");
  std::ofstream(db + "-wal") << "rows";
  FakeRehearsal::answer = fail(Errc::invalid_request, "a.db: there is no database, but its log");
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "paper-1", "--db", db}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("its log"), HasSubstr("next: give another --db"),
                                   Not(HasSubstr("protocol show"))));
}

TEST_F(Rehearse, ExitCodesFollowTheRun) {
  const std::vector<std::string> args{"rehearse", "press", "-s", "paper-1"};
  FakeRehearsal::answer->exit_status = ExitStatus::abort;
  EXPECT_EQ(cli.run(args), cli::kStopped);
  FakeRehearsal::answer->exit_status = ExitStatus::fail;
  FakeRehearsal::answer->code = Errc::limit_tripped;
  EXPECT_EQ(cli.run(args), cli::kStopped);
  FakeRehearsal::answer->code = Errc::no_reply;
  EXPECT_EQ(cli.run(args), cli::kInstrument);
  FakeRehearsal::answer = fail(Errc::invalid_request, "/steps/0: too fast");
  EXPECT_EQ(cli.run(args), cli::kProtocol);
  EXPECT_THAT(cli.err.str(), HasSubstr("/steps/0: too fast"));
  FakeRehearsal::answer = fail(Errc::io, "disk full");
  EXPECT_EQ(cli.run(args), cli::kFailed);
}

TEST_F(Rehearse, UnknownNamesListTheKnownOnes) {
  EXPECT_EQ(cli.run({"rehearse", "pres", "-s", "paper-1"}), cli::kProtocol);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("did you mean 'press'?"), HasSubstr("lcrig protocol list")));
  EXPECT_EQ(cli.run({"rehearse", "press", "-s", "papr-1"}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("did you mean 'paper-1'?"), HasSubstr("paper-3")));
  EXPECT_EQ(cli.run({"rehearse", "press"}), cli::kUsage);
  EXPECT_EQ(cli.run({"rehearse", "press", "--bench", "replay:/data/x"}), 0);
  EXPECT_EQ(FakeRehearsal::last.bench, "replay:/data/x");
}

TEST(ExitCodes, AreThePromisedNumbers) {
  using cli::exit_code_of;
  EXPECT_EQ(exit_code_of(Errc::busy), 1);
  EXPECT_EQ(exit_code_of(Errc::io), 1);
  EXPECT_EQ(exit_code_of(Errc::bug), 1);
  EXPECT_EQ(exit_code_of(Errc::no_reply), 4);
  EXPECT_EQ(exit_code_of(Errc::disconnected), 4);
  EXPECT_EQ(exit_code_of(Errc::garbled), 4);
  EXPECT_EQ(exit_code_of(Errc::refused), 4);
  EXPECT_EQ(exit_code_of(Errc::aborted), 5);
  EXPECT_EQ(exit_code_of(Errc::limit_tripped), 5);
  EXPECT_EQ(cli::exit_code_of_run(ExitStatus::fail, std::nullopt), 1);
  EXPECT_EQ(cli::exit_code_of_run(ExitStatus::fail, Errc::invalid_request), 6);
}

TEST(Paths, FollowTheEnvironment) {
  Cli cli;
  EXPECT_EQ(cli.env.default_db(), cli.dir.file("home/.local/share/lcrig/lcrig.db"));
  cli.variables["XDG_DATA_HOME"] = "/xdg";
  EXPECT_EQ(cli.env.default_db(), "/xdg/lcrig/lcrig.db");
  cli.variables["XDG_DATA_HOME"] = "relative";
  EXPECT_EQ(cli.env.default_db(), cli.dir.file("home/.local/share/lcrig/lcrig.db"));
  std::ofstream(cli.env.daemon_db) << "";
  EXPECT_EQ(cli.env.default_db(), cli.env.daemon_db);
  cli.variables["LCRIG_DB"] = "/mine.db";
  EXPECT_EQ(cli.env.default_db(), "/mine.db");
}

// As cron starts programs.
TEST(Paths, OfAUserWithoutHOMEAreInTheHomeThatTheSystemKnows) {
  const char* home = std::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  ::unsetenv("HOME");
  const auto path = cli::real_process_env().user_db();
  if (home != nullptr) ::setenv("HOME", before.c_str(), 1);
  EXPECT_TRUE(path.is_absolute()) << path;
}

}  // namespace
}  // namespace lcrig
