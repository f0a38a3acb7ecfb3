// SPDX-License-Identifier: Apache-2.0
// Which database file a command uses, with a daemon, without one, and with one that hangs.
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/unit/tools/served.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A daemon whose database is in no default place.
class ServedRuns : public support::Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    make(daemons, "of-the-daemon");
    make(other, "of-mine");
    on_server([this] { handler.state.database = daemons; });
  }
  static void make(const std::string& path, const std::string& specimen) {
    auto db = open_read_write(path);
    ASSERT_TRUE(db) << db.error().what;
    RunRow row;
    row.specimen_name = specimen;
    ASSERT_TRUE(insert_run(*db, row));
    ASSERT_TRUE(insert_run_end(*db, 1, RunEnd()));
  }
  std::string daemons = cli.dir.file("elsewhere.db"), other = cli.dir.file("mine.db");
};

TEST_F(ServedRuns, AreThoseOfTheDaemonAtTheSocket) {
  cli.env.daemon_socket = cli.dir.file("no-such.sock");
  struct Case {
    std::vector<std::string> args;
    std::string says;
  };
  for (const auto& [args, says] :
       {Case{{"runs", "--socket", path}, "of-the-daemon"},
        Case{{"runs", "show", "1", "--socket", path}, "of-the-daemon"},
        Case{{"export", "1", "-o", cli.dir.file("out"), "--socket", path}, "lcr.csv"},
        Case{{"analyze", "9", "--socket", path}, "elsewhere.db: no run 9"},
        Case{{"report", "9", "--socket", path}, "elsewhere.db: no run 9"},
        Case{{"verify", "9", "--socket", path}, "elsewhere.db: no run 9"}}) {
    cli.run(args);
    EXPECT_THAT(cli.out.str() + cli.err.str(), HasSubstr(says)) << args[0];
    EXPECT_THAT(cli.err.str(), Not(HasSubstr("another database"))) << args[0];
  }
  cli.variables["LCRIG_SOCKET"] = path;
  EXPECT_EQ(cli.run({"runs"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("of-the-daemon"));
}

TEST_F(ServedRuns, OfAnotherFileAreReadAndBothAreNamed) {
  for (const bool by_variable : {false, true}) {
    if (by_variable) cli.variables["LCRIG_DB"] = other;
    EXPECT_EQ(by_variable ? cli.run({"runs"}) : cli.run({"runs", "--db", other}), 0);
    EXPECT_THAT(cli.out.str(), HasSubstr("of-mine"));
    EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("uses " + other), HasSubstr("another database, "),
                                     HasSubstr(daemons), HasSubstr(path)));
  }
  EXPECT_EQ(cli.run({"runs", "--socket", path}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("of-the-daemon")) << "a socket that is named goes first";
}

TEST_F(ServedRuns, OfTheDaemonsOwnFileAreReadWithoutWords) {
  EXPECT_EQ(cli.run({"runs", "--db", cli.dir.file("./elsewhere.db")}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("of-the-daemon"));
  EXPECT_EQ(cli.err.str(), "");
}

TEST_F(ServedRuns, AreNotedByTheDaemonAndOtherFilesDirectly) {
  EXPECT_EQ(cli.run({"runs", "note", "last", "dusty"}), 0) << cli.err.str();
  EXPECT_EQ(cli.run({"runs", "note", "1", "mine", "--db", other}), 0) << cli.err.str();
  on_server([this] { EXPECT_THAT(handler.calls, ElementsAre("note 1 dusty")); });
  const auto db = open_read_only(other).value();
  EXPECT_EQ(get_run_notes(db, 1).value().at(0).text, "mine");
}

// A daemon at another socket, or one that hangs, holds the lock.
TEST_F(ServedRuns, OfAFileThatSomebodyRecordsIntoAreNotNotedBesideHim) {
  const auto lock = WriterLock::acquire(other);
  ASSERT_TRUE(lock);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"runs", "note", "1", "mine"}, {"runs", "tag", "1", "mine"}}) {
    auto line = words;
    line.insert(line.end(), {"--db", other});
    EXPECT_EQ(cli.run(line), cli::kFailed);
    EXPECT_THAT(cli.err.str(),
                AllOf(HasSubstr("a daemon records into it"),
                      HasSubstr("next: lcrig runs " + line[1] + " 1 mine --socket")));
  }
  EXPECT_EQ(cli.run({"runs", "show", "1", "--db", other}), 0) << "reading is free";
}

// Its daemon is at another socket.
TEST_F(ServedRuns, OfAFileThatSomebodyRecordsIntoHaveAQueueThatHeKnowsBetter) {
  cli.env.daemon_socket = cli.dir.file("none.sock");
  EXPECT_EQ(cli.run({"queue", "list", "--db", other}), 0) << cli.err.str();
  EXPECT_THAT(cli.err.str(), HasSubstr("no daemon answers"));
  const auto lock = WriterLock::acquire(other);
  ASSERT_TRUE(lock);
  EXPECT_EQ(cli.run({"queue", "list", "--db", other}), 0) << cli.err.str();
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("was not reached; name its --socket"),
                                   Not(HasSubstr("no daemon answers"))));
}

