// SPDX-License-Identifier: Apache-2.0
#include "model/specimen_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/specimen_stiffness.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

std::string text_with(const std::string& from, const std::string& to) {
  std::string text(shipped_specimens().front().text);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_refused(const std::string& from, const std::string& to, const std::string& message) {
  const auto s = parse_specimen(text_with(from, to), "disc.json");
  ASSERT_FALSE(s) << to;
  EXPECT_EQ(s.error().code, Errc::invalid_request);
  EXPECT_THAT(s.error().what, testing::HasSubstr("disc.json"));
  EXPECT_THAT(s.error().what, testing::HasSubstr(message)) << to;
}

TEST(SpecimenFile, ReadsTheShippedOnes) {
  ASSERT_EQ(shipped_specimens().size(), 3U);
  const Specimen s = shipped("paper-2");
  EXPECT_EQ(s.name, "paper-2");
  EXPECT_EQ(s.faces, Faces::free);
  EXPECT_EQ(s.top, Top::pressure);
  ASSERT_EQ(s.capacitors.size(), 2U);
  ASSERT_EQ(s.capacitors[1].layers.size(), 2U);
  EXPECT_DOUBLE_EQ(s.capacitors[1].layers[0].thickness_m, 25e-6);
  const Material& soft = s.material(s.capacitors[1].layers[0]);
  EXPECT_EQ(soft.name, "PDMS");
  EXPECT_DOUBLE_EQ(soft.youngs_modulus_Pa, 200e3);
  EXPECT_DOUBLE_EQ(soft.shear_modulus_Pa(), 42e3);
  EXPECT_TRUE(s.material(s.capacitors[1].layers[1]).rigid);
}

TEST(SpecimenFile, ShearModulusFollowsFromYoungs) {
  const auto s = parse_specimen(text_with(", \"shear_modulus_kPa\": 42", ""), "disc.json");
  ASSERT_TRUE(s) << s.error().what;
  EXPECT_DOUBLE_EQ(s->materials[0].name == "PDMS" ? s->materials[0].shear_modulus_Pa()
                                                  : s->materials[1].shear_modulus_Pa(),
                   200e3 / 2.98);
}

TEST(SpecimenFile, RefusesBadInput) {
  expect_refused("specimen/1", "specimen/2", "specimen/2");
  expect_refused("\"thickness_um\": 25", "\"thickness_um\": 0", "/capacitors/0/layers/0");
  expect_refused("\"thickness_um\": 25", "\"thickness_um\": -3", "/capacitors/0/layers/0");
  expect_refused("\"thickness_um\": 25", "\"thickness_um\": NaN", "disc.json");
  expect_refused("\"thickness_um\": 25", "\"thickness_kg\": 25", "thickness");
  expect_refused("0.49", "0.51", "/materials/PDMS/poisson_ratio");
  expect_refused("0.49", "-0.1", "/materials/PDMS/poisson_ratio");
  expect_refused("\"youngs_modulus_kPa\": 200", "\"youngs_modulus_kPa\": 0", "/materials/PDMS");
  expect_refused("\"youngs_modulus_kPa\": 200, ", "", "youngs_modulus_kPa");
  expect_refused("{ \"material\": \"PDMS\"", "{ \"material\": \"PMDS\"", "unknown material");
  expect_refused("\"free\"", "\"glued\"", "/faces");
  expect_refused("\"rigid\": true", "\"stiff\": true", "stiff");
  expect_refused("\"disc_diameter_mm\": 4.0", "\"disc_diameter_mm\": \"4\"", "/disc_diameter_mm");
  expect_refused("2.75", "0.5", "/materials/PDMS/relative_permittivity");
}

TEST(SpecimenFile, GapAndCreepAreOffUnlessAsked) {
  EXPECT_FALSE(shipped("paper-1").contact_gap);
  EXPECT_FALSE(shipped("paper-1").creep);
  const std::string faces = "\"faces\": \"free\",";
  const auto s = parse_specimen(
      text_with(faces, faces + " \"contact_gap\": { \"height_um\": 5, \"half_pressure_kPa\": 10 },"
                               " \"creep\": { \"fraction\": 0.03, \"time_s\": 10 },"),
      "disc.json");
  ASSERT_TRUE(s) << s.error().what;
  EXPECT_DOUBLE_EQ(s->contact_gap->height_m, 5e-6);
  EXPECT_DOUBLE_EQ(s->contact_gap->half_pressure_Pa, 10e3);
  EXPECT_DOUBLE_EQ(s->creep->fraction, 0.03);
  EXPECT_DOUBLE_EQ(s->creep->time_s, 10);
  expect_refused(faces, faces + " \"creep\": { \"fraction\": -1, \"time_s\": 10 },", "/creep");
}

TEST(SpecimenFile, RefusesEmptyStacks) {
  const std::string layers =
      "[ { \"material\": \"PDMS\", \"thickness_um\": 25 }, { \"material\": \"kapton\", "
      "\"thickness_um\": 75 } ]";
  expect_refused(layers, "[]", "/capacitors/0/layers");
  expect_refused("{ \"layers\": " + layers + " }", "", "/capacitors");
}

TEST(SpecimenFile, MissingFileSaysWhich) {
  const auto s = load_specimen("/no/such/disc.json");
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, Errc::io);
  EXPECT_THAT(s.error().what, testing::HasSubstr("/no/such/disc.json"));
}

// Two statements about the same modulus that disagree: the stiffer one gives the bound.
TEST(SpecimenFile, OfTwoModuliTheStifferOneBoundsTheShortening) {
  const auto both = parse_specimen(
      text_with("\"shear_modulus_kPa\": 42", "\"shear_modulus_kPa\": 10"), "disc.json");
  const auto one = parse_specimen(text_with(", \"shear_modulus_kPa\": 42", ""), "disc.json");
  ASSERT_TRUE(both);
  ASSERT_TRUE(one);
  EXPECT_DOUBLE_EQ(least_shortening(*both)(1.0), least_shortening(*one)(1.0));
}

}  // namespace
}  // namespace lcrig
