// SPDX-License-Identifier: Apache-2.0
// The commands of `next:` lines are typed into a shell here, and must do what was asked for before.

#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "base/text.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/tools/served.hpp"
#include "tools/lcrig/command_output.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;
using cli::Words;
using support::Cli;
using support::FakeRehearsal;
using support::Served;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Words read_by_shell(const Cli& cli, const std::string& line) {
  return support::read_by_shell(cli.dir.file("line.sh"), line);
}

// The command behind `next:` in the last answer, without its note in parentheses.
std::string proposed_line(const Cli& cli) {
  constexpr std::string_view kMark = "  next: ";
  const auto said = cli.err.str();
  const auto at = said.rfind(kMark);
  if (at == said.npos) return {};
  const auto line = said.substr(at + kMark.size(), said.find('\n', at) - at - kMark.size());
  return line.substr(0, line.rfind("   ("));
}

Words proposed(const Cli& cli) {
  return read_by_shell(cli, proposed_line(cli));
}

class Choice {
 public:
  explicit Choice(unsigned seed) : random_(seed) {}
  bool yes() { return below(2) == 0; }
  template <std::size_t n>
  std::string one_of(const std::array<std::string, n>& of) {
    return of.at(below(n));
  }
  std::size_t below(std::size_t n) { return random_() % n; }

 private:
  std::mt19937 random_;
};

// Words that people type, and some that they hardly ever type.
const std::array<std::string, 9> kAwkward{"paper-1", "two words",     "it's $HOME `ls`",
                                          "a\"b\\c", "first\nsecond", "-starts-so",
                                          "100 %!",  "Größe \u202e",  "\xff\xfe"};

TEST(NextCommand, AShellReadsEveryWordAsItWas) {
  const Cli cli;
  for (const auto& word : kAwkward) {
    const auto line = "lcrig " + cli::shell_quoted(word);
    EXPECT_THAT(read_by_shell(cli, line), ElementsAre(word)) << line;
    EXPECT_EQ(printable(line), line);  // the terminal changes nothing of it
  }
  EXPECT_EQ(cli::shell_quoted(""), "''");
  EXPECT_EQ(cli::shell_quoted("force_N=0.5"), "force_N=0.5");
}

// A protocol, parameters and options that a run of the daemon takes.
Words some_run(Choice& choice, const std::string& socket, const std::string& config,
               const std::string& db) {
  Words words{"run", "press"};
  const std::array<std::string, 4> values{"0.5", "1e-3", "two words", "it's"};
  if (choice.yes()) words.insert(words.end(), {"-p", "force_N=" + choice.one_of(values)});
  if (choice.yes()) words.insert(words.end(), {"--parameter", "cycles=" + choice.one_of(values)});
  words.insert(words.end(), {"--specimen=" + choice.one_of(kAwkward)});
  if (choice.yes()) words.push_back("--operator=" + choice.one_of(kAwkward));
  if (choice.yes()) words.push_back("--note=" + choice.one_of(kAwkward));
  if (choice.yes()) words.emplace_back("--detach");
  if (choice.yes()) words.insert(words.end(), {"--db", db});
  switch (choice.below(3)) {
    case 0: words.insert(words.begin(), {"--socket", socket}); break;
    case 1: words.insert(words.end(), {"--config", config}); break;
    default: break;
  }
  return words;
}

TEST_F(Served, WhatADryRunProposesRunsTheSame) {
  const auto config = cli.dir.file("my config.json");
  std::ofstream(config) << nlohmann::json{{"socket", path}}.dump();
  const auto db = cli.dir.file("my data.db");
  on_server([&] { handler.state.database = db; });
  for (unsigned seed = 0; seed < 60; ++seed) {
    Choice choice(seed);
    const auto typed = some_run(choice, path, config, db);
    const bool named_there = typed[0] == "--socket" || typed.back() == config;
    cli.env.daemon_socket = named_there ? cli.dir.file("another.sock") : path;
    Words dry = typed;
    dry.emplace_back("--dry-run");
    const auto shown = ::testing::PrintToString(dry);
    const int planned = cli.run(dry);
    if (planned == cli::kFailed) continue;  // a text that is not UTF-8, which the daemon refuses
    ASSERT_EQ(planned, 0) << shown << cli.err.str();
    const auto next = proposed(cli);
    EXPECT_THAT(next, Not(Contains("--dry-run")));
    ASSERT_EQ(cli.run(next), 0) << shown << ::testing::PrintToString(next) << cli.err.str();
    on_server([&] {
      const auto &plan = handler.last_plan, &start = handler.last_start;
      EXPECT_EQ(plan.protocol_name, start.protocol_name) << shown;
      EXPECT_EQ(plan.parameters, start.parameters) << shown;
      EXPECT_EQ(plan.specimen_name, start.specimen_name) << shown;
      EXPECT_EQ(plan.operator_name, start.operator_name) << shown;
      EXPECT_EQ(plan.note, start.note) << shown;
    });
    // The last proposal must refer to the same daemon and the same database.
    const auto last = proposed(cli);
    for (const auto* where : {"--db", "--socket", "--config"}) {
      EXPECT_EQ(std::ranges::count(last, where), std::ranges::count(typed, where)) << shown;
    }
  }
}

