// SPDX-License-Identifier: Apache-2.0
// Commands that work on recorded runs.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/without_rights.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.variables["LCRIG_DB"] = path;
    auto db = open_read_write(path);
    ASSERT_TRUE(db) << db.error().what;
    RunRow row;
    row.protocol_name = "press";
    row.protocol_text = "{}";
    row.specimen_name = "paper-1";
    row.specimen_text = "{}";
    row.operator_name = "Ada";
    row.simulated = true;
    row.started_unix_ns = 1'767'225'600'000'000'000;  // 2026-01-01
    auto run = insert_run(*db, row);
    ASSERT_TRUE(run) << run.error().what;
    ASSERT_EQ(*run, 1);
    RunEnd end;
    end.status = ExitStatus::abort;
    end.reason = "smoke";
    end.ended_unix_ns = row.started_unix_ns + 5'000'000'000;
    ASSERT_TRUE(insert_run_end(*db, 1, end));
    row.protocol_name = "open-end";
    ASSERT_TRUE(insert_run(*db, row));
  }
  // Keeps run 2 going until the lock is released.
  WriterLock record_the_second() const {
    auto lock = WriterLock::acquire(path).value();
    EXPECT_TRUE(lock.begin_run(2));
    return lock;
  }
  json verified(const std::vector<std::string>& options, int code) {
    std::vector<std::string> args{"verify", "--json"};
    args.insert(args.end(), options.begin(), options.end());
    EXPECT_EQ(cli.run(args), code) << cli.err.str();
    return json::parse(cli.out.str(), nullptr, false);
  }
  // Changes the database as somebody would who gets around the triggers.
  void change(const std::string& sql) const {
    auto db = Database::open(path, Database::Mode::read_write_create);
    ASSERT_TRUE(db);
    ASSERT_TRUE(db->execute("DROP TRIGGER run_end_no_update; " + sql));
  }
  static json package(const std::string& folder) {
    std::ifstream file(folder + "/datapackage.json");
    return json::parse(file, nullptr, false);
  }
  support::Cli cli;
  std::string path = cli.dir.file("runs.db");
};

TEST_F(Runs, AreListedWithAndWithoutTheVerb) {
  ASSERT_EQ(cli.run({"runs"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("press"), HasSubstr("abort"), HasSubstr("simulated"),
                                   HasSubstr("2026-01-01T00:00:00Z")));
  ASSERT_EQ(cli.run({"runs", "list", "--json"}), 0);
  const auto runs = json::parse(cli.out.str())["runs"];
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0]["exit_status"], nullptr);  // newest first
  EXPECT_EQ(runs[0]["goes_on"], false);
  EXPECT_EQ(runs[1]["exit_status"], "abort");
  EXPECT_EQ(runs[1]["ended"], "2026-01-01T00:00:05Z");
}

TEST_F(Runs, AreFoundAgain) {
  {
    const auto db = open_read_write(path).value();
    RunRow row;
    row.protocol_name = "press";
    row.specimen_name = "paper-2";
    row.operator_name = "Bob";
    row.started_unix_ns = 1'780'000'000'000'000'000;  // 2026-05-28
    ASSERT_EQ(insert_run(db, row).value(), 3);
    ASSERT_TRUE(insert_run_end(db, 3, RunEnd()));
  }
  const auto found = [this](std::vector<std::string> options) {
    options.insert(options.begin(), {"runs", "list", "--json"});
    EXPECT_EQ(cli.run(options), 0) << cli.err.str();
    const auto answer = json::parse(cli.out.str());
    std::vector<int> numbers;
    for (const auto& run : answer["runs"]) numbers.push_back(run["run"].get<int>());
    return numbers;
  };
  using Numbers = std::vector<int>;
  EXPECT_EQ(found({}), Numbers({3, 2, 1}));
  EXPECT_EQ(found({"--specimen", "paper-1"}), Numbers({2, 1}));
  EXPECT_EQ(found({"--protocol", "press"}), Numbers({3, 1}));
  EXPECT_EQ(found({"--operator", "Bob"}), Numbers({3}));
  EXPECT_EQ(found({"--status", "success"}), Numbers({3}));
  EXPECT_EQ(found({"--status", "abort"}), Numbers({1}));
  EXPECT_EQ(found({"--since", "2026-03-01"}), Numbers({3}));
  EXPECT_EQ(found({"--since", "2025-12-30 12:00"}), Numbers({3, 2, 1}));
  EXPECT_EQ(found({"--specimen", "paper-1", "--protocol", "press"}), Numbers({1}));
  EXPECT_EQ(found({"--specimen", "paper-9"}), Numbers({}));
  EXPECT_EQ(found({"--status", "cut-off"}), Numbers({2}));
  EXPECT_EQ(found({"--status", "running"}), Numbers({}));
  const auto lock = record_the_second();
  EXPECT_EQ(found({"--status", "cut-off"}), Numbers({}));
  EXPECT_EQ(found({"--status", "running"}), Numbers({2}));
}

