// SPDX-License-Identifier: Apache-2.0
// What an uncertainty leaves out is named. Whether intervals hold: coverage/rig_errors_test.cpp.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "analysis/line_fit.hpp"
#include "storage/frame_capabilities.hpp"
#include "tests/unit/analysis/analysed.hpp"
#include "tests/unit/analysis/disturbed_run.hpp"
#include "tests/unit/analysis/stated_rig.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const Uncertainty& uncertainty_in(const RunAnalysis& a, UncertainResult result) {
  return *std::ranges::find(a.uncertainties, result, &Uncertainty::result);
}

RunData quiet_run() {
  return DisturbedRun(Disturbed(), 1).data;
}

TEST(RigParts, WhatIsNotKnownIsNamedAndHasNoNumber) {
  StatedRig rig;
  rig.corrections.open.on = false;
  const RunAnalysis a = analysis_of(rig, quiet_run());
  const Uncertainty& c0 = uncertainty_in(a, UncertainResult::c0);
  EXPECT_THAT(c0.gaps(), Contains("open correction"));
  EXPECT_THAT(uncertainty_in(a, UncertainResult::dynamic_range).gaps(),
              Contains("open correction"));
  EXPECT_THAT(uncertainty_in(a, UncertainResult::sensitivity).gaps(),
              Not(Contains("open correction")));
  EXPECT_THAT(a.notes, Contains(HasSubstr("open correction was off")));
  EXPECT_THAT(to_text(a), HasSubstr("not included: open correction: off"));
  const auto object = to_json(c0);
  EXPECT_THAT(object["not_included"].get<std::vector<std::string>>(), Contains("open correction"));
  for (const auto& part : object["parts"]) {
    EXPECT_EQ(part["standard_uncertainty"].is_null(), !part["included"].get<bool>());
  }
}

TEST(RigParts, ACorrectionThatIsOnSaysSinceWhen) {
  StatedRig rig;
  rig.corrections.open.made_unix_ns = 0;
  rig.corrections.open.made_by = "ada";
  RunData data = quiet_run();
  data.row.started_unix_ns = 12LL * 86'400'000'000'000;
  const RunAnalysis a = analysis_of(rig, std::move(data));
  EXPECT_TRUE(uncertainty_in(a, UncertainResult::c0).gaps().empty());
  EXPECT_THAT(to_text(a), HasSubstr("on, made 1970-01-01 00:00 UTC by ada (12 days before)"));
  EXPECT_THAT(a.notes, Not(Contains(HasSubstr("correction"))));
}

TEST(RigParts, AStatedLimitReplacesTheGapAndGoesBeforeTheRecordedOne) {
  const auto size = [](std::optional<double> recorded_F, std::optional<double> stated_fF) {
    StatedRig rig;
    rig.corrections.open.on = false;
    rig.corrections.stray_limit_F = recorded_F;
    rig.options.rig.stray_limit_fF = stated_fF;
    const RunAnalysis a = analysis_of(rig, quiet_run());
    for (const UncertaintyPart& p : uncertainty_in(a, UncertainResult::c0).parts) {
      if (p.name == "open correction" && !p.is_gap) return p.standard_uncertainty;
    }
    return -1.0;
  };
  EXPECT_EQ(size({}, {}), -1);
  EXPECT_NEAR(size(30e-15, {}), rectangular(0.030), 1e-12);
  EXPECT_NEAR(size({}, 50), rectangular(0.050), 1e-12);
  EXPECT_NEAR(size(30e-15, 50), rectangular(0.050), 1e-12);
}

TEST(RigParts, AreReadFromTheRowOfTheRun) {
  MeterCorrections meter;
  meter.meter = "LCR-6100 1";
  meter.open.on = false;
  meter.short_circuit.on = true;
  meter.stray_limit_F = 30e-15;
  StoredCapabilities frame;
  frame.force_class_percent = 2;
  SyntheticRun run;
  run.row.correction_json = to_json(meter).dump();
  run.row.frame_capabilities_json = to_json(frame);
  run.begin();
  run.play(SyntheticRun::Static());
  run.end();
  const RunAnalysis a = analysed(run);
  const auto part_in = [&a](UncertainResult result, const std::string& name) {
    const auto& parts = uncertainty_in(a, result).parts;
    return *std::ranges::find(parts, name, &UncertaintyPart::name);
  };
  EXPECT_NEAR(part_in(UncertainResult::c0, "open correction").standard_uncertainty,
              rectangular(0.030), 1e-12);
  const UncertaintyPart force = part_in(UncertainResult::sensitivity, "force");
  EXPECT_NEAR(force.standard_uncertainty, rectangular(0.02) * a.ranges[0].sensitivity.value(),
              1e-9);
  EXPECT_THAT(force.basis, HasSubstr("limits of 2 % of reading"));
}

TEST(RigParts, OtherGapsAreNamedToo) {
  StatedRig rig;
  rig.corrections.short_circuit.on = false;
  rig.options.rig.meter.cable_m = 1;
  const RunAnalysis a = analysis_of(rig, quiet_run());
  for (const UncertainResult result :
       {UncertainResult::c0, UncertainResult::sensitivity, UncertainResult::delta_C,
        UncertainResult::force_sensitivity}) {
    EXPECT_THAT(uncertainty_in(a, result).gaps(),
                testing::IsSupersetOf({"short correction", "leads"}));
  }
  EXPECT_THAT(a.notes, Contains(HasSubstr("short correction was off")));
  StatedRig hot;
  hot.options.rig.meter.temperature_C = 60;
  EXPECT_THAT(uncertainty_in(analysis_of(hot, quiet_run()), UncertainResult::c0).gaps(),
              Contains("meter specification"));
  RunData old = quiet_run();
  const RunAnalysis unknown = analyse(old).value();
  EXPECT_THAT(uncertainty_in(unknown, UncertainResult::c0).gaps(),
              testing::IsSupersetOf({"meter specification", "open correction"}));
}

// A number beside a gap must not look like the whole uncertainty.
TEST(RigParts, WithAGapTheTextPrintsALowerLimitAndNamesIt) {
  StatedRig hot;
  hot.options.rig.meter.temperature_C = 80;
  const std::string text = to_text(analysis_of(hot, quiet_run()));
  EXPECT_THAT(text, HasSubstr("for the specimen's own +- at least "));
  EXPECT_THAT(text, HasSubstr("not included: meter specification"));
  EXPECT_THAT(text, HasSubstr("expanded at least "));
}

// Every metric that has an uncertainty is found by it, and the results are those of the list.
TEST(RigParts, EachResultHasItsUncertainty) {
  const RunAnalysis a = analysis_of(StatedRig(), quiet_run());
  const std::pair<const Metric*, UncertainResult> known[] = {
      {&a.c0, UncertainResult::c0},
      {&a.ranges[0].sensitivity, UncertainResult::sensitivity},
      {&a.delta_C, UncertainResult::delta_C},
      {&a.dynamic_range, UncertainResult::dynamic_range},
      {&a.force_sensitivity, UncertainResult::force_sensitivity}};
  for (const auto& [metric, result] : known) {
    const Uncertainty* u = a.uncertainty_of(*metric);
    ASSERT_NE(u, nullptr) << metric->name;
    EXPECT_EQ(u->result, result);
    EXPECT_EQ(u->value, metric->value());
  }
  EXPECT_EQ(a.uncertainty_of(a.noise), nullptr);
}

}  // namespace
}  // namespace lcrig
