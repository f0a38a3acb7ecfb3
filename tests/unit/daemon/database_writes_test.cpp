// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/database_writes.hpp"

#include <gmock/gmock.h>

#include "storage/runs.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Writes : public AppPartsTest {
 protected:
  // A run that has ended: the recorder closes it.
  void SetUp() override {
    {
      const auto db = open_read_write(database).value();
      ASSERT_TRUE(insert_run(db, RunRow()));
    }
    AppPartsTest::SetUp();
    ada_.user = "ada";
  }
  PeerCredentials ada_;
};

TEST_F(Writes, StoresANoteInTheNameOfThePeer) {
  ASSERT_TRUE(run(writes.note_run(1, "cracked", ada_)));
  EXPECT_EQ(count("SELECT count(*) FROM run_note WHERE text = 'cracked' AND operator = 'ada'"), 1);
}

SpecimenToAdd as_written(std::string text) {
  SpecimenToAdd out;
  out.text = std::move(text);
  return out;
}

TEST_F(Writes, AreOneAfterTheOther) {
  std::optional<Result<>> first;
  begin(keep(writes.note_run(1, "first", ada_), first));
  const auto busy = run(writes.add_specimen(as_written(one_level().specimen_text), ada_));
  ASSERT_FALSE(busy);
  EXPECT_EQ(busy.error().code, Errc::busy);
  clock.run(io, [&first] { return first.has_value(); });
  EXPECT_TRUE(*first);
  EXPECT_EQ(run(writes.add_specimen(as_written(one_level().specimen_text), ada_)).value(),
            "paper-1");
}

// A refused request must not hold up the others.
TEST_F(Writes, GoOnAfterARefusal) {
  EXPECT_EQ(run(writes.note_run(99, "x", ada_)).error().code, Errc::invalid_request);
  EXPECT_THAT(run(writes.add_specimen(as_written("{}"), ada_)).error().what, HasSubstr("specimen"));
  TagRequest nowhere;
  nowhere.run = 99;
  nowhere.tags.push_back("x");
  EXPECT_FALSE(run(writes.tag_run(nowhere, ada_)));
  TagRequest good = nowhere;
  good.run = 1;
  EXPECT_THAT(run(writes.tag_run(good, ada_)).value(), ElementsAre("x"));
}

Task<bool> note(DatabaseWrites& writes, std::vector<std::int64_t> runs) {
  co_await writes.note(std::move(runs), "continued by run 2");
  co_return true;
}

TEST_F(Writes, OfTheDaemonReachEveryRunThatTakesThem) {
  run(note(writes, {99, 1}));
  EXPECT_EQ(count("SELECT count(*) FROM run_note WHERE text LIKE 'continued%' AND "
                  "operator = 'lcrigd'"),
            1);
}

}  // namespace
}  // namespace lcrig::support