TEST_F(Served, TheDaemonsHintIsForTheDaemonThatWasAsked) {
  on_server([this] { handler.next_error = Error(Errc::busy, "run 3 is going on"); });
  EXPECT_EQ(cli.run({"pause", "--socket", path}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("next: lcrig status --socket " + path + "   ("));
}

TEST_F(Served, ASpecimenOfTheDaemonIsProposedForARunAndNotForARehearsal) {
  on_server([this] { handler.state.database = cli.dir.file("daemons.db"); });
  const auto file = cli.dir.file("stack.json");
  cli.run({"specimen", "show", "paper-1"});
  std::ofstream(file) << cli.out.str();
  ASSERT_EQ(cli.run({"specimen", "add", file, "--socket", path}), 0) << cli.err.str();
  const auto next = proposed(cli);
  EXPECT_THAT(next, ElementsAre("run", "static-frame", "--specimen", "paper-9", "--dry-run",
                                "--socket", path));
}

// The shipped files, real planning, and real rehearsals in a folder with a blank in its name.
class Proposals : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.bench_rig = &bench_rig;
    const fs::path data = cli.dir.file("data");
    fs::create_directories(data);
    fs::create_directory_symlink(fs::absolute("protocols/library"), data / "protocols");
    fs::create_directory_symlink(fs::absolute("model/library"), data / "specimens");
    fs::create_directory_symlink(fs::absolute("daemon/rig/benches"), data / "benches");
    cli.variables["LCRIG_DATA"] = data.string();
    fs::create_directories(fs::path(db).parent_path());
  }
  Cli cli;
  std::string db = cli.dir.file("my runs/lcrig.db");
};

TEST_F(Proposals, LeadFromTheFileToTheResultsWithTheSameOptions) {
  cli.rehearsal = &rehearse;
  const Words asked{"-p", "repeats=1", "-p", "readings=2", "-p", "levels=2", "--db", db};
  Words words{"protocol", "check", "static-frame"};
  words.insert(words.end(), asked.begin(), asked.end());
  for (const auto* verb : {"check", "plan", "rehearse", "export", ""}) {
    ASSERT_EQ(cli.run(words), 0) << ::testing::PrintToString(words) << cli.err.str();
    if (*verb == '\0' || words[0] == "export") break;
    words = proposed(cli);
    EXPECT_THAT(words, Contains(db));
    if (words[0] == "rehearse") {
      EXPECT_THAT(words,
                  AllOf(Contains("repeats=1"), Contains("readings=2"), Contains("levels=2")));
    }
    if (words[0] == "export") words[3] = cli.dir.file("results");
  }
  EXPECT_TRUE(fs::exists(cli.dir.file("results") + "/lcr.csv"));
}

TEST_F(Proposals, ARehearsalHasWhatThePlanHad) {
  FakeRehearsal::answer = RehearseResult();
  FakeRehearsal::answer->exit_status = ExitStatus::success;
  const auto bench = cli.dir.file("my bench.json");
  fs::copy_file("daemon/rig/benches/paper.json", bench);
  for (unsigned seed = 0; seed < 16; ++seed) {
    Choice choice(seed);
    Words words{"protocol", "plan", "static-frame"};
    if (choice.yes()) words.insert(words.end(), {"-p", "readings=20"});
    if (choice.yes()) words.insert(words.end(), {"-p", "repeats=2"});
    const bool other_bench = choice.yes(), other_db = choice.yes();
    const std::string specimen = choice.yes() ? "paper-2" : "paper-1";
    words.insert(words.end(), {"--specimen", specimen});
    if (other_bench) words.insert(words.end(), {"--bench", bench});
    if (other_db) words.insert(words.begin(), {"--db", db});
    ASSERT_EQ(cli.run(words), 0) << cli.err.str();
    FakeRehearsal::last = RehearseRequest();
    ASSERT_EQ(cli.run(proposed(cli)), 0) << cli.err.str();
    const auto& had = FakeRehearsal::last;
    EXPECT_EQ(static_cast<std::ptrdiff_t>(had.parameters.size()),
              std::ranges::count(words, std::string("-p")));
    EXPECT_EQ(had.specimen_name, specimen);
    EXPECT_EQ(had.bench, other_bench ? bench : "paper");
    EXPECT_EQ(had.db_path == db, other_db);
  }
}

TEST_F(Proposals, ARefusedRehearsalShowsWhatCanBeChanged) {
  FakeRehearsal::answer = fail(Errc::invalid_request, "/steps/0: too fast");
  ASSERT_EQ(cli.run({"rehearse", "static-frame", "-p", "readings=20", "--specimen", "paper-2"}),
            cli::kProtocol);
  EXPECT_THAT(proposed(cli), ElementsAre("protocol", "show", "static-frame"));
  EXPECT_EQ(cli.run(proposed(cli)), 0) << cli.err.str();
}

TEST_F(Proposals, AnUnknownSpecimenIsLookedForInTheSameDatabase) {
  ASSERT_EQ(cli.run({"rehearse", "static-frame", "--specimen", "papr-1", "--db", db}),
            cli::kFailed);
  EXPECT_THAT(proposed(cli), ElementsAre("specimen", "list", "--db", db));
}

TEST_F(Proposals, APlanOfWeightsIsSilentOnWhatOnlyAFrameCanDo) {
  ASSERT_EQ(cli.run({"protocol", "plan", "static-weights", "--specimen", "paper-1"}), 0)
      << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("at worst      1.257 N of the 2 N allowed, if each weight"));
  for (const auto* words : {"load cell", "link or host", "frozen", "STOP", "travel  "}) {
    EXPECT_THAT(cli.out.str(), Not(HasSubstr(words)));
  }
  ASSERT_EQ(cli.run({"protocol", "plan", "static-weights", "--json"}), 0);
  const auto plan = nlohmann::json::parse(cli.out.str());
  EXPECT_TRUE(plan["force_uncertainty_N"].is_null());
  EXPECT_TRUE(plan["watch"].is_null());
  ASSERT_EQ(cli.run({"protocol", "plan", "static-frame", "--specimen", "paper-1"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("load cell"), HasSubstr("frozen")));
}

}  // namespace
}  // namespace lcrig
