// SPDX-License-Identifier: Apache-2.0
// The specimen that is pressed: a stack of disc capacitors, each a stack of layers, listed from
// base to top. Used by the whole model and by all code that loads, plans or runs a specimen.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/enum_words.hpp"
#include "base/pressure_area.hpp"
#include "base/quantity.hpp"
#include "base/result.hpp"

namespace lcrig {

inline constexpr double kVacuumPermittivity_F_m = 8.8541878128e-12;  // CODATA 2018

// How the layers are held sideways. Nothing matters more: 100 kPa strains a 25 um layer seventeen
// times more when its faces slide than when they are bonded.
enum class Faces {
  free,  // every face slides without friction: uniaxial stress
  bonded_base,  // lowest face fixed to the base, layers stick to each other
  // As bonded_base, and every soft layer is bonded to stiff films on both sides: to those listed as
  // layers, or else to the electrodes, which are then rigid and without thickness.
  bonded_laminate,
};
template <>
inline constexpr EnumWords<3> kWordsOf<Faces>{"free", "bonded_base", "bonded_laminate"};

// What presses on the top face. Only the FEM levels depend on it.
enum class Top { pressure, plate, bonded_plate };  // uniform pressure; frictionless; bonded
template <>
inline constexpr EnumWords<3> kWordsOf<Top>{"pressure", "plate", "bonded_plate"};

struct Material {
  std::string name;
  double relative_permittivity = 1;
  bool rigid = false;  // does not strain at all; the elastic constants are then unused
  double youngs_modulus_Pa = 0;
  double poisson_ratio = 0;  // 0 to 0.5
  std::optional<double> given_shear_modulus_Pa;  // for the finite-strain levels

  // mu of the finite-strain levels, Pa: the given one if there is one, otherwise E/(2(1+nu)).
  double shear_modulus_Pa() const;
};

struct Layer {
  std::size_t material = 0;  // index into Specimen::materials
  double thickness_m = 0;
};

struct Capacitor {
  std::vector<Layer> layers;  // base to top; the electrodes are below the first and above the last
};

// Air under each electrode that remains until it is pressed out (roughness, partial contact). Under
// pressure P its height is height/(1 + P/half_pressure). Empirical; no physics stands behind it.
struct ContactGap {
  double height_m = 0;
  double half_pressure_Pa = 0;
};

// One Prony term: under a held force the layers finally strain as if the force were (1 + fraction)
// times as large; time_s is the time constant. Only the simulated bench uses it.
struct Creep {
  double fraction = 0;
  double time_s = 0;
};

struct Specimen {
  std::string name;
  double disc_diameter_m = 0;
  Faces faces = Faces::free;
  Top top = Top::pressure;
  std::vector<Material> materials;
  std::vector<Capacitor> capacitors;
  std::optional<ContactGap> contact_gap;  // off by default; set by the user
  std::optional<Creep> creep;  // likewise

  double area_m2() const;
  const Material& material(const Layer& layer) const { return materials[layer.material]; }
  // True for everything but films: neither rigid nor 100 times stiffer than the softest material of
  // the stack.
  bool is_soft(const Material& material) const;
  // t / eps_r summed over the dielectric between two electrodes, m.
  double dielectric_gap_m(const Capacitor& capacitor) const;
  double c0_F(const Capacitor& capacitor) const;  // without contact gap and fringe
  double c0_F() const;  // capacitors in parallel
  std::size_t layer_count() const;
};

// Errors: invalid_request with the place, for an empty stack, sizes that are not finite and
// positive, moduli and ratios out of range, or too many layers. All of model/ relies on a specimen
// that passed this check.
Result<> check_specimen(const Specimen& specimen);

// Adds the disc, and whether a plate on it spreads the force of a smaller probe.
void put_disc(const Specimen& specimen, PressureArea& pressure);

}  // namespace lcrig
