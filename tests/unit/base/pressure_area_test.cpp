// SPDX-License-Identifier: Apache-2.0
#include "base/pressure_area.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace lcrig {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

PressureArea of(double probe_mm, double disc_mm, bool plate = false,
                PressureOn on = PressureOn::probe) {
  PressureArea out;
  out.probe_diameter_m = probe_mm * 1e-3;
  out.disc_diameter_m = disc_mm * 1e-3;
  out.plate = plate;
  out.on = on;
  return out;
}

// 0.02 mm of the probe and 0.05 mm of a disc of up to 6 mm, 0.1 mm of a larger one.
TEST(PressureArea, DiffersBeyondTheLimitsOfBothDiameters) {
  EXPECT_FALSE(of(4, 4).differs());
  EXPECT_FALSE(of(4.069, 4).differs());
  EXPECT_TRUE(of(4.071, 4).differs());
  EXPECT_FALSE(of(7.89, 8).differs());
  EXPECT_TRUE(of(7.87, 8).differs());
  PressureArea worn = of(4.1, 4);
  worn.probe_limit_m = 0.1e-3;
  EXPECT_FALSE(worn.differs());
  EXPECT_EQ(of(4.069, 4).words(), "");
  PressureArea unknown = of(4, 8);
  unknown.disc_diameter_m.reset();
  EXPECT_FALSE(unknown.differs());
  EXPECT_FALSE(unknown.on_disc());
}

TEST(PressureArea, OfALargerProbeIsMoreOnTheDisc) {
  const PressureArea p = of(8, 4);
  EXPECT_NEAR(*p.area_m2(), 50.265e-6, 1e-9);
  EXPECT_NEAR(*p.on_disc(), 4, 1e-12);
  EXPECT_THAT(p.words(),
              AllOf(HasSubstr("over the probe of 8 mm"), HasSubstr("400 kPa on the disc of 4 mm")));
}

TEST(PressureArea, OfASmallerProbeHoldsForTheDiscOnlyUnderAPlate) {
  EXPECT_NEAR(*of(4, 8, true).on_disc(), 0.25, 1e-12);
  EXPECT_THAT(of(4, 8, true).words(),
              HasSubstr("25 kPa on the disc of 8 mm under its rigid plate"));
  EXPECT_TRUE(require_whole_disc(of(4, 8, true)));
  const PressureArea part = of(4, 8);
  EXPECT_TRUE(part.presses_part());
  EXPECT_FALSE(part.on_disc());
  EXPECT_THAT(part.words(), HasSubstr("presses only a part of the disc of 8 mm"));
  EXPECT_THAT(require_whole_disc(part).error().what,
              AllOf(HasSubstr("\"top\": \"plate\""), HasSubstr("a probe of at least 8 mm")));
}

TEST(PressureArea, OnTheDiscNeedsADiscThatIsPressedWhole) {
  const PressureArea p = of(8, 4, false, PressureOn::disc);
  EXPECT_NEAR(*p.area_m2(), 12.566e-6, 1e-9);
  EXPECT_NEAR(*p.on_disc(), 1, 1e-15);
  EXPECT_THAT(p.words(), AllOf(HasSubstr("over the disc of 4 mm"),
                               HasSubstr("is 25 kPa over the probe of 8 mm")));
  EXPECT_TRUE(require_area(p));
  EXPECT_THAT(require_area(of(4, 8, false, PressureOn::disc)).error().what,
              HasSubstr("presses only a part"));
  PressureArea no_disc = p, no_probe = p, nothing;
  no_disc.disc_diameter_m.reset();
  no_probe.probe_diameter_m.reset();
  EXPECT_THAT(require_area(no_disc).error().what, HasSubstr("no specimen is given"));
  EXPECT_THAT(require_area(no_probe).error().what, HasSubstr("fixture.probe_diameter_mm"));
  EXPECT_THAT(require_area(nothing).error().what, HasSubstr("fixture.probe_diameter_mm"));
}

TEST(PressureArea, IsToldInJson) {
  const auto j = to_json(of(8, 4));
  EXPECT_EQ(j["on"], "probe");
  EXPECT_NEAR(j["area_mm2"].get<double>(), 50.265, 1e-3);
  EXPECT_NEAR(j["disc_area_mm2"].get<double>(), 12.566, 1e-3);
  EXPECT_NEAR(j["on_disc_per_kPa"].get<double>(), 4, 1e-12);
  EXPECT_TRUE(j["differs"].get<bool>());
  EXPECT_TRUE(to_json(PressureArea())["area_mm2"].is_null());
}

}  // namespace
}  // namespace lcrig
