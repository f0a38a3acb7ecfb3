// SPDX-License-Identifier: Apache-2.0
// Which readings count: random runs with spans of unproven readings. The test draws the readings
// that are to be unproven and writes events around them; no rule of the program makes the truth.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/export.hpp"
#include "analysis/run_data.hpp"
#include "storage/proof.hpp"
#include "storage/run_summary.hpp"
#include "storage/runs.hpp"
#include "tests/support/synthetic_run.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kUnloaded_F = 3.65e-12, kPerKPa_F = 6e-15;
// A meter that lost its settings. Any of these among the results would be seen.
constexpr double kWrong_F = 9e-12;

struct DrawnReading {
  std::int64_t asked_ns = 0;
  int level = 0;  // 0: none
  bool unproven = false;
};

// A baseline and levels, in which stretches of readings are unproven.
class DrawnRun {
 public:
  explicit DrawnRun(std::uint64_t seed) : random_(seed) {
    draw_unproven();
    record();
    write_events();
    run.t_s = end_s_;
    run.end();
  }

  SyntheticRun run;
  std::vector<DrawnReading> readings;
  std::int64_t count(bool unproven, bool of_levels = false) const {
    return std::ranges::count_if(readings, [=](const DrawnReading& r) {
      return r.unproven == unproven && (!of_levels || r.level > 0);
    });
  }

 private:
  std::int64_t below(std::int64_t n) {
    return std::uniform_int_distribution<std::int64_t>(0, n - 1)(random_);
  }
  std::int64_t size() const { return std::ssize(readings); }

  void draw_unproven() {
    baseline_ = 40 + static_cast<int>(below(60));
    levels_ = 2 + static_cast<int>(below(4));
    each_ = 10 + static_cast<int>(below(20));
    readings.resize(static_cast<std::size_t>(baseline_ + levels_ * each_));
    for (std::int64_t i = below(4); i > 0; --i) {
      const std::int64_t first = below(size()), last = std::min(size() - 1, first + below(15));
      stretches_.emplace_back(first, last);
      for (std::int64_t k = first; k <= last; ++k) at(k).unproven = true;
    }
    // From here on nothing is read back any more.
    if (below(2) == 0) tail_ = size() - below(size() / 3);
    for (std::int64_t k = tail_.value_or(size()); k < size(); ++k) at(k).unproven = true;
  }
  DrawnReading& at(std::int64_t i) { return readings[static_cast<std::size_t>(i)]; }

  void record() {
    std::normal_distribution<double> noise(0, 10e-15);
    run.begin();
    std::int64_t i = 0;
    const auto take = [&](double kPa, int level) {
      DrawnReading& r = at(i++);
      r.asked_ns = 1'000'000'000 + std::llround(run.t_s * 1e9);
      r.level = level;
      const double right_F = kUnloaded_F + kPerKPa_F * kPa + noise(random_);
      run.reading(r.unproven ? kWrong_F : right_F, kPa * 1e3 * SyntheticRun::area_m2());
    };
    for (int k = 0; k < baseline_; ++k) take(0, 0);
    run.t_s += 1.5;
    run.frame_until(run.t_s, [](double) { return 0.0; });
    run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
    for (int level = 1; level <= levels_; ++level) {
      const double kPa = 20.0 * level;
      run.t_s += 0.5;
      run.frame_until(run.t_s, [=](double) { return kPa * 1e3 * SyntheticRun::area_m2(); });
      run.level(1, level, kPa, each_);
      for (int k = 0; k < each_; ++k) take(kPa, level);
      run.end_level();
    }
    end_s_ = run.t_s + 1;
  }

