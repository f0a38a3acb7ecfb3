// SPDX-License-Identifier: Apache-2.0
#include "model/plausible.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "model/specimen_figures.hpp"
#include "model/specimen_file.hpp"

namespace lcrig {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Specimen paper() {
  return parse_specimen(shipped_specimens().front().text, "paper-1").value();
}

// A disc of 10 mm, one layer of 100 um between rigid films would not matter: E 200 kPa, free.
Specimen one_layer() {
  return parse_specimen(R"({ "format": "specimen/1", "name": "one", "disc_diameter_mm": 10,
      "faces": "free", "materials": { "m": { "relative_permittivity": 3, "youngs_modulus_kPa": 200,
      "poisson_ratio": 0.49 } },
      "capacitors": [ { "layers": [ { "material": "m", "thickness_um": 100 } ] } ] })",
                        "one")
      .value();
}

TEST(Plausible, ShippedSpecimensAre) {
  for (const ShippedSpecimen& shipped : shipped_specimens()) {
    EXPECT_THAT(implausible_values(parse_specimen(shipped.text, "x").value()), IsEmpty());
  }
}

TEST(Plausible, AThicknessOf60mmAndAModulusOf69PaAreNot) {
  Specimen thick = paper();
  thick.capacitors[0].layers[0].thickness_m = 60e-3;
  EXPECT_THAT(implausible_values(thick),
              ElementsAre(AllOf(HasSubstr("capacitor 1, layer 1: thickness of 60000 um"),
                                HasSubstr("0.07 to 2000 um"), HasSubstr("ISO 844"))));
  Specimen soft = one_layer();
  soft.materials[0].youngs_modulus_Pa = 69;
  EXPECT_THAT(implausible_values(soft), ElementsAre(AllOf(HasSubstr("Young's modulus of 0.069 kPa"),
                                                          HasSubstr("softest gels"))));
}

// Each value of a file, a thousand times too large and too small: a unit that was left out.
TEST(Plausible, AWrongPrefixIsNoticedInEachValueButTheShippedRange) {
  const Specimen good = one_layer();
  ASSERT_THAT(implausible_values(good), IsEmpty());
  for (const double factor : {1e-6, 1e6}) {
    Specimen disc = good, modulus = good, thickness = good, rough = good;
    disc.disc_diameter_m *= factor;
    modulus.materials[0].youngs_modulus_Pa *= factor * (factor > 1 ? 100 : 1);
    thickness.capacitors[0].layers[0].thickness_m *= factor;
    EXPECT_THAT(implausible_values(disc), Not(IsEmpty())) << factor;
    EXPECT_THAT(implausible_values(modulus), Not(IsEmpty())) << factor;
    EXPECT_THAT(implausible_values(thickness), Not(IsEmpty())) << factor;
  }
  Specimen polar = good;
  polar.materials[0].relative_permittivity = 3e5;
  EXPECT_THAT(implausible_values(polar), ElementsAre(HasSubstr("relative permittivity")));
  Specimen rough = good;
  rough.contact_gap = ContactGap{1e-3, 1e3};
  EXPECT_THAT(implausible_values(rough), ElementsAre(HasSubstr("contact gap: height")));
}

// eps0 eps A / t = 8.8541878128e-12 * 3 * 78.5398e-6 m2 / 100e-6 m = 20.862 pF; E A / t = 200e3 *
// 78.5398e-6 / 100e-6 = 157.08 N/mm.
TEST(SpecimenFigures, AreThoseOfAPlateCapacitorAndASpring) {
  const SpecimenFigures f = figures_of(one_layer());
  EXPECT_NEAR(f.c0_F, 20.862e-12, 1e-15);
  EXPECT_NEAR(f.area_m2, 78.5398e-6, 1e-10);
  EXPECT_NEAR(f.thickness_m, 100e-6, 1e-12);
  ASSERT_TRUE(f.stiffness_N_m);
  EXPECT_NEAR(*f.stiffness_N_m, 157.08e3, 0.01 * 157.08e3);
  EXPECT_THAT(to_text(f), AllOf(HasSubstr("20.862 pF"), HasSubstr("100 um in 1 layers"),
                                HasSubstr("N/mm"), HasSubstr("78.54 mm2")));
}

}  // namespace
}  // namespace lcrig
