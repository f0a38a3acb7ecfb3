// SPDX-License-Identifier: Apache-2.0
// One homogeneous layer under compression: the stretch under a pressure, for every strain-energy
// form. Used by the levels `hyperelastic` and `bonded` and for bounds on a specimen's stiffness.
#pragma once

#include "base/enum_words.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"

namespace lcrig {

// Strain energies, I1 = tr(F^T F). `a` is the default and the only form of fem_finite.
enum class EnergyForm {
  incompressible,  // mu/2 (I1 - 3), J = 1
  a,  // mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2
  b,  // mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2
  c,  // mu/2 (I1 - 3 - 2 ln J) + lambda/2 (J - 1)^2
  d,  // mu/2 (J^(-2/3) I1 - 3) + K/4 (J^2 - 1 - 2 ln J)
  e,  // mu/2 (I1 - 3 - 2 ln J) + lambda/4 (J^2 - 1 - 2 ln J)
};
template <>
inline constexpr EnumWords<6> kWordsOf<EnergyForm>{"I", "A", "B", "C", "D", "E"};

enum class Lateral { free, confined };  // uniaxial stress; uniaxial strain
template <>
inline constexpr EnumWords<2> kWordsOf<Lateral>{"free", "confined"};
enum class PressureKind { dead, true_area };  // force over reference or over current area
template <>
inline constexpr EnumWords<2> kWordsOf<PressureKind>{"dead", "true"};

struct Stretch {
  double strain = 0;  // e = 1 - lambda_z, to full relative precision at any pressure
  double log_lambda_z = 0;
  double log_lambda_r = 0;
  double log_j = 0;  // ln of the volume ratio
};

// A neo-Hookean layer with shear modulus mu and Poisson ratio 0 <= nu <= 0.5. At 0.5, forms A to E
// become the incompressible one. Precondition: pressure >= 0. Errors: bad input; no equilibrium
// (form B beyond its largest pressure).
Result<Stretch> solve_stretch(Pressure shear_modulus, double poisson_ratio, EnergyForm form,
                              Lateral lateral, PressureKind kind, Pressure pressure);

}  // namespace lcrig