// The clock of every rehearsal begins at the same instant: by it none would be one of last week.
TEST_F(Runs, OfRehearsalsAreShownAndFoundByTheTimeOfTheirMaking) {
  {
    const auto db = open_read_write(path).value();
    RunRow row;
    row.protocol_name = "press";
    row.started_unix_ns = 1'767'225'600'000'000'000;  // 2026-01-01
    row.made_unix_ns = 1'780'000'000'000'000'000;  // 2026-05-28
    ASSERT_EQ(insert_run(db, row).value(), 3);
    ASSERT_TRUE(insert_run_end(db, 3, RunEnd()));
  }
  ASSERT_EQ(cli.run({"runs", "list", "--since", "2026-05-01"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("2026-05-28T20:26:40Z"), Not(HasSubstr("2026-01"))));
  ASSERT_EQ(cli.run({"runs", "show", "3", "--json"}), 0) << cli.err.str();
  const auto shown = json::parse(cli.out.str());
  EXPECT_EQ(shown["started"], "2026-01-01T00:00:00Z");
  EXPECT_EQ(shown["made"], "2026-05-28T20:26:40Z");
  const auto folder = cli.dir.file("out");
  ASSERT_EQ(cli.run({"export", "3", "-o", folder}), 0) << cli.err.str();
  EXPECT_EQ(package(folder)["lcrig"]["started"], "2026-01-01T00:00:00.000+00:00");
  EXPECT_EQ(package(folder)["lcrig"]["made"], "2026-05-28T20:26:40.000+00:00");
  ASSERT_EQ(cli.run({"runs", "show", "1", "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["made"], "2026-01-01T00:00:00Z") << "a run that is none";
}

TEST_F(Runs, AreFoundByTheirTagsAndTheirUuid) {
  ASSERT_EQ(cli.run({"runs", "tag", "1", "thesis", "good"}), 0) << cli.err.str();
  EXPECT_EQ(cli.out.str(), "run 1: good thesis\n");
  ASSERT_EQ(cli.run({"runs", "list", "--tag", "thesis", "--json"}), 0) << cli.err.str();
  const auto found = json::parse(cli.out.str())["runs"];
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0]["tags"].dump(), R"(["good","thesis"])");
  const auto uuid = found[0]["uuid"].get<std::string>();
  EXPECT_EQ(cli.run({"runs", "list", "--tag", ""}), kUsage);
  ASSERT_EQ(cli.run({"runs", "list", "--tag", "good"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("#good  #thesis"), Not(HasSubstr("open-end"))));
  ASSERT_EQ(cli.run({"runs", "tag", "--remove", uuid, "good", "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str()).dump(), R"({"run":1,"tags":["thesis"]})");
  ASSERT_EQ(cli.run({"runs", "show", uuid.substr(0, 13), "--json"}), 0) << cli.err.str();
  const auto shown = json::parse(cli.out.str());
  EXPECT_EQ(shown["run"], 1);
  EXPECT_EQ(shown["uuid"], uuid);
  EXPECT_EQ(shown["recorded_run"], 1);
  EXPECT_TRUE(shown["copied_from"].is_null());
  EXPECT_EQ(verified({uuid}, 0)["intact"], true);
  EXPECT_EQ(cli.run({"runs", "tag", "1", "two words"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("a tag is one word"));
  EXPECT_EQ(cli.run({"runs", "tag", "1"}), kUsage);
  EXPECT_THAT(cli.err.str(), HasSubstr("TAG is missing"));
}

TEST_F(Runs, AreCopiedIntoAnotherDatabase) {
  const auto to = cli.dir.file("thesis.db");
  ASSERT_EQ(cli.run({"runs", "copy", "1", "--to", to, "--json"}), 0) << cli.err.str();
  const auto copied = json::parse(cli.out.str())["runs"];
  ASSERT_EQ(copied.size(), 1U);
  EXPECT_EQ(copied[0]["run"], 1);
  EXPECT_EQ(copied[0]["to"], 1);
  EXPECT_EQ(cli.run({"runs", "copy", "1", "--to", to}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("run 1 is there already, as run 1 (same uuid)"));
  EXPECT_EQ(cli.run({"runs", "copy", "1", "last", "--to", to}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("run 2 was cut off"));
  EXPECT_EQ(cli.run({"runs", "copy", "--to", to}), kUsage);
  EXPECT_EQ(cli.run({"runs", "copy", "1", "--to", path}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("is the database itself"));
  ASSERT_EQ(cli.run({"--db", to, "runs", "show", copied[0]["uuid"].get<std::string>(), "--json"}),
            0);
  const auto shown = json::parse(cli.out.str());
  EXPECT_EQ(shown["copied_from"], std::filesystem::canonical(path).string());
  EXPECT_EQ(shown["reason"], "smoke");
  const auto folder = cli.dir.file("out");
  ASSERT_EQ(cli.run({"--db", to, "export", "1", "-o", folder}), 0) << cli.err.str();
  EXPECT_EQ(package(folder)["lcrig"]["uuid"], copied[0]["uuid"]);
}

TEST_F(Runs, AreNotLookedForByWhatIsNoDayOrNoStatus) {
  for (const char* since : {"yesterday", "2026-02-30", "18:00", "2026-01-31x"}) {
    EXPECT_EQ(cli.run({"runs", "list", "--since", since}), kUsage) << since;
    EXPECT_THAT(cli.err.str(), HasSubstr("no such day"));
  }
  EXPECT_EQ(cli.run({"runs", "list", "--status", "failed"}), kUsage);
  EXPECT_THAT(cli.err.str(), HasSubstr("success"));
}

TEST_F(Runs, ThatNobodyHasAreMissedByName) {
  EXPECT_EQ(cli.run({"runs", "list", "--specimen", "paper1"}), kOk);
  EXPECT_THAT(cli.err.str(),
              HasSubstr("--specimen paper1: no run has it; did you mean 'paper-1'?"));
  EXPECT_EQ(cli.run({"runs", "list", "--operator", "Bob", "--json"}), kOk);
  EXPECT_EQ(cli.out.str(), "{\"runs\":[]}\n");
  EXPECT_THAT(cli.err.str(), HasSubstr("--operator Bob: no run has it\n"));
  EXPECT_EQ(cli.run({"runs", "list", "--specimen", "paper-1", "--status", "success"}), kOk);
  EXPECT_EQ(cli.err.str(), "") << "there are some, which ended otherwise";
}

TEST_F(Runs, AreFoundByTheTimeThatTheListShows) {
  EXPECT_EQ(cli.run({"runs", "list", "--since", "2026-01-01T00:00:00Z"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("press"));
  EXPECT_EQ(cli.run({"runs", "list", "--since", "2099-01-01T00:00:00Z"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), Not(HasSubstr("press")));
}

TEST_F(Runs, AreShownWithTheirNotes) {
  ASSERT_EQ(cli.run({"runs", "note", "1", "probe was dusty"}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"runs", "show", "1", "--json"}), 0) << cli.err.str();
  const auto run = json::parse(cli.out.str());
  EXPECT_EQ(run["operator"], "Ada");
  ASSERT_EQ(run["notes"].size(), 1U);
  EXPECT_EQ(run["notes"][0]["text"], "probe was dusty");
  EXPECT_EQ(run["notes"][0]["operator"], login_name());
}

TEST_F(Runs, WithoutAnEndAreCutOffUnlessTheyGoOn) {
  ASSERT_EQ(cli.run({"runs"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("cut off"), Not(HasSubstr("running"))));
  EXPECT_EQ(cli.run({"runs", "note", "2", "x"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("was cut off"));
  const auto lock = record_the_second();
  ASSERT_EQ(cli.run({"runs"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("running"), Not(HasSubstr("cut off"))));
  ASSERT_EQ(cli.run({"runs", "--json"}), 0);
  EXPECT_EQ(json::parse(cli.out.str())["runs"][0]["goes_on"], true);
}

TEST_F(Runs, ThatGoOnTakeNoNote) {
  const auto lock = record_the_second();
  EXPECT_EQ(cli.run({"runs", "note", "last", "x"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("a daemon records into it, or a rehearsal"));
}

TEST_F(Runs, ThatDoNotExistAreRefusedByEveryCommand) {
  for (const auto& args : {std::vector<std::string>{"runs", "show", "99"},
                           {"runs", "note", "99", "x"},
                           {"export", "99", "-o", cli.dir.file("out")},
                           {"analyze", "99"},
                           {"verify", "99"},
                           {"verify", "first"}}) {
    EXPECT_EQ(cli.run(args), kFailed) << ::testing::PrintToString(args);
    EXPECT_THAT(cli.err.str(), HasSubstr("lcrig runs"));
  }
  EXPECT_FALSE(std::filesystem::exists(cli.dir.file("out")));
}

TEST_F(Runs, AreExportedToAFolder) {
  const auto folder = cli.dir.file("out");
  ASSERT_EQ(cli.run({"export", "1", "-o", folder, "--json"}), 0) << cli.err.str();
  EXPECT_TRUE(std::filesystem::exists(folder + "/lcr.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/datapackage.json"));
  EXPECT_EQ(json::parse(cli.out.str())["run"], 1);
}

TEST_F(Runs, TheLastOneIsMeantWhereNoneIsNamed) {
  EXPECT_EQ(verified({}, kFailed)["run"], 2);
  ASSERT_EQ(cli.run({"export", "-o", cli.dir.file("newest"), "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["run"], 2);
}

TEST_F(Runs, AreVerified) {
  EXPECT_EQ(verified({"1"}, 0)["intact"], true);
  change("UPDATE run_end SET reason = 'fine'");
  EXPECT_EQ(cli.run({"verify", "1"}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("a value was changed"),
                                   HasSubstr("next: restore the database from a backup")));
  const auto broken = verified({"1"}, kFailed);
  EXPECT_TRUE(broken["anchor"].is_null()) << "it would be that of the changed rows";
  EXPECT_TRUE(broken["last_hash"].is_null());
  EXPECT_EQ(broken["ended"], true);
}

TEST_F(Runs, WithoutAnEndAreVerifiedOnlyWhileTheyGoOn) {
  EXPECT_EQ(cli.run({"verify", "2"}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("cut off"), HasSubstr("--anchor")));
  const auto lock = record_the_second();
  EXPECT_EQ(cli.run({"verify", "2"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("goes on, intact so far"));
  EXPECT_EQ(verified({"2"}, 0)["goes_on"], true);
}

TEST_F(Runs, AreComparedWithAnAnchor) {
  const auto anchor = verified({"1"}, 0)["anchor"].get<std::string>();
  EXPECT_EQ(cli.run({"verify", "1", "--anchor", anchor}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("anchor " + anchor));
  std::string other = anchor;
  other.back() = other.back() == '0' ? '1' : '0';
  EXPECT_EQ(cli.run({"verify", "1", "--anchor", other}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("written anew"));
  EXPECT_EQ(cli.run({"verify", "1", "--anchor", "9" + anchor}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("cut off"));
  EXPECT_THAT(cli.err.str(), HasSubstr("next: look whether the anchor is that of run 1"));
  EXPECT_EQ(cli.run({"verify", "1", "--anchor", "2:ab"}), kUsage);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("2:ab"), HasSubstr("64 hex digits")));
}

TEST_F(Runs, AreNotRestoredForTheAnchorOfAnotherOne) {
  {
    const auto db = open_read_write(path).value();
    ASSERT_TRUE(insert_run_end(db, 2, RunEnd()));
  }
  const auto anchor = verified({"2"}, 0)["anchor"].get<std::string>();
  EXPECT_EQ(cli.run({"verify", "1", "--anchor", anchor}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("the anchor that was given is that of run 2"),
                                   HasSubstr("next: lcrig verify 2 --anchor " + anchor),
                                   Not(HasSubstr("restore"))));
}

TEST_F(Runs, AreExportedWithWhatVerifySays) {
  const auto folder = cli.dir.file("out");
  ASSERT_EQ(cli.run({"export", "1", "-o", folder, "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["intact"], true);
  EXPECT_EQ(package(folder)["lcrig"]["chain"]["anchor"], verified({"1"}, 0)["anchor"]);
  change("UPDATE run_end SET reason = 'fine'");
  ASSERT_EQ(cli.run({"export", "1", "-o", folder, "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["intact"], false);
  EXPECT_THAT(cli.err.str(), HasSubstr("run 1 is not as it was recorded: link 2"));
  EXPECT_EQ(package(folder)["lcrig"]["chain"]["intact"], false);
  EXPECT_TRUE(package(folder)["lcrig"]["chain"]["anchor"].is_null());
}

// The first page is intact, so the file can be opened, but the pages after it are damaged.
TEST_F(Runs, OfADamagedFileABackupIsProposed) {
  {
    auto db = Database::open(path, Database::Mode::read_write_create);
    ASSERT_TRUE(db);
    ASSERT_TRUE(db->execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  }
  const auto events =
      open_read_only(path)->integer("SELECT rootpage FROM sqlite_schema WHERE name = 'event'");
  ASSERT_TRUE(events);
  constexpr std::int64_t kPage = 4096;
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp((*events - 1) * kPage);
  file << std::string(kPage, '\xff');
  file.close();
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"export", "1", "-o", cli.dir.file("out")},
           {"verify", "1"},
           {"analyze", "1"},
           {"runs", "copy", "1", "--to", cli.dir.file("copy.db")}}) {
    EXPECT_EQ(cli.run(words), kFailed) << words[0];
    EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("is damaged"), HasSubstr("next: lcrig restore"),
                                     Not(HasSubstr("ANOTHER-FOLDER"))))
        << words[0];
  }
}

// Advice must not depend on how a message begins: here with the name of the database, or `--to`.
TEST_F(Runs, AreAdvisedOnByWhatIsWrongNotByItsWords) {
  const auto taken = path + "-out";
  std::ofstream(taken) << "a file";
  EXPECT_EQ(cli.run({"export", "1", "-o", taken}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr(taken), Not(HasSubstr("restore"))));
  EXPECT_EQ(cli.run({"runs", "copy", "1", "--to", taken}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("next: give another --to"));
  change("UPDATE run_end SET reason = 'fine'");
  EXPECT_EQ(cli.run({"runs", "copy", "1", "--to", "run"}), kFailed);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("run 1 is not as it was recorded"), Not(HasSubstr("another --to"))));
  EXPECT_FALSE(std::filesystem::exists("run"));
}

TEST_F(Runs, ChangesAreInTheFileItselfWithoutADaemon) {
  const auto log_bytes = [this] { return std::filesystem::file_size(path + "-wal"); };
  ASSERT_EQ(cli.run({"runs", "tag", "1", "thesis"}), 0) << cli.err.str();
  EXPECT_EQ(log_bytes(), 0U);
  ASSERT_EQ(cli.run({"runs", "note", "1", "dusty"}), 0) << cli.err.str();
  EXPECT_EQ(log_bytes(), 0U);
}

TEST_F(Runs, ANoteWaitsForWhoHoldsTheFile) {
  auto other = Database::open(path, Database::Mode::read_write_create);
  ASSERT_TRUE(other);
  ASSERT_TRUE(other->execute("BEGIN IMMEDIATE"));
  EXPECT_EQ(cli.run({"runs", "note", "1", "two words"}), kFailed);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("another program holds it"), Not(HasSubstr("BEGIN")),
                    HasSubstr("next: lcrig runs note 1 'two words'   (when the other program")));
}

TEST_F(Runs, ANoteIntoTheFileOfADaemonThatMayNotBeWrittenNamesTheSocket) {
  const WithoutFileRights rights;
  const auto lock = WriterLock::acquire(path);
  ASSERT_TRUE(lock);
  namespace fs = std::filesystem;
  fs::permissions(path, fs::perms::owner_read);
  EXPECT_EQ(cli.run({"runs", "note", "1", "dusty", "--db", path}), kFailed);
  fs::permissions(path, fs::perms::owner_all);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("a daemon records into it"),
                                   HasSubstr("next: lcrig runs note 1 dusty --socket SOCKET"),
                                   Not(HasSubstr("change the rights"))));
}

TEST_F(Runs, AnExportOfARunThatGoesOnSaysSo) {
  const auto folder = cli.dir.file("results");
  {
    const auto lock = record_the_second();
    ASSERT_EQ(cli.run({"export", "last", "-o", folder, "--json"}), 0) << cli.err.str();
    EXPECT_EQ(json::parse(cli.out.str())["goes_on"], true);
    EXPECT_THAT(cli.err.str(), HasSubstr("run 2 goes on: this is what was recorded until now"));
    const auto package = json::parse(std::ifstream(folder + "/datapackage.json"));
    EXPECT_EQ(package["lcrig"]["chain"]["goes_on"], true);
    EXPECT_TRUE(package["lcrig"]["ended"].is_null());
    ASSERT_EQ(cli.run({"export", "last", "-o", "-"}), 0);
    EXPECT_THAT(cli.err.str(), HasSubstr("run 2 goes on"));
  }
  EXPECT_EQ(cli.run({"export", "1", "-o", cli.dir.file("first"), "--json"}), 0);
  EXPECT_EQ(json::parse(cli.out.str())["goes_on"], false);
}

TEST(RunListingLine, IsWhatAJsonValueWouldPrint) {
  RunListing run;
  run.run = 12;
  run.protocol_name = "creep";
  run.specimen_name = "a \"b\" \\ c\n\xc3\xa4";
  run.operator_name = "ada\xff";  // not UTF-8
  run.reason = "force 3 N\x1b[2J";
  run.tags = {"good", "t\"2"};
  run.lcr_readings = 42;
  run.unproven_readings = 26;
  run.events = 7;
  for (const bool ended : {false, true}) {
    if (ended) {
      run.exit_status = ExitStatus::success;
      run.ended_unix_ns = 1'769'853'600'000'000'000;
      run.uuid = "11111111-2222-4333-8444-555555555555";
      run.simulated = true;
    }
    const std::string line = run_listing_line(run);
    const json parsed = json::parse(line, nullptr, false);
    ASSERT_FALSE(parsed.is_discarded()) << line;
    EXPECT_EQ(json_line(parsed), line) << "sorted, and escaped as all JSON of this program";
    EXPECT_EQ(parsed["specimen"], run.specimen_name);
    EXPECT_EQ(parsed["operator"], "ada\xef\xbf\xbd");
    EXPECT_EQ(parsed["tags"], json(run.tags));
    EXPECT_EQ(parsed["lcr_readings"], 42);
    EXPECT_EQ(parsed["goes_on"], false);
    EXPECT_EQ(parsed["exit_status"], ended ? json("success") : json(nullptr));
    EXPECT_EQ(parsed["uuid"].is_null(), !ended);
    EXPECT_EQ(parsed["ended"], ended ? json("2026-01-31T10:00:00Z") : json(nullptr));
    EXPECT_EQ(parsed["unproven_readings"], 26);
    EXPECT_EQ(parsed["made"], parsed["started"]);
    EXPECT_EQ(parsed.size(), 18U);
  }
}

}  // namespace
}  // namespace lcrig::cli
