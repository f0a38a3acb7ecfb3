// SPDX-License-Identifier: Apache-2.0
#include "storage/corrections.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/migrations.hpp"
#include "storage/runs.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000, kDay = 86'400 * kSecond;

StoredCorrection made_with(const std::string& meter, CorrectionKind kind, std::int64_t at,
                           const std::string& who = "Ada") {
  StoredCorrection out;
  out.kind = kind;
  out.meter = meter;
  out.lcr_identity = meter + ",as it said";
  out.operator_name = who;
  out.operator_uid = 1000;
  out.made_unix_ns = at;
  return out;
}

class Corrections : public testing::Test {
 protected:
  void store(const std::string& meter, CorrectionKind kind, std::int64_t at,
             const std::string& who = "Ada") {
    ASSERT_TRUE(add_correction(db_, made_with(meter, kind, at, who)));
  }
  MeterCorrections known(const std::string& meter) const {
    MeterCorrections out;
    out.meter = meter;
    EXPECT_TRUE(look_up_corrections(db_, out));
    return out;
  }
  const TempDir dir_;
  Database db_ = open_read_write(dir_.file("a.db")).value();
};

TEST_F(Corrections, TheLastOfEachKindIsKnownForEachMeter) {
  store("LCR-6100 A", CorrectionKind::open, 5, "Ada");
  store("LCR-6100 A", CorrectionKind::open, 9, "Grace");
  store("LCR-6100 B", CorrectionKind::short_circuit, 7);
  const auto a = known("LCR-6100 A");
  EXPECT_EQ(a.open.made_unix_ns, 9);
  EXPECT_EQ(a.open.made_by, "Grace");
  EXPECT_FALSE(a.short_circuit.made_unix_ns) << "that was another meter";
  EXPECT_FALSE(a.open.on) << "the database does not know what the meter does";
  EXPECT_FALSE(known("LCR-6100 C").open.made_unix_ns);
  const auto all = list_corrections(db_).value();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].meter, "LCR-6100 B") << "the last one first";
  EXPECT_EQ(all[1].open.made_unix_ns, 9);
}

TEST_F(Corrections, AreNeverChangedNorDeleted) {
  store("LCR-6100 A", CorrectionKind::open, 5);
  EXPECT_FALSE(db_.execute("UPDATE lcr_correction SET made_unix_ns = 6"));
  EXPECT_FALSE(db_.execute("DELETE FROM lcr_correction"));
  EXPECT_FALSE(add_correction(db_, made_with("", CorrectionKind::open, 5))) << "of which meter?";
  EXPECT_EQ(db_.integer("SELECT count(*) FROM v_correction WHERE kind = 'open' AND operator = 'Ada'"
                        " AND made_utc = '1970-01-01T00:00:00Z'")
                .value(),
            1);
}

TEST_F(Corrections, ARunSaysWhatWasKnownWhenItBegan) {
  store("LCR-6100 A", CorrectionKind::open, 5);
  RunRow row;
  row.corrections.emplace();
  row.corrections->meter = "LCR-6100 A";
  row.corrections->open.on = true;
  row.corrections->short_circuit.on = false;
  ASSERT_TRUE(insert_run(db_, row));
  store("LCR-6100 A", CorrectionKind::open, 9);
  const auto text = get_run(db_, 1).value().correction_json;
  EXPECT_EQ(nlohmann::json::parse(text), nlohmann::json::parse(R"({"meter": "LCR-6100 A",
    "simulated": false, "open": {"on": true, "made_unix_ns": 5, "made_by": "Ada"},
    "short": {"on": false, "made_unix_ns": null, "made_by": null}})"));
  const auto read = parse_corrections(text);
  ASSERT_TRUE(read);
  EXPECT_EQ(to_json(*read).dump(), text);
  ASSERT_TRUE(insert_run_end(db_, 1, RunEnd()));
  EXPECT_TRUE(verify_chain(db_, 1).value().intact);
  ASSERT_TRUE(db_.execute("DROP TRIGGER run_no_update; UPDATE run SET correction_json = '{}'"));
  EXPECT_FALSE(verify_chain(db_, 1).value().intact) << "the hash chain covers it";
}

TEST(CorrectionsOfBefore, AnOlderDatabaseIsBroughtUpToDateAndItsRunsStayIntact) {
  const TempDir dir;
  constexpr int kSchemaBefore = 9;
  {
    const auto old = support::database_before_uuids(dir.file("a.db"));
    support::insert_old_run(old, 1);
    ASSERT_TRUE(insert_run_end(old, 1, RunEnd()));
    ASSERT_TRUE(migrate(old, shipped_migrations().first(kSchemaBefore)));
    EXPECT_TRUE(list_corrections(old).value().empty());
    MeterCorrections meter;
    meter.meter = "LCR-6100 A";
    EXPECT_TRUE(look_up_corrections(old, meter)) << "it knows of none";
  }
  const auto db = open_read_write(dir.file("a.db")).value();
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
  EXPECT_FALSE(parse_corrections(get_run(db, 1).value().correction_json));
  EXPECT_TRUE(add_correction(db, made_with("LCR-6100 A", CorrectionKind::open, 5)));
  EXPECT_EQ(list_corrections(db).value().size(), 1U);
}

TEST(CorrectionWords, TellStateMakerAndAge) {
  CorrectionState state;
  EXPECT_EQ(correction_words(state, 0), "never made through lcrig");
  state.on = false;
  EXPECT_EQ(correction_words(state, 0), "off, not made through lcrig");
  state.on = true;
  state.made_unix_ns = 1'769'860'800 * kSecond;  // 2026-01-31 12:00
  state.made_by = "Ada";
  const std::string made = "on, made 2026-01-31 12:00 UTC by Ada ";
  EXPECT_EQ(correction_words(state, *state.made_unix_ns), made + "(the same day)");
  EXPECT_EQ(correction_words(state, *state.made_unix_ns - 3 * kDay),
            made + "(the date is in the future)")
      << "somebody set the clock back";
  EXPECT_TRUE(is_in_future(state, *state.made_unix_ns - 1));
  EXPECT_FALSE(is_in_future(state, *state.made_unix_ns));
  EXPECT_FALSE(is_in_future(CorrectionState(), 0)) << "none was made";
  EXPECT_EQ(correction_words(state, *state.made_unix_ns + 13 * 3600 * kSecond),
            made + "(a day before)");
  EXPECT_EQ(correction_words(state, *state.made_unix_ns + 12 * kDay, "ago"),
            made + "(12 days ago)");
  state.on.reset();
  EXPECT_THAT(correction_words(state, *state.made_unix_ns), HasSubstr("not known whether on"));
}

TEST(CorrectionWords, OfWhatIsNoneSayNothing) {
  for (const char* text :
       {"", "{}", "[]", "null", R"({"meter": 5})", R"({"open": {"on": true}})"}) {
    EXPECT_FALSE(parse_corrections(text)) << text;
  }
  const auto odd = parse_corrections(R"({"meter": "x", "open": 5, "short": {"on": "yes"}})");
  ASSERT_TRUE(odd);
  EXPECT_FALSE(odd->open.on);
  EXPECT_FALSE(odd->short_circuit.on);
}

}  // namespace
}  // namespace lcrig