TEST_F(ServedRuns, AreMadeOnlyInTheDatabaseThatTheDaemonHas) {
  cli.add_data("protocols/press.json", "{}");
  using Line = std::vector<std::string>;
  for (const Line& typed :
       {Line{"run", "press", "--specimen", "paper-1"}, Line{"resume"}, Line{"resume", "1"},
        Line{"watch"}, Line{"confirm"}, Line{"run", "press", "--specimen", "s", "--dry-run"}}) {
    Line words = typed;
    words.insert(words.end(), {"--db", other});
    EXPECT_EQ(cli.run(words), cli::kUsage) << typed[0];
    EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("--db " + other), HasSubstr(daemons),
                                     HasSubstr("next: type it again without --db")));
  }
  on_server([this] { EXPECT_THAT(handler.calls, ElementsAre()); });
  const Line same{"--db", cli.dir.file("./elsewhere.db")};
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1", same[0], same[1]}), 0)
      << cli.err.str();
  EXPECT_EQ(cli.run({"resume", "1", same[0], same[1]}), 0) << cli.err.str();
}

TEST_F(ServedRuns, AreStoppedAndLookedAtWhateverDatabaseIsNamed) {
  for (const auto* verb : {"pause", "abort", "freeze", "status"}) {
    EXPECT_EQ(cli.run({verb, "--db", other}), 0) << cli.err.str();
    EXPECT_THAT(cli.err.str(), HasSubstr("has another database, " + daemons)) << verb;
    EXPECT_THAT(cli.err.str(), Not(HasSubstr("resume --db"))) << "it would be refused";
  }
  on_server([this] { EXPECT_THAT(handler.calls, ElementsAre("pause", "abort ", "freeze ")); });
}

// $LCRIG_DB belongs to the shell and not to this command. The run is made, and the next command
// finds it where it is.
TEST_F(ServedRuns, AreFoundWhereTheyWereMadeWhateverFileTheShellNames) {
  cli.add_data("protocols/press.json", "{}");
  cli.variables["LCRIG_DB"] = other;
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), 0) << cli.err.str();
  EXPECT_THAT(cli.err.str(), HasSubstr("next: lcrig export 7 --db " + daemons + "\n"));
  EXPECT_EQ(cli.run({"status"}), 0);
  EXPECT_THAT(cli.err.str(), HasSubstr("$LCRIG_DB " + other + ": the daemon at " + path +
                                       " has another database"));
  cli.variables["LCRIG_DB"] = cli.dir.file("./elsewhere.db");
  EXPECT_EQ(cli.run({"run", "press", "--specimen", "paper-1"}), 0) << cli.err.str();
  EXPECT_THAT(cli.err.str(), HasSubstr("next: lcrig export 7\n"));
}

TEST_F(ServedRuns, OfADaemonThatDoesNotSayWhichFileAreThoseOfTheDefault) {
  on_server([this] { handler.state.database = "relative.db"; });
  cli.env.daemon_db = other;
  EXPECT_EQ(cli.run({"runs"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("of-mine"));
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("does not say"), HasSubstr("uses " + other)));
}

// Listens but never accepts or answers, like a daemon that was stopped with SIGSTOP.
class Deaf : public ::testing::Test {
 protected:
  void SetUp() override {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, path.size());
    fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(fd, 0), 0);
    cli.env.daemon_socket = path;
    cli.env.daemon_db = cli.dir.file("default.db");
    cli.env.daemon_patience = std::chrono::milliseconds(50);
    cli.env.stop_hint_after = cli.env.status_patience = std::chrono::milliseconds(30);
    cli.env.stop_patience = std::chrono::milliseconds(90);
    ASSERT_TRUE(open_read_write(cli.env.daemon_db));
  }
  void TearDown() override { ::close(fd); }
  support::Cli cli;
  std::string path = cli.dir.file("deaf.sock");
  int fd = -1;
};

TEST_F(Deaf, DaemonsDoNotHoldAReadingCommandUp) {
  std::vector<cli::ControlClient> queue;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cli.run({"runs"}), 0);
    EXPECT_THAT(cli.err.str(),
                AllOf(HasSubstr("cannot reach the daemon at " + path),
                      AnyOf(HasSubstr("no answer in 0.05 s"), HasSubstr("it takes nothing")),
                      HasSubstr("uses " + cli.env.daemon_db.string())));
    auto client = cli::ControlClient::connect(path, cli.clock, std::chrono::milliseconds(20));
    if (client) queue.push_back(std::move(*client));
  }
  EXPECT_THAT(cli.err.str(), HasSubstr("it takes nothing")) << "the queue is full by now";
}

