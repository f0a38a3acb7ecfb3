// SPDX-License-Identifier: Apache-2.0
// `lcrig lcr` against a real control server in another thread, and without one.
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "storage/corrections.hpp"
#include "storage/database.hpp"
#include "tests/unit/tools/served.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using support::Cli;
using support::Served;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

StoredCorrection stored_open(const std::string& meter, std::int64_t made_unix_ns) {
  StoredCorrection out;
  out.meter = meter;
  out.lcr_identity = meter;
  out.operator_name = "Ada";
  out.made_unix_ns = made_unix_ns;
  return out;
}

class LcrCommands : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    cli.variables["LCRIG_DB"] = db_path;
    ASSERT_TRUE(open_read_write(db_path));
    on_server([this] {
      handler.state.database = db_path;
      handler.corrections.meter = "LCR-6100 A";
      handler.corrections.open.on = true;
      handler.corrections.open.made_unix_ns = clock.unix_ns();
      handler.corrections.open.made_by = "Ada";
      handler.corrections.short_circuit.on = false;
    });
  }
  std::vector<std::string> calls() {
    std::vector<std::string> out;
    on_server([&] { out = handler.calls; });
    return out;
  }
  std::string db_path = cli.dir.file("rig.db");
};

TEST_F(LcrCommands, ACorrectionIsMadeOncePeopleSayThatTheProbesAreReady) {
  EXPECT_EQ(cli.run({"lcr", "correct", "open"}), kUsage) << "nobody is there";
  EXPECT_THAT(cli.err.str(), HasSubstr("lcrig lcr correct open --yes"));
  cli.tty = true;
  EXPECT_EQ(cli.run({"lcr", "correct", "open"}), kInterrupted) << "nobody pressed Enter";
  EXPECT_THAT(calls(), IsEmpty());
  cli.typed = "n";
  EXPECT_EQ(cli.run({"lcr", "correct", "open"}), kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("'n' is no yes: nothing was done"),
                                   HasSubstr("lcrig lcr correct open --yes")));
  EXPECT_THAT(calls(), IsEmpty());
  cli.typed = "";
  EXPECT_EQ(cli.run({"lcr", "correct", "open"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("nothing between them. Press Enter"),
                                   HasSubstr("next: lcrig lcr correct short")));
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("the open correction is made and on, and stored"),
                    HasSubstr("LCR-6100 A\nopen   on, made "), HasSubstr("by Ada (the same day)\n"),
                    HasSubstr("short  off, not made through lcrig\n")));
  cli.typed = "yes";
  EXPECT_EQ(cli.run({"lcr", "correct", "open"}), kOk) << cli.err.str();
  cli.tty = false;
  EXPECT_EQ(cli.run({"lcr", "correct", "short", "--yes", "--json"}), kOk) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["meter"], "LCR-6100 A");
  EXPECT_THAT(calls(), ElementsAre("correct open", "correct open", "correct short"));
}

TEST_F(LcrCommands, WhoLeavesIsToldThatTheMeterGoesOn) {
  on_server([this, waits = ::pthread_self()] {
    handler.hold_start = true;
    handler.after_start = [waits] { ::pthread_kill(waits, SIGINT); };
  });
  EXPECT_EQ(cli.run({"lcr", "correct", "open", "--yes"}), kInterrupted);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("the meter goes on; the correction will be stored; make it again "
                              "when something lay between the probes"),
                    HasSubstr("next: lcrig lcr ")));
  on_server([this] { handler.hold_start = false; });
}

TEST_F(LcrCommands, StatusSaysThatACorrectionGoesOn) {
  EXPECT_EQ(cli.run({"status"}), kOk);
  EXPECT_THAT(cli.out.str(), Not(HasSubstr("correction")));
  on_server([this] { handler.state.correcting = true; });
  EXPECT_EQ(cli.run({"status"}), kOk);
  EXPECT_THAT(cli.out.str(), HasSubstr("correction is being made: up to two minutes\n"));
}