  // A time after which, and until when, no other reading is asked: from (last) to (next), or the
  // instant itself, at one end or the other.
  std::int64_t before(std::int64_t i) {
    const std::int64_t gap = i == 0 ? 1'000'000 : at(i).asked_ns - at(i - 1).asked_ns;
    return at(i).asked_ns - (below(3) == 0 ? 0 : below(gap));
  }
  std::int64_t after(std::int64_t i) {
    const std::int64_t gap = i + 1 == size() ? 1'000'000 : at(i + 1).asked_ns - at(i).asked_ns;
    return at(i).asked_ns + (below(3) == 0 ? 0 : below(gap));
  }
  void event_at(std::int64_t mono_ns, const std::string& kind, const json& detail) {
    run.t_s = static_cast<double>(mono_ns - 1'000'000'000) * 1e-9;
    run.event(kind, detail.dump());
  }
  void span(std::int64_t from, std::int64_t to) {
    event_at(to, "unproven",
             {{"asked_from_mono_ns", from},
              {"asked_to_mono_ns", to},
              {"readings", 1},
              {"why", "settings differ"}});
  }

  void write_events() {
    for (const auto& [first, last] : stretches_) {
      if (below(2) == 0) {
        span(before(first), after(last));
        continue;
      }
      // Two spans that overlap, in any order.
      const std::int64_t middle = first + below(last - first + 1);
      const std::int64_t from = before(first), to = after(last);
      const std::int64_t cut = at(middle).asked_ns;
      if (below(2) == 0) {
        span(from, cut);
        span(std::max(from, cut - below(500'000'000)), to);
      } else {
        span(cut, to);
        span(from, std::min(to, cut + below(500'000'000)));
      }
    }
    // The last read-back that was equal, or new settings. It proves what was asked before it.
    const std::int64_t last = tail_ ? before_or_at(*tail_) : at(size() - 1).asked_ns + 1 + below(9);
    event_at(at(0).asked_ns + 1, "read_back", {{"equal", true}});
    if (below(2) == 0) {
      event_at(last, "read_back", {{"equal", true}});
    } else {
      event_at(last, "settings",
               {{"frequency_Hz", 1000},
                {"level_V", 1},
                {"aperture", "medium"},
                {"average", 1},
                {"trigger", "bus"}});
    }
    if (tail_ && below(2) == 0) {
      event_at(at(size() - 1).asked_ns + 5, "read_back",
               {{"equal", false}, {"differs", json::array({"frequency_Hz"})}});
    }
  }
  // After the reading before `i` was asked, and not after `i` was.
  std::int64_t before_or_at(std::int64_t i) {
    if (i == size()) return at(i - 1).asked_ns + 1 + below(1000);
    return before(i);
  }

  std::mt19937_64 random_;
  int baseline_ = 0, levels_ = 0, each_ = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> stretches_;
  std::optional<std::int64_t> tail_;
  double end_s_ = 0;
};

// The column `flags` of an exported table, by `seq`.
std::map<std::int64_t, std::string> exported_flags(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<std::string> names;
  const auto cells_of = [](std::string text) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    std::vector<std::string> cells;
    std::stringstream in(text + ",");
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  names = cells_of(line);
  const auto column = std::ranges::find(names, "flags") - names.begin();
  std::map<std::int64_t, std::string> out;
  while (std::getline(file, line)) {
    const auto cells = cells_of(line);
    out[std::stoll(cells.at(0))] = cells.at(static_cast<std::size_t>(column));
  }
  return out;
}

std::string expected_flag(const DrawnReading& r) {
  return r.unproven ? "unproven" : "";
}

void expect_views_say_it(const DrawnRun& drawn) {
  const auto flags = drawn.run.db().rows<std::string>(
      "SELECT flags FROM v_reading WHERE run = ? ORDER BY seq", drawn.run.run());
  ASSERT_TRUE(flags) << flags.error().what;
  ASSERT_EQ(flags->size(), drawn.readings.size());
  for (std::size_t i = 0; i < flags->size(); ++i) {
    EXPECT_EQ((*flags)[i], expected_flag(drawn.readings[i])) << "reading " << i + 1;
  }
  EXPECT_EQ(drawn.run.db().integer("SELECT sum(proven_readings) FROM v_level WHERE run = ?",
                                   drawn.run.run()),
            drawn.count(false, true));
}

void expect_exports_say_it(const DrawnRun& drawn) {
  const TempDir dir;
  ExportOptions options;
  options.directory = dir.file("csv");
  ASSERT_TRUE(export_run(drawn.run.db(), drawn.run.run(), options));
  for (const char* table : {"lcr.csv", "aligned.csv", "levels.csv"}) {
    const auto flags = exported_flags(options.directory + "/" + table);
    const bool all = std::string(table) != "levels.csv";
    std::size_t of_levels = 0;
    for (std::size_t i = 0; i < drawn.readings.size(); ++i) {
      if (!all && drawn.readings[i].level == 0) continue;
      ++of_levels;
      const auto at = flags.find(static_cast<std::int64_t>(i + 1));
      ASSERT_NE(at, flags.end()) << table << ", reading " << i + 1;
      EXPECT_EQ(at->second, expected_flag(drawn.readings[i])) << table << ", reading " << i + 1;
    }
    EXPECT_EQ(flags.size(), of_levels) << table;
  }
  std::ifstream file(options.directory + "/datapackage.json");
  const json package = json::parse(file);
  const json& proof = package["lcrig"]["proof"];
  EXPECT_EQ(proof["known"], true);
  // The spans that it states hold the unproven readings, and no other.
  for (const DrawnReading& r : drawn.readings) {
    const double asked_s = static_cast<double>(r.asked_ns - 1'000'000'000) * 1e-9;
    const bool inside = std::ranges::any_of(proof["unproven"], [asked_s](const json& span) {
      constexpr double kRounding_s = 1e-10;
      return span["asked_from_s"].get<double>() <= asked_s + kRounding_s &&
             (span["asked_to_s"].is_null() ||
              asked_s <= span["asked_to_s"].get<double>() + kRounding_s);
    });
    EXPECT_EQ(inside, r.unproven) << asked_s;
  }
}

void expect_results_without_them(const DrawnRun& drawn) {
  const auto data = load_run_data(drawn.run.db(), drawn.run.run());
  ASSERT_TRUE(data) << data.error().what;
  EXPECT_TRUE(data->proof_known);
  EXPECT_EQ(data->unproven_readings, drawn.count(true));
  EXPECT_EQ(std::ssize(data->readings), drawn.count(false));
  for (const RunReading& r : data->readings) ASSERT_LT(r.capacitance_F, kWrong_F / 2);
  const auto analysis = analyse(*data);
  ASSERT_TRUE(analysis) << analysis.error().what;
  const json all = to_json(*analysis);
  EXPECT_EQ(all["unproven_readings"], drawn.count(true));
  EXPECT_EQ(all["proof_known"], true);
  if (analysis->c0) {
    EXPECT_NEAR(analysis->c0.value(), kUnloaded_F * 1e12, 0.05);
  }
  for (const LevelResult& l : analysis->levels) {
    const auto proven = std::ranges::count_if(
        drawn.readings, [&l](const DrawnReading& r) { return r.level == l.level && !r.unproven; });
    EXPECT_EQ(l.readings, proven) << "level " << l.level;
    EXPECT_NEAR(l.mean_pF, (kUnloaded_F + kPerKPa_F * 20 * l.level) * 1e12, 0.05);
  }
  const auto said = fmt::format("{} readings are not proven", drawn.count(true));
  if (drawn.count(true) > 0) {
    EXPECT_THAT(analysis->notes, Contains(HasSubstr(said)));
  }
}

void expect_counts_without_them(const DrawnRun& drawn) {
  const auto summary = summarise_run(drawn.run.db(), drawn.run.run());
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->lcr_readings, drawn.count(false));
  EXPECT_EQ(summary->unproven_readings, drawn.count(true));
  EXPECT_EQ(summary->measure_readings, drawn.count(false, true));
  if (summary->c0_F) {
    EXPECT_NEAR(*summary->c0_F * 1e12, kUnloaded_F * 1e12, 0.05);
  }
  EXPECT_EQ(count_unproven(drawn.run.db(), drawn.run.run()), drawn.count(true));
  const auto listed = list_runs(drawn.run.db());
  ASSERT_TRUE(listed) << listed.error().what;
  EXPECT_EQ(listed->front().unproven_readings, drawn.count(true));
}

class Proven : public ::testing::TestWithParam<int> {};

TEST_P(Proven, CountsInViewsExportsResultsAndCounts) {
  for (int i = 0; i < 10; ++i) {
    const auto seed = static_cast<std::uint64_t>(GetParam() * 10 + i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    const DrawnRun drawn(seed);
    expect_views_say_it(drawn);
    expect_exports_say_it(drawn);
    if (drawn.count(false) > 0) expect_results_without_them(drawn);
    expect_counts_without_them(drawn);
    if (HasFailure()) return;
  }
}
INSTANTIATE_TEST_SUITE_P(Drawn, Proven, ::testing::Range(0, 4));

SyntheticRun::Static few() {
  SyntheticRun::Static out;
  out.repeats = 1;
  out.readings = 5;
  return out;
}

TEST(Proof, OfAnOlderRunIsUnknownAndItsReadingsCount) {
  SyntheticRun s;
  s.begin();
  s.play(few());
  s.event("settings", R"({"frequency_Hz":1000})");
  s.reading(3.65e-12, 0);
  s.end();
  const auto proof = Proof::load(s.db(), s.run()).value();
  EXPECT_FALSE(proof.is_known());
  EXPECT_TRUE(proof.unproven().empty());
  EXPECT_EQ(s.db().integer("SELECT count(*) FROM v_reading WHERE flags <> ''"), 0);
  const auto analysis = analyse(s.db(), s.run()).value();
  EXPECT_EQ(std::ranges::count_if(
                analysis.notes,
                [](const std::string& note) { return note.find("not read back") != note.npos; }),
            1);
  EXPECT_EQ(get_run_listing(s.db(), s.run())->unproven_readings, 0);
}

TEST(Proof, OfACutOffRunEndsAtItsLastReadBack) {
  SyntheticRun s;
  s.begin();
  for (int i = 0; i < 10; ++i) s.reading(3.65e-12, 0);
  s.event("read_back", R"({"equal":true})");
  for (int i = 0; i < 4; ++i) s.reading(9e-12, 0);
  s.end(ExitStatus::interrupted);
  EXPECT_EQ(count_unproven(s.db(), s.run()), 4);
  EXPECT_EQ(get_run_listing(s.db(), s.run())->unproven_readings, 4);
  EXPECT_EQ(load_run_data(s.db(), s.run())->readings.size(), 10U);
}

TEST(Proof, IsMissingWhereNoReadBackWasEqual) {
  SyntheticRun s;
  s.begin();
  for (int i = 0; i < 5; ++i) s.reading(3.65e-12, 0);
  s.event("read_back", R"({"equal":false,"differs":["frequency_Hz"]})");
  s.end();
  EXPECT_EQ(count_unproven(s.db(), s.run()), 5);
  const auto analysis = analyse(s.db(), s.run());
  ASSERT_FALSE(analysis);
  EXPECT_THAT(analysis.error().what, HasSubstr("none of the 5 readings of run 1 is proven"));
  EXPECT_EQ(s.db().integer("SELECT count(*) FROM v_reading WHERE flags = 'unproven'"), 5);
}

TEST(Proof, SaysWhichEventCannotBeRead) {
  SyntheticRun s;
  s.begin();
  s.reading(3.65e-12, 0);
  s.event("unproven", "once upon a time");
  s.end();
  const auto proof = Proof::load(s.db(), s.run());
  ASSERT_FALSE(proof);
  EXPECT_THAT(proof.error().what, HasSubstr("event 1 (`unproven`) cannot be read"));
}

TEST(ProofWalk, FindsReadingsInAnyOrder) {
  SyntheticRun s;
  s.begin();
  s.t_s = 99;
  s.event("unproven", R"({"asked_from_mono_ns":10,"asked_to_mono_ns":20,"readings":1,"why":""})");
  s.event("unproven", R"({"asked_from_mono_ns":15,"asked_to_mono_ns":30,"readings":1,"why":""})");
  s.event("unproven", R"({"asked_from_mono_ns":50,"asked_to_mono_ns":50,"readings":1,"why":""})");
  s.event("read_back", R"({"equal":true})");
  const auto proof = Proof::load(s.db(), s.run()).value();
  EXPECT_EQ(proof.unproven().size(), 3U) << "two of them are one";
  ProofWalk walk(proof);
  for (const std::int64_t asked : {9, 31, 49, 51, 9, 100'000}) EXPECT_TRUE(walk.is_proven(asked));
  for (const std::int64_t asked : {50, 10, 20, 21, 30, 10}) EXPECT_FALSE(walk.is_proven(asked));
  EXPECT_FALSE(walk.is_proven(100'000'000'000)) << "at the instant of the last read-back";
  EXPECT_TRUE(walk.is_proven(99'999'999'999));
  s.end();
}

}  // namespace
}  // namespace lcrig
