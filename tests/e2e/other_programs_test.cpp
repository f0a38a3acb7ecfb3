// SPDX-License-Identifier: Apache-2.0
// The database read by programs that know nothing of lcrig: the sqlite3 shell and Python.
#include <fstream>
#include <iterator>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

class OtherPrograms : public Rig {
 protected:
  void record() {
    const auto done = lcrig({"rehearse", "static-frame", "--specimen", "paper-1", "--seed", "7",
                             "-p", "levels=3", "-p", "repeats=1", "--db", file("lcrig.db")});
    ASSERT_EQ(done.code, 0) << done.err;
  }
  // Adds rows as if the run had been queued, had asked something and been tagged, unlike this one.
  void queue_and_answer() {
    const auto done = program({"/usr/bin/sqlite3", "-bail", file("lcrig.db"), R"(
        INSERT INTO queue_text VALUES (printf('%064d', 1), '{}'), (printf('%064d', 2), '{}');
        INSERT INTO queue_entry SELECT 1, NULL, 'done', NULL, protocol, printf('%064d', 1), '{}',
          specimen, printf('%064d', 2), operator, note, '{}', 'null', operator, 0, 0 FROM v_run;
        INSERT INTO queue_attempt SELECT 1, 1, run FROM v_run;
        INSERT INTO run_tag SELECT run, 1, 'thesis', 1, operator, 0 FROM v_run;
        INSERT INTO event SELECT run_id, max(seq) + 1, max(at_mono_ns), 'answer', 'thickness',
          '{"question":"Thickness","type":"number","number":125.5,"unit":"um"}' FROM event;)"});
    ASSERT_EQ(done.code, 0) << done.err;
  }
};

TEST_F(OtherPrograms, PythonReadsInTheViewsWhatTheExportHolds) {
  record();
  ASSERT_EQ(lcrig({"export", "1", "-o", file("out"), "--db", file("lcrig.db")}).code, 0);
  const auto done =
      program({"/usr/bin/python3", "tests/e2e/read_database.py", file("lcrig.db"), file("out")});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("3 levels, static-frame, success"));
}

// Runs the program of docs/database.md unchanged, on a run and on its copy in another database.
TEST_F(OtherPrograms, PythonComputesTheHashesOfThePageAnew) {
  record();
  const auto db = file("lcrig.db"), other = file("other.db");
  ASSERT_EQ(lcrig({"rehearse", "static-frame", "--specimen", "paper-1", "-p", "levels=3", "-p",
                   "repeats=1", "--db", other})
                .code,
            0);
  ASSERT_EQ(lcrig({"runs", "note", "1", "für später", "--db", db}).code, 0);
  ASSERT_EQ(lcrig({"runs", "copy", "1", "--db", db, "--to", other}).code, 0);
  ASSERT_EQ(lcrig({"runs", "note", "2", "of the copy", "--db", other}).code, 0);
  std::ifstream page("docs/database.md");
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  const std::size_t begin = text.find("```python\n") + 10;
  std::ofstream(file("chain.py")) << text.substr(begin, text.find("```", begin) - begin);
  const auto computed = [&](const std::string& database) {
    const auto done = program({"/usr/bin/python3", file("chain.py"), database});
    EXPECT_EQ(done.code, 0) << done.err;
    return done.out;
  };
  const auto verified = [&](const std::string& run, const std::string& database) {
    const auto done = lcrig({"verify", run, "--json", "--db", database});
    EXPECT_EQ(done.code, 0) << done.err;
    return run + " " + json::parse(done.out)["anchor"].get<std::string>() + "\n";
  };
  EXPECT_EQ(computed(db), verified("1", db));
  EXPECT_EQ(computed(other), verified("1", other) + verified("2", other));
  const auto changed =
      program({"/usr/bin/sqlite3", "-bail", db,
               "DROP TRIGGER lcr_reading_no_update; "
               "UPDATE lcr_reading SET capacitance_F = capacitance_F * 2 WHERE seq = 3;"});
  ASSERT_EQ(changed.code, 0) << changed.err;
  EXPECT_THAT(computed(db), HasSubstr("does not fit"));
}

TEST_F(OtherPrograms, ParametersHaveTheUnitsOfTheirNames) {
  record();
  const json stored = json::parse(query("SELECT parameters_json FROM run"));
  EXPECT_EQ(stored["from_kPa"], 10);
  EXPECT_EQ(stored["levels"], 3);
  EXPECT_EQ(stored["rate_N_s"], 0.1);
}

// Runs the queries of docs/database.md unchanged.
TEST_F(OtherPrograms, TheShellRunsTheQueriesOfThePage) {
  record();
  queue_and_answer();
  std::ifstream page("docs/database.md");
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  int queries = 0;
  for (std::size_t at = 0; (at = text.find("```sql\n", at)) != std::string::npos;) {
    const std::size_t begin = at + 7, end = text.find("```", begin);
    const std::string query = text.substr(begin, end - begin);
    const auto done = program({"/usr/bin/sqlite3", "-readonly", "-bail", file("lcrig.db"), query});
    EXPECT_EQ(done.code, 0) << query << done.err;
    EXPECT_NE(done.out, "") << query;
    ++queries;
    at = end;
  }
  EXPECT_GE(queries, 3);
}

TEST_F(OtherPrograms, PythonRunsTheBlocksOfItsPage) {
  record();
  ASSERT_EQ(lcrig({"export", "1", "-o", file("export"), "--db", file("lcrig.db")}).code, 0);
  const auto done = program({"/usr/bin/python3", "tests/e2e/python_page.py", file("lcrig.db"),
                             file("export"), file("page")},
                            150s);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("4 blocks"));
}

// Where a page talks to instruments, these are lcrig-sim and the gateway in Python.
TEST_F(OtherPrograms, EveryCommandOfThePagesDoesWhatThePageSays) {
  const auto done =
      program({"/usr/bin/python3", "tests/e2e/doc_commands.py", LCRIG_BIN, file("pages")}, 250s);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr(" commands, 0 failed")) << done.err;
}

}  // namespace
}  // namespace lcrig::e2e
