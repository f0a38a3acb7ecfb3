// SPDX-License-Identifier: Apache-2.0
// Analyses runs of the simulated bench. The truth is the specimen's own curve.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <filesystem>

#include "analysis/analysis.hpp"
#include "analysis/line_fit.hpp"
#include "base/clock.hpp"
#include "base/strict_json.hpp"
#include "daemon/rehearse.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_file.hpp"
#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;

RunAnalysis rehearsed(RehearseRequest request) {
  const TempDir dir;
  request.db_path = dir.file("r.db");
  request.protocol_text = library(request.protocol_name);
  const auto result = rehearse(request);
  if (!result) throw std::runtime_error(result.error().what);
  EXPECT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  return analyse(open_read_only(request.db_path).value(), result->run).value();
}

// Its clock stays, so that it gives the same rows; beside it stands when it was made.
TEST(RehearsalTimes, TheClockOfARehearsalIsFixedAndTheTimeOfItsMakingTrue) {
  const TempDir dir;
  const std::int64_t before = RealClock().unix_ns();
  std::vector<RunRow> rows;
  for (const char* name : {"a.db", "b.db"}) {
    RehearseRequest request;
    request.protocol_name = "static-frame";
    request.protocol_text = library(request.protocol_name);
    request.specimen_name = "paper-1";
    request.specimen_text = std::string(shipped_specimens().front().text);
    request.parameters = {{"levels", "2"}, {"repeats", "1"}};
    request.db_path = dir.file(name);
    ASSERT_TRUE(rehearse(request));
    const auto db = open_read_only(request.db_path).value();
    rows.push_back(get_run(db, 1).value());
    EXPECT_TRUE(verify_chain(db, 1).value().intact);
    ASSERT_TRUE(rows.back().made_unix_ns);
    EXPECT_GE(*rows.back().made_unix_ns, before);
    EXPECT_LE(*rows.back().made_unix_ns, RealClock().unix_ns());
  }
  EXPECT_EQ(rows[0].started_unix_ns, rows[1].started_unix_ns);
}

RehearseRequest of_paper_1(const std::string& protocol, std::uint64_t seed) {
  RehearseRequest request;
  request.protocol_name = protocol;
  request.specimen_name = "paper-1";
  request.specimen_text = std::string(shipped_specimens().front().text);
  request.seed = seed;
  return request;
}

// An error beyond this comes once in ten thousand estimates. Three repeats leave few degrees of
// freedom, with which a multiple of the standard error says nothing.
double surely_within(const Estimate& e) {
  const boost::math::students_t t(e.degrees_of_freedom.value());
  return *e.standard_error * boost::math::quantile(t, 1 - 5e-5);
}

// bench/coverage.cpp counts over hundreds of runs. Here, sixteen runs must come close.
TEST(Analysis, IntervalsOfTheSensitivityHoldTheTruth) {
  const Specimen specimen =
      parse_specimen(std::string(shipped_specimens().front().text), "paper-1").value();
  const auto world =
      BenchWorld::make(specimen, specimen.disc_diameter_m, 1e-4, Force::from_si(1.7), PlantConfig())
          .value();
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    auto request = of_paper_1("static-frame", seed);
    request.parameters = {{"readings", "4"}, {"within_s", "1"}, {"settle_s", "0.1"},
                          {"repeats", "3"},  {"levels", "10"},  {"rate_N_s", "2"}};
    const auto a = rehearsed(request);
    for (const RangeResult& r : a.ranges) {
      std::vector<LinePoint> truth;
      for (const LevelResult& l : a.levels) {
        if (*l.target_kPa < r.range.from_kPa - 1e-6 || *l.target_kPa > r.range.to_kPa + 1e-6) {
          continue;
        }
        const double C = world->response().capacitance_F(*l.target_kPa * 1e3 * specimen.area_m2());
        truth.push_back({*l.target_kPa, C * 1e15, 1});
      }
      const double slope = fit_line(truth)->slope;
      const auto& interval = *r.sensitivity.estimate->interval;
      inside += interval[0] <= slope && slope <= interval[1] ? 1 : 0;
      ++all;
      EXPECT_NEAR(r.sensitivity.value(), slope, surely_within(*r.sensitivity.estimate));
    }
  }
  EXPECT_EQ(all, 16);
  EXPECT_GE(inside, 12) << "of 16; 95 % intervals hold fewer in one of a thousand cases";
}

