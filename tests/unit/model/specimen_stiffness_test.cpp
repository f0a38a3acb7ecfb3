// SPDX-License-Identifier: Apache-2.0
// The bound of how stiff a specimen can be, against formulas and levels that do not use it.
#include "model/specimen_stiffness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "model/level.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

constexpr double kShear_Pa = 10e3, kThickness_m = 1e-3;
constexpr double kLeastRise = 1.15;  // of the force, between two places that are compared

Specimen gel(double poisson_ratio, Faces faces = Faces::free, double thickness_m = kThickness_m) {
  Specimen s;
  s.name = "gel";
  s.disc_diameter_m = 4e-3;
  s.faces = faces;
  Material m;
  m.name = "gel";
  m.relative_permittivity = 2.75;
  m.poisson_ratio = poisson_ratio;
  m.youngs_modulus_Pa = 2 * kShear_Pa * (1 + poisson_ratio);
  s.materials = {m};
  s.capacitors = {Capacitor{{Layer{0, thickness_m}}}};
  return s;
}

// One compressed layer by W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2, from its stretches alone:
// l along the load, r across. `spring` holds it sideways: 0 leaves it free, infinity confines it.
class OwnLayer {
 public:
  OwnLayer(double poisson_ratio, double spring)
      : lame_(2 * poisson_ratio / (1 - 2 * poisson_ratio)), spring_(spring) {}
  double pressure_Pa(double strain) const {
    const double l = 1 - strain, r = across(l);
    return kShear_Pa * (1 / l - l - lame_ * std::log(l * r * r) / l);
  }

 private:
  // The lateral pull r^2 - 1 + lambda ln J + spring r (r - 1) vanishes.
  double across(double l) const {
    double low = 1, high = 100;
    if (std::isinf(spring_)) return low;
    for (int i = 0; i < 200; ++i) {
      const double r = std::sqrt(low * high);
      const double pull = r * r - 1 + lame_ * std::log(l * r * r) + spring_ * r * (r - 1);
      (pull < 0 ? low : high) = r;
    }
    return low;
  }
  double lame_, spring_;  // over the shear modulus
};

// At each force the specimen must give way by at least as much as the bound says.
class Compared {
 public:
  explicit Compared(const Specimen& s) : least_m_(least_shortening(s)) {}
  void add(double force_N, double shortening_m) {
    if (force_N < kLeastRise * force_N_) return;
    if (force_N_ > 0) {
      const double bound_m = least_m_(force_N) - least_m_(force_N_);
      worst_ = std::max(worst_, bound_m / (shortening_m - shortening_m_));
      ++places_;
    }
    force_N_ = force_N;
    shortening_m_ = shortening_m;
  }
  double worst() const { return worst_; }
  int places() const { return places_; }

 private:
  std::function<double(double)> least_m_;
  double force_N_ = 0, shortening_m_ = 0, worst_ = 0;
  int places_ = 0;
};

TEST(LeastShortening, NothingThatHoldsALayerSidewaysMakesItStiffer) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double nu : {0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.48, 0.49, 0.495, 0.499}) {
    const Specimen s = gel(nu);
    for (const double spring : {0.0, 0.03, 0.3, 3.0, 30.0, 300.0, 3e3, kInfinity}) {
      Compared compared(s);
      const OwnLayer layer(nu, spring);
      for (double strain = 1e-3; strain <= 0.9; strain += 1e-3) {
        compared.add(layer.pressure_Pa(strain) * s.area_m2(), strain * kThickness_m);
      }
      EXPECT_LT(compared.worst(), 1.01) << "nu " << nu << ", spring " << spring;
      EXPECT_GT(compared.places(), 20);
    }
  }
}

// Where films hold a layer, its compliance falls with the force more slowly than the bound's; where
// the bound is exact, it is not far above.
TEST(LeastShortening, IsThatOfTheStifferOfTheTwoEnds) {
  const Specimen s = gel(0.45);
  const auto least_m = least_shortening(s);
  const OwnLayer is_free(0.45, 0), confined(0.45, std::numeric_limits<double>::infinity());
  const auto step = [&](const OwnLayer& layer, double strain) {
    const double from_N = layer.pressure_Pa(strain) * s.area_m2();
    const double to_N = layer.pressure_Pa(strain + 0.02) * s.area_m2();
    return (least_m(to_N) - least_m(from_N)) / (0.02 * kThickness_m);
  };
  EXPECT_NEAR(step(confined, 0.02), 1, 0.03);
  EXPECT_NEAR(step(is_free, 0.8), 1, 0.07) << "other strain energies are a little stiffer";
  EXPECT_LT(step(is_free, 0.02), 0.3);
}