// A person waits at the frame, and must be told to stop it by hand.
TEST_F(Deaf, DaemonsLeaveTheEmergencyStopToWhoWantsToStop) {
  std::vector<cli::ControlClient> queue;
  for (int i = 0; i < 3; ++i) {
    for (const std::vector<std::string>& words : {std::vector<std::string>{"abort"},
                                                  {"freeze"},
                                                  {"pause"},
                                                  {"stop", "--after", "level"},
                                                  {"stop", "--after", "run"}}) {
      EXPECT_EQ(cli.run(words), cli::kUnreachable) << words[0];
      const std::string said = cli.err.str();
      EXPECT_THAT(said, AllOf(HasSubstr("no answer yet: if the frame moves, stop it at the machine "
                                        "(E-stop)\n"),
                              HasSubstr("next: if the frame moves: stop it at the machine")));
      EXPECT_EQ(said.find("no answer yet"), said.rfind("no answer yet")) << "once";
    }
    auto client = cli::ControlClient::connect(path, cli.clock, std::chrono::milliseconds(20));
    if (client) queue.push_back(std::move(*client));
  }
}

TEST_F(Deaf, DaemonsAreToldOfByStatusBeforeLong) {
  EXPECT_EQ(cli.run({"status"}), cli::kUnreachable);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("no answer in 0.03 s"),
                                   HasSubstr("next: systemctl status lcrigd\n")));
  EXPECT_NE(cli.run({"doctor"}), 0);
  EXPECT_THAT(cli.out.str(), AnyOf(HasSubstr("no answer in 0.03 s"), HasSubstr("takes nothing")));
}

// A note is permanent, so it must not be added to another run with the same number.
TEST_F(Deaf, DaemonsDatabasesAreNotReplacedByOthersInWriting) {
  const std::string mine = cli.dir.file("mine.db"), specimen = cli.dir.file("mine.json");
  cli.variables["LCRIG_DB"] = mine;  // counts if no daemon is named
  for (const std::string& db : {mine, cli.env.daemon_db.string()}) {
    auto made = open_read_write(db).value();
    ASSERT_TRUE(insert_run(made, RunRow()));
    ASSERT_TRUE(insert_run_end(made, 1, RunEnd()));
  }
  std::filesystem::copy_file("model/library/paper-1.json", specimen);
  const auto expect_unwritten = [&](std::vector<std::string> options) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"runs", "note", "last", "spilled water"},
          {"runs", "tag", "last", "wet"},
          {"specimen", "add", specimen}}) {
      auto line = words;
      line.insert(line.end(), options.begin(), options.end());
      EXPECT_EQ(cli.run(line), cli::kUnreachable) << cli.out.str();
      EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("cannot reach the daemon at"),
                                       HasSubstr("--db FILE"), Not(HasSubstr("uses "))));
    }
  };
  expect_unwritten({"--socket", path});
  expect_unwritten({"--socket", cli.dir.file("none.sock")});
  cli.variables.erase("LCRIG_DB");
  cli.env.daemon_db = cli.dir.file("no-daemon.db");
  cli.variables["XDG_DATA_HOME"] = cli.dir.file("home");
  expect_unwritten({});  // the daemon's socket exists
  EXPECT_EQ(cli.run({"runs", "note", "last", "mine", "--db", mine}), 0) << cli.err.str();
}

TEST_F(Deaf, DaemonsAreNotMissedByThoseWhoNameAFile) {
  ASSERT_TRUE(open_read_write(cli.dir.file("mine.db")));
  EXPECT_EQ(cli.run({"runs", "--db", cli.dir.file("mine.db")}), 0);
  EXPECT_EQ(cli.err.str(), "");
}

TEST(NoDaemon, IsSaidOnlyWhereOneWasExpected) {
  support::Cli cli;
  ASSERT_TRUE(open_read_write(cli.env.daemon_db));
  EXPECT_EQ(cli.run({"runs"}), 0);
  EXPECT_EQ(cli.err.str(), "");
  EXPECT_EQ(cli.run({"runs", "--socket", cli.dir.file("none.sock")}), 0);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("none.sock: No such file"),
                                   HasSubstr("uses " + cli.env.daemon_db.string())));
}

// Root, or anybody else who may write to it, must not leave files of their own next to it.
TEST(NoDaemon, TheServicesFileIsNotWrittenToByAnybodyElse) {
  support::Cli cli;
  {
    auto db = open_read_write(cli.env.daemon_db);
    ASSERT_TRUE(db);
    ASSERT_TRUE(insert_run(*db, RunRow()));
    ASSERT_TRUE(insert_run_end(*db, 1, RunEnd()));
  }
  EXPECT_EQ(cli.run({"runs", "note", "1", "x"}), cli::kUnreachable);
  EXPECT_THAT(cli.err.str(), HasSubstr("systemctl status lcrigd"));
}

}  // namespace
}  // namespace lcrig