TEST(Analysis, DynamicRangeOfTheRehearsalIsThatOfTheSpecimen) {
  const Specimen specimen =
      parse_specimen(std::string(shipped_specimens().front().text), "paper-1").value();
  const auto world =
      BenchWorld::make(specimen, specimen.disc_diameter_m, 1e-4, Force::from_si(1.7), PlantConfig())
          .value();
  auto request = of_paper_1("dynamic-cycles", 3);
  request.parameters = {{"cycles", "3"}, {"gap_mm", "0.1"}};
  const auto a = rehearsed(request);
  ASSERT_EQ(a.cycles.size(), 3U);
  const auto& response = world->response();
  const double truth =
      (response.capacitance_F(a.cycles[0].peak_force_N) / response.c0_F() - 1) * 100;
  EXPECT_NEAR(a.dynamic_range.value(), truth, 4 * *a.cycles[0].dynamic_range_se_percent);
  EXPECT_FALSE(a.hysteresis.resolved) << "the specimen has none";
}

// The force turns while the meter converts, and the answer comes after the turn. The reading must
// still belong to the middle of its window. The tolerance is the delay of the poll (3 ms at 100
// kPa/s and 4 fF/kPa) and, at the turn, the force between two samples of the frame.
TEST(Analysis, ReadingsUnderAMovingForceLieOnTheSpecimensCurve) {
  const Specimen specimen =
      parse_specimen(std::string(shipped_specimens().front().text), "paper-1").value();
  const auto world =
      BenchWorld::make(specimen, specimen.disc_diameter_m, 1e-4, Force::from_si(1.7), PlantConfig())
          .value();
  const TempDir dir;
  auto request = of_paper_1("dynamic-cycles", 1);
  request.parameters = {{"cycles", "5"}, {"gap_mm", "0.1"}};
  request.db_path = dir.file("r.db");
  request.protocol_text =
      with(library("dynamic-cycles"), R"("aperture": "fast")", R"("aperture": "medium")");
  request.bench_text = with(read_text_file("daemon/rig/benches/paper.json").value(),
                            R"("noise_medium_fF": 44)", R"("noise_medium_fF": 0.001)");
  request.bench_text =
      with(request.bench_text, R"("force_noise_mN": 0.5)", R"("force_noise_mN": 0.05)");
  const auto result = rehearse(request);
  ASSERT_TRUE(result) << result.error().what;
  const auto data = load_run_data(open_read_only(request.db_path).value(), result->run).value();
  int loaded = 0;
  for (const RunReading& r : data.readings) {
    const double force = r.force_N - data.rest_force_N.value();
    if (!r.has_force() || force < 0.05) continue;
    ++loaded;
    const double truth_F = world->response().capacitance_F(force);
    EXPECT_NEAR((r.capacitance_F - truth_F) * 1e15, 0, 6) << r.t_s << " s, " << force << " N";
  }
  EXPECT_GT(loaded, 50);
}

TEST(Analysis, SaysOfTheRealRecordingOnlyWhatIsThere) {
  const std::string real = "../shared/data/real-press-9mm";
  if (!std::filesystem::exists(real)) {
    GTEST_SKIP() << real << " is not here: the real recording is not part of the project";
  }
  RehearseRequest request;
  request.protocol_name = "follow";
  request.bench = "replay:" + real;
  const auto a = rehearsed(request);
  ASSERT_EQ(a.cycles.size(), 10U) << "ten presses";
  for (const CycleResult& c : a.cycles) {
    EXPECT_GT(c.peak_force_N, 9.5) << "above the cell's offset of 2.75 N";
    EXPECT_LT(c.peak_force_N, 13);
    EXPECT_TRUE(c.slope_fF_per_N);
    EXPECT_FALSE(c.peak_kPa) << "nobody told the probe";
  }
  EXPECT_LT(a.cycles[0].delta_C_fF, -150);
  EXPECT_GT(a.cycles[1].delta_C_fF, 80);
  EXPECT_FALSE(a.ranges[0].sensitivity);
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("probe diameter"));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("rises in some loadings and falls in others"));
  EXPECT_GE(a.holds.size(), 10U);
  EXPECT_TRUE(a.creep);
  EXPECT_THAT(a.notes, Contains(HasSubstr("played back")));
}

}  // namespace
}  // namespace lcrig
