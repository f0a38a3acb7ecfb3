// SPDX-License-Identifier: Apache-2.0
// Which runs are compared, which are refused, and which errors cancel between them.
#include "analysis/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/analysis/compared_world.hpp"

namespace lcrig::comparison {
namespace {

using testing::HasSubstr;

constexpr const char* kLow = "sensitivity 0-30 kPa";
constexpr const char* kHigh = "sensitivity 35-100 kPa";

// Two runs, of which the second may differ.
struct Two {
  ComparedSpecimen a, b{4000, 1200, 70, 0};
  ComparedRig rig_a, rig_b;
  ComparedProtocol p_a, p_b;
  std::string name_b = "paper-2";

  std::vector<Comparison> compared() const {
    const ComparedRun one(1, "paper-1", a, rig_a, p_a, 11), two(2, name_b, b, rig_b, p_b, 12);
    const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
    return compare(runs, analyses_of({&one.data, &two.data}));
  }
  Comparison of(const std::string& quantity) const {
    for (Comparison& c : compared()) {
      if (c.quantity == quantity) return std::move(c);
    }
    ADD_FAILURE() << "nothing about " << quantity;
    return {};
  }
};

void expect_refused(const Two& two, const std::string& quantity, const std::string& why) {
  const Comparison c = two.of(quantity);
  EXPECT_THAT(c.refused, HasSubstr(why)) << quantity;
  EXPECT_FALSE(c.remedy.empty());
  EXPECT_FALSE(c.increase_percent || c.interval_percent || c.ratio);
  EXPECT_THAT(c.verdict, HasSubstr(why));
}

TEST(Comparison, OfLikeRunsNamesWhatTheyShare) {
  const Comparison c = Two().of(kLow);
  EXPECT_EQ(c.refused, "");
  EXPECT_THAT(c.shared, testing::ElementsAre("meter LCR-6100 A1", "load cell C1", "probe P1"));
  EXPECT_TRUE(c.not_shared.empty());
  ASSERT_TRUE(c.ratio);
  EXPECT_LT((*c.ratio)[0], 2);
  EXPECT_GT((*c.ratio)[1], 2);
  EXPECT_LT((*c.ratio)[1] - (*c.ratio)[0], 0.02);
  EXPECT_THAT(c.verdict, testing::MatchesRegex(
                             "paper-2 is [12]\\.[0-9]+ to 2\\.[0-9]+ times as sensitive as paper-1 "
                             "in 0-30 kPa, same probe, same load cell, same meter, loading branch "
                             "\\(95 %\\)"));
}

TEST(Comparison, OfOtherProbesIsRefused) {
  Two two;
  two.p_b.probe_mm = 8;
  two.rig_b.probe = "P8";
  expect_refused(two, kLow, "probes of 4 mm and 8 mm");
  expect_refused(two, "dynamic range", "probes of 4 mm and 8 mm");
  EXPECT_EQ(two.of("C0").refused, "");
}

// Discs of 8 and of 4 mm under a probe of 8 mm: four times the pressure.
Two other_discs() {
  Two two;
  two.a.disc_mm = 8;
  two.b.disc_mm = 4;
  two.p_a.probe_mm = two.p_b.probe_mm = 8;
  return two;
}

TEST(Comparison, OfOtherDiscsIsThatOfThePressureOnTheDisc) {
  Two two = other_discs();
  two.p_b.kPa = {2.5, 5, 7.5, 10, 12.5, 15};
  const Comparison c = two.of(kLow);
  EXPECT_EQ(c.refused, "");
  EXPECT_THAT(c.converted, HasSubstr("pressure on the disc: force over the disc of 8 mm in run 1 "
                                     "and of 4 mm in run 2"));
  EXPECT_THAT(c.verdict, HasSubstr("pressure on the disc"));
  ASSERT_TRUE(c.ratio);
  EXPECT_LT((*c.ratio)[0], 2);
  EXPECT_GT((*c.ratio)[1], 2);
  // The discs are known to 0.1 mm of 8 and to 0.05 mm of 4; the probe's area does not matter.
  EXPECT_THAT(*c.standard_error_percent / 2, testing::AllOf(testing::Gt(2), testing::Lt(2.5)));
  EXPECT_THAT(c.shared, testing::ElementsAre("meter LCR-6100 A1", "load cell C1"));
  EXPECT_EQ(two.of("C0").converted, "");
  EXPECT_EQ(two.of("dynamic range").refused, "");
}

TEST(Comparison, OfOtherDiscsAtOnePressureUnderTheProbeIsRefused) {
  const Two two = other_discs();
  expect_refused(two, "dynamic range", "60 kPa in run 1, 240 kPa in run 2");
  expect_refused(two, kLow, "run 2 has none");
}

TEST(Comparison, OfADiscThatIsPressedInPartIsRefused) {
  Two two = other_discs();
  two.b.disc_mm = 16;
  expect_refused(two, kLow, "discs of 8 mm and 16 mm");
  expect_refused(two, kLow, "the probe of 8 mm presses only a part of the disc of run 2");
  two.a.disc_mm = 16;
  EXPECT_EQ(two.of(kLow).refused, "") << "both are pressed alike";
}

TEST(Comparison, NamesADiscThatIsNotKnown) {
  Two two = other_discs();
  two.b.disc_mm.reset();
  EXPECT_THAT(two.of(kLow).verdict, HasSubstr("not in the interval: the disc of run 2"));
}

TEST(Comparison, OfARunWithItselfIsRefused) {
  const ComparedRun one(1, "paper-1", {}, {}, {}, 11);
  const RunAnalysis runs[] = {analyse(one.data).value(), analyse(one.data).value()};
  const auto all = compare(runs, analyses_of({&one.data, &one.data}));
  ASSERT_FALSE(all.empty());
  for (const Comparison& c : all) {
    EXPECT_THAT(c.refused, HasSubstr("both are run 1")) << c.quantity;
    EXPECT_FALSE(c.ratio);
  }
}

TEST(Comparison, NamesAllObstaclesAtOnce) {
  Two two;
  two.p_b.probe_mm = 8;
  two.p_b.frequency_Hz = 50e3;
  two.p_b.level_V = 0.5;
  two.p_b.bias_V = 1;
  two.p_b.function = "Cs-D";
  two.p_b.ramps = true;
  two.p_b.kPa.back() = 75;
  const std::string refused = two.of("dynamic range").refused;
  for (const char* why : {"probes of 4 mm and 8 mm", "50000 Hz", "0.5 V", "bias", "measured Cs",
                          "turns at the peak", "a dynamic range holds for its peak"}) {
    EXPECT_THAT(refused, HasSubstr(why));
  }
}

TEST(Comparison, TheSentenceNamesWhatIsNotInItsInterval) {
  Two two;
  two.p_a.short_on = two.p_b.short_on = false;
  const Comparison c = two.of(kLow);
  EXPECT_THAT(c.not_included, testing::ElementsAre("short correction"));
  EXPECT_THAT(c.verdict, HasSubstr("; not in the interval: short correction"));
  EXPECT_THAT(to_json(c)["not_included"].dump(), HasSubstr("short correction"));
  EXPECT_THAT(Two().of(kLow).verdict, testing::Not(HasSubstr("not in the interval")));
}

TEST(Comparison, OfOtherPeaksConvertsSlopesAndRefusesTheDynamicRange) {
  for (const bool ramps : {false, true}) {
    SCOPED_TRACE(ramps);
    Two two;
    two.p_a.ramps = two.p_b.ramps = ramps;
    two.p_a.kPa = {10, 20, 30, 40, 50, 60, 70, 80, 90, 100};
    two.p_b.kPa = {10, 20, 30, 40, 50};
    two.p_a.ramp_readings = 200;
    two.p_b.ramp_readings = 100;
    expect_refused(two, "dynamic range", "a dynamic range holds for its peak");
    const Comparison high = two.of(kHigh);
    EXPECT_EQ(high.refused, "");
    EXPECT_THAT(high.converted, HasSubstr(ramps ? "over 35-49.8 kPa" : "40, 50 kPa"));
    ASSERT_TRUE(high.ratio);
    EXPECT_LT((*high.ratio)[0], 2);
    EXPECT_GT((*high.ratio)[1], 2);
    EXPECT_NEAR(*high.to_value / *high.from_value, 2, 0.05);
  }
}

TEST(Comparison, OfALevelThatOneRunLacksUsesTheCommonOnes) {
  Two two;
  two.b = two.a;
  two.p_b.kPa = {5, 10, 20, 40, 60};
  const Comparison c = two.of(kLow);
  EXPECT_THAT(c.converted, HasSubstr("10, 20 kPa"));
  EXPECT_NEAR(*c.increase_percent, 0, 1.5);
  two.p_b.kPa = {7, 14, 28, 60};
  expect_refused(two, kLow, "fewer than two pressures are in both runs");
}

TEST(Comparison, OfHeldAndGrowingLoadsIsRefused) {
  Two two;
  two.p_b.ramps = true;
  expect_refused(two, kLow, "run 1 holds each load, run 2 measures while the load grows");
  expect_refused(two, "dynamic range", "run 1 holds each load, run 2 turns at the peak");
  EXPECT_EQ(two.of("C0").refused, "");
}

TEST(Comparison, OfAResultThatOneRunLacksIsRefusedByName) {
  Two two;
  two.p_b.kPa = {10, 20, 30};
  expect_refused(two, kHigh, "run 2 has none");
}

TEST(Comparison, OfOtherSettingsIsRefused) {
  const auto with = [](auto change) {
    Two two;
    change(two.p_b);
    return two;
  };
  for (const char* quantity : {kLow, "C0", "dynamic range"}) {
    expect_refused(with([](auto& p) { p.frequency_Hz = 10e3; }), quantity, "10000 Hz");
    expect_refused(with([](auto& p) { p.level_V = 0.5; }), quantity, "0.5 V");
    expect_refused(with([](auto& p) { p.bias_V = 1; }), quantity, "bias");
    expect_refused(with([](auto& p) { p.function = "Cs-D"; }), quantity, "measured Cs");
  }
  EXPECT_EQ(with([](auto& p) { p.function = "Cp-Rp"; }).of(kLow).refused, "");
}

TEST(Comparison, OfC0WithoutAnOpenCorrectionInOneRunIsRefused) {
  Two two;
  two.p_b.open_on = false;
  expect_refused(two, "C0", "the open correction was off in run 2");
  expect_refused(two, "dynamic range", "the open correction was off in run 2");
  const Comparison slope = two.of(kLow);
  EXPECT_EQ(slope.refused, "");
  EXPECT_THAT(slope.not_shared,
              testing::Contains(HasSubstr("the open correction is on in only one run")));
}

// Relative standard error of the comparison of two runs without any scatter to speak of.
double error_percent(const Two& two, const std::string& quantity = kLow) {
  const Comparison c = two.of(quantity);
  return c.standard_error_percent ? *c.standard_error_percent * *c.from_value / *c.to_value : -1;
}

// What is not proven to be shared enters twice: sqrt(2) times its limits over sqrt(3).
void expect_not_shared(const Two& two, double limit_percent, const char* why) {
  const double own = error_percent(Two()), both = error_percent(two);
  const double expected = std::sqrt(2.0 / 3) * limit_percent;
  EXPECT_NEAR(std::sqrt(both * both - own * own), expected, 0.02 * expected) << why;
  EXPECT_THAT(two.of(kLow).not_shared, testing::Contains(HasSubstr(why)));
}

TEST(Comparison, DropsNoPartThatIsNotProvenToBeShared) {
  constexpr double kClass = 1, kProbe = 2 * 0.02 / 4 * 100, kMeter = 0.05;  // percent
  const auto with = [](auto change) {
    Two two;
    change(two);
    return two;
  };
  expect_not_shared(with([](Two& t) { t.rig_b.cell = "C2"; }), kClass, "C1 against C2");
  expect_not_shared(with([](Two& t) { t.rig_b.cell = ""; }), kClass, "run 2 does not prove which");
  expect_not_shared(with([](Two& t) { t.rig_a.cell = t.rig_b.cell = ""; }), kClass, "neither run");
  constexpr double kMasses = 0.1;
  expect_not_shared(with([](Two& t) { t.rig_a.weights = t.rig_b.weights = true; }), kMasses,
                    "both runs have weights in its place");
  EXPECT_THAT(with([](Two& t) { t.rig_b.weights = true; }).of(kLow).not_shared,
              testing::Contains("load cell (run 2 has weights in its place)"));
  expect_not_shared(with([](Two& t) { t.rig_b.probe = "P2"; }), kProbe, "P1 against P2");
  expect_not_shared(with([](Two& t) { t.rig_a.probe = t.rig_b.probe = ""; }), kProbe, "neither");
  expect_not_shared(with([](Two& t) { t.p_b.probe_mm = 4.01; }), kProbe, "two diameters");
  expect_not_shared(with([](Two& t) { t.rig_b.meter = "LCR-6100 B2"; }), kMeter, "against");
  expect_not_shared(with([](Two& t) { t.rig_a.meter = t.rig_b.meter = ""; }), kMeter, "neither");
  expect_not_shared(with([](Two& t) { t.p_b.corrected_unix_ns = 2; }), kMeter, "made again");
  expect_not_shared(with([](Two& t) { t.p_a.corrected_unix_ns = t.p_b.corrected_unix_ns = {}; }),
                    kMeter, "it is not recorded when");
  expect_not_shared(with([](Two& t) { t.p_a.open_on = t.p_b.open_on = {}; }), kMeter,
                    "the state of the open correction is not recorded");
}

TEST(Comparison, ACellOfAnotherClassIsNotTheSame) {
  Two two;
  two.p_b.force_class = 0.5;
  EXPECT_THAT(two.of(kLow).not_shared, testing::Contains(HasSubstr("force class 1 against 0.5")));
}

// The same error of the force changes two dynamic ranges unequally where one curve is flatter.
TEST(Comparison, KeepsWhatOneErrorChangesUnequally) {
  Two two;
  two.b.bend_kPa = 20;
  const double flat = error_percent(two, "dynamic range");
  const double alike = error_percent(Two(), "dynamic range");
  EXPECT_GT(flat, alike + 0.2);
}

TEST(Comparison, OfARunOfAnOldSchemaSharesNothing) {
  const ComparedRun one(1, "paper-1", {}, {}, {}, 21);
  ComparedRun old(2, "paper-1", {}, {}, {}, 22);
  old.data.row.frame_capabilities_json = "{}";
  old.data.corrections.reset();
  const RunAnalysis runs[] = {analyse(one.data).value(), analyse(old.data).value()};
  for (const Comparison& c : compare(runs)) {
    if (!c.is_answered()) continue;
    EXPECT_TRUE(c.shared.empty()) << c.quantity;
    EXPECT_FALSE(c.not_shared.empty()) << c.quantity;
  }
  EXPECT_EQ(compare(runs).front().refused, "");
}

TEST(Comparison, OfUnequalTimesContainsTheCreep) {
  Two two;
  two.a.creep_per_decade = two.b.creep_per_decade = 0.05;
  two.p_a.readings = two.p_b.readings = 40;
  two.p_b.settle = 120;  // 17 s
  const Comparison c = two.of(kLow);
  EXPECT_EQ(c.refused, "");
  EXPECT_THAT(c.remark(), HasSubstr("the times under load differ by"));
  EXPECT_LT((*c.ratio)[0], 2);
  EXPECT_GT((*c.ratio)[1], 2);
  two.p_b.settle = 600;
  expect_refused(two, kLow, "more than a factor of ten apart");
}

TEST(Comparison, OfUnequalRatesWithoutKnownCreepIsRefused) {
  Two two;
  two.p_a.ramps = two.p_b.ramps = true;
  EXPECT_EQ(two.of(kLow).refused, "");
  two.p_b.ramp_readings = 150;
  expect_refused(two, kLow, "the creep of");
}

TEST(Comparison, NamesSimulatedRunsAndOtherDifferences) {
  const ComparedRun one(1, "paper-1", {}, {}, {}, 31);
  ComparedRun two(2, "paper-1", {}, {}, {}, 32);
  two.data.row.simulated = true;
  two.data.row.specimen_text = "another text";
  two.data.listing.exit_status = ExitStatus::abort;
  const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
  const Comparison c = compare(runs).front();
  EXPECT_THAT(c.remark(), HasSubstr("run 1 is measured, run 2 is simulated"));
  EXPECT_THAT(c.remark(), HasSubstr("the file of specimen paper-1 was another"));
  EXPECT_THAT(c.remark(), HasSubstr("run 2 ended with abort"));
  EXPECT_THAT(c.verdict, HasSubstr("paper-1 in run 2 (simulated) is"));
  EXPECT_THAT(c.verdict, HasSubstr(": no difference is resolved"));
}

TEST(Comparison, AReplayedRunProvesNoInstrument) {
  const ComparedRun one(1, "paper-1", {}, {}, {}, 33);
  ComparedRun two(2, "paper-1", {}, {}, {}, 34);
  two.data.replayed = two.data.row.simulated = true;
  const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
  EXPECT_TRUE(compare(runs).front().shared.empty());
}

// Errors that a bench draws are those of one rig only if the seed of the rig is the same.
TEST(Comparison, ADrawnRigIsKnownByItsSeed) {
  const auto shared = [](const char* from, const char* to) {
    ComparedRun one(1, "paper-1", {}, {}, {}, 35), two(2, "paper-1", {}, {}, {}, 36);
    one.data.row.model_error_json = from;
    two.data.row.model_error_json = to;
    const RunAnalysis runs[] = {analyse(one.data).value(), analyse(two.data).value()};
    return compare(runs).front().shared.size();
  };
  EXPECT_EQ(shared("{}", "{}"), 3U);
  EXPECT_EQ(shared(R"({"drawn":{},"rig_seed":7})", R"({"drawn":{},"rig_seed":7})"), 3U);
  EXPECT_EQ(shared(R"({"drawn":{},"rig_seed":7})", R"({"drawn":{},"rig_seed":8})"), 0U);
  EXPECT_EQ(shared(R"({"drawn":{}})", R"({"drawn":{}})"), 0U);
}

TEST(Comparison, JsonSaysWhyAPairWasRefused) {
  Two two;
  two.p_b.probe_mm = 8;
  const auto j = to_json(two.of(kLow));
  EXPECT_THAT(j["refused"].get<std::string>(), HasSubstr("probes of"));
  EXPECT_TRUE(j["increase_percent"].is_null());
  EXPECT_TRUE(j["interval_percent"].is_null());
  EXPECT_TRUE(j["from_value"].is_number());
  EXPECT_TRUE(to_json(Two().of(kLow))["refused"].is_null());
}

}  // namespace
}  // namespace lcrig::comparison