TEST_F(LcrCommands, ARefusalSaysWhatToDoNext) {
  on_server([this] { handler.next_error = Error(Errc::refused, "CORR:OPEN:LCR -> \"fail\""); });
  EXPECT_EQ(cli.run({"lcr", "correct", "open", "--yes"}), kInstrument);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("\"fail\""), HasSubstr("lcrig lcr correct open")));
  on_server([this] { handler.next_error = Error(Errc::busy, "run 3 is going on"); });
  EXPECT_NE(cli.run({"lcr", "correct", "open", "--yes"}), kOk);
  EXPECT_THAT(cli.err.str(), HasSubstr("run 3 is going on"));
  EXPECT_EQ(cli.run({"lcr", "correct", "load", "--yes"}), kUsage);
  EXPECT_THAT(cli.err.str(), HasSubstr("it takes open or short"));
  EXPECT_EQ(cli.run({"lcr", "correct"}), kUsage);
}

TEST_F(LcrCommands, WithoutAVerbTheMeterIsShown) {
  ASSERT_TRUE(add_correction(open_read_write(db_path).value(), stored_open("LCR-6100 B", 5)));
  EXPECT_EQ(cli.run({"lcr"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("LCR-6100 A\nopen   on, made "),
                    HasSubstr("LCR-6100 B\nopen   not known whether on, made 1970")));
  EXPECT_EQ(cli.err.str(), "");
  EXPECT_EQ(cli.run({"lcr", "--json"}), kOk);
  const auto all = json::parse(cli.out.str());
  EXPECT_EQ(all["asked"], true);
  EXPECT_EQ(all["meters"].size(), 2U);
  EXPECT_EQ(all["meters"][0]["open"]["on"], true);
}

TEST_F(LcrCommands, AMeterThatCannotBeAskedIsShownAsItIsStored) {
  ASSERT_TRUE(add_correction(open_read_write(db_path).value(), stored_open("LCR-6100 A", 5)));
  on_server([this] { handler.next_error = Error(Errc::busy, "run 3 is going on"); });
  EXPECT_EQ(cli.run({"lcr", "show"}), kOk);
  EXPECT_THAT(cli.err.str(), HasSubstr("the meter was not asked: run 3 is going on"));
  EXPECT_THAT(cli.out.str(), HasSubstr("open   not known whether on, made 1970-01-01"));
}

TEST(LcrWithoutDaemon, AMistypedDatabaseIsRefused) {
  Cli cli;
  const std::string none = cli.dir.file("nonexist.db");
  EXPECT_EQ(cli.run({"lcr", "--db", none}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("there is no database at " + none));
}

TEST(LcrWithoutDaemon, IsShownFromTheDatabaseAndCorrectsNothing) {
  Cli cli;
  cli.variables["LCRIG_DB"] = cli.dir.file("none.db");
  EXPECT_EQ(cli.run({"lcr", "show", "--json"}), kOk) << cli.err.str();
  const auto all = json::parse(cli.out.str());
  EXPECT_EQ(all["asked"], false);
  EXPECT_THAT(all["why_not"].get<std::string>(), HasSubstr("cannot reach the daemon"));
  EXPECT_TRUE(all["meters"].empty());
  EXPECT_EQ(cli.run({"lcr", "correct", "open", "--yes"}), kUnreachable);
  EXPECT_THAT(cli.err.str(),
              AllOf(HasSubstr("systemctl status lcrigd"), Not(HasSubstr("rehearse"))));
}

TEST(LcrWithoutDaemon, CompletionOffersBothKinds) {
  Cli cli;
  ASSERT_EQ(cli.run({"__complete", "--", "lcr", "correct", ""}), kOk);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("\nopen\t"), HasSubstr("\nshort\t")));
}

}  // namespace
}  // namespace lcrig::cli