struct LevelCase {
  LevelSettings settings;
  Faces faces;
  Top top;
};

std::vector<LevelCase> level_cases() {
  std::vector<LevelCase> out;
  const auto add = [&out](Level level, Faces faces, Top top = Top::pressure) -> LevelSettings& {
    out.push_back({{}, faces, top});
    out.back().settings.level = level;
    out.back().settings.mesh.refinement = 0;
    return out.back().settings;
  };
  add(Level::linear, Faces::free);
  for (const EnergyForm form :
       {EnergyForm::a, EnergyForm::b, EnergyForm::c, EnergyForm::d, EnergyForm::e}) {
    for (const Lateral lateral : {Lateral::free, Lateral::confined}) {
      LevelSettings& settings = add(Level::hyperelastic, Faces::free);
      settings.form = form;
      settings.lateral = lateral;
    }
  }
  for (const bool nonlinear : {false, true}) {
    add(Level::bonded, Faces::bonded_laminate).nonlinear = nonlinear;
  }
  for (const Level level : {Level::fem_linear, Level::fem_finite}) {
    for (const Top top : {Top::pressure, Top::plate, Top::bonded_plate}) {
      add(level, Faces::free, top);
      add(level, Faces::bonded_base, top);
    }
  }
  return out;
}

TEST(LeastShortening, NoLevelOfTheModelIsStiffer) {
  int places = 0, deep = 0;
  for (const double thickness_m : {0.5e-3, 2e-3}) {
    for (const double nu : {0.0, 0.3, 0.45, 0.49}) {
      for (const LevelCase& c : level_cases()) {
        Specimen s = gel(nu, c.faces, thickness_m);
        s.top = c.top;
        auto model = make_level_model(s, c.settings);
        if (!model) continue;  // this level does not know these faces
        Compared compared(s);
        double strain = 0;
        for (double p = 1e-2 * kShear_Pa; p < 3e3 * kShear_Pa && strain < 0.9; p *= 1.3) {
          const auto state = (*model)->at_pressure(Pressure::from_si(p));
          if (!state) break;
          strain = state->shortening_m / thickness_m;
          compared.add(p * s.area_m2(), state->shortening_m);
        }
        EXPECT_LT(compared.worst(), 1.01)
            << to_string(c.settings.level) << ' ' << to_string(c.settings.form) << ' '
            << to_string(c.settings.lateral) << ' ' << to_string(c.faces) << ' ' << to_string(c.top)
            << ", nu " << nu << ", " << thickness_m << " m, up to strain " << strain;
        places += compared.places();
        deep += strain > 0.6 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(places, 1000);
  EXPECT_GT(deep, 50);
}

// Two statements of one thing that disagree: pressed flat, the softer one is the stiffer.
TEST(LeastShortening, EachOfTwoModuliBoundsIt) {
  Specimen both = gel(0.45), soft = gel(0.45);
  both.materials[0].given_shear_modulus_Pa = kShear_Pa / 4;
  soft.materials[0].given_shear_modulus_Pa = kShear_Pa / 4;
  soft.materials[0].youngs_modulus_Pa /= 4;
  const auto both_m = least_shortening(both), soft_m = least_shortening(soft),
             hard_m = least_shortening(gel(0.45));
  const auto step = [](const auto& f, double force) { return f(1.1 * force) - f(force); };
  EXPECT_DOUBLE_EQ(step(both_m, 0.01), step(hard_m, 0.01));
  EXPECT_NEAR(step(both_m, 1.5) / step(soft_m, 1.5), 1, 1e-9);
  EXPECT_LT(step(soft_m, 1.5), 0.9 * step(hard_m, 1.5));
}

// Held at F until it has crept, a layer answers to more force like one under (1 + fraction) F.
TEST(LeastShortening, CountsWithALayerThatHasCrept) {
  Specimen s = gel(0.45);
  const auto fresh_m = least_shortening(s);
  s.creep = Creep{0.2, 30};
  const auto crept_m = least_shortening(s);
  for (const double force : {0.02, 0.5, 2.0}) {
    const double more = 1e-3 * force;
    EXPECT_LE(crept_m(force + more) - crept_m(force),
              fresh_m(1.2 * force + more) - fresh_m(1.2 * force) + 1e-12);
  }
}

}  // namespace
}  // namespace lcrig
