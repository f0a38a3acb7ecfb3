// SPDX-License-Identifier: Apache-2.0
// Random stacks over the whole range of the finite-element levels: laminates, soft tops, blocks
// from thin to as high as wide, plates, few and many capacitors, moduli from equal to 1e5 apart. A
// seed gives the same stack on every machine, because no distribution of the standard library is
// used. For judging error estimates (stack_truth.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "model/specimen.hpp"

namespace lcrig {

class StackDice {
 public:
  explicit StackDice(std::uint64_t seed) : state_(seed) {}

  double fraction() {  // 0 to 1, splitmix64
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
  }
  bool chance(double p) { return fraction() < p; }
  double logarithmic(double least, double most) {
    return least * std::pow(most / least, fraction());
  }
  double even(double least, double most) { return least + (most - least) * fraction(); }

 private:
  std::uint64_t state_;
};

enum class StackKind { laminate, bare_laminate, soft_top, block, thick_block, mixed };

// Mostly below 0.499, where the sheet's pressure decays within a few thicknesses; sometimes 0.5.
inline double draw_poisson_ratio(StackDice& dice) {
  const double which = dice.fraction();
  return which < 0.1    ? 0.5
         : which < 0.55 ? 0.5 - dice.logarithmic(1e-4, 0.05)
                        : dice.even(0.45, 0.499);
}

inline std::size_t draw_count(StackDice& dice) {
  const double most = dice.chance(0.2) ? 10.999 : 4.999;
  return static_cast<std::size_t>(dice.even(1, most));
}

inline Material draw_soft(StackDice& dice) {
  Material m;
  m.name = "soft";
  m.relative_permittivity = dice.even(2, 8);
  m.youngs_modulus_Pa = dice.logarithmic(6e4, 1e6);
  m.poisson_ratio = draw_poisson_ratio(dice);
  return m;
}

inline Material draw_film(StackDice& dice, double soft_modulus_Pa, double least_contrast) {
  Material m;
  m.name = "film";
  m.relative_permittivity = dice.even(2, 4);
  m.rigid = least_contrast > 1 && dice.chance(0.1);
  m.youngs_modulus_Pa = soft_modulus_Pa * dice.logarithmic(least_contrast, 1e5);
  m.poisson_ratio = dice.even(0.2, 0.45);
  return m;
}

inline void add_capacitors(StackDice& dice, StackKind kind, Specimen& s) {
  const bool thick = kind == StackKind::thick_block;
  const std::size_t count = thick ? 1 : draw_count(dice);
  const bool equal = dice.chance(0.5);
  double soft_m = 0, film_m = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || !equal) {
      soft_m = thick ? s.disc_diameter_m / (4 * dice.logarithmic(0.5, 5))
                     : dice.logarithmic(12e-6, 160e-6);
      film_m = dice.logarithmic(8e-6, 130e-6);
    }
    Capacitor c;
    const bool film = kind != StackKind::bare_laminate && kind != StackKind::block && !thick;
    if (kind == StackKind::soft_top) c.layers.push_back({1, film_m});
    c.layers.push_back({0, soft_m});
    if (film && kind != StackKind::soft_top) c.layers.push_back({1, film_m});
    s.capacitors.push_back(std::move(c));
  }
}

inline StackKind draw_kind(StackDice& dice) {
  const double which = dice.fraction();
  return which < 0.4    ? StackKind::laminate
         : which < 0.5  ? StackKind::bare_laminate
         : which < 0.65 ? StackKind::soft_top
         : which < 0.75 ? StackKind::block
         : which < 0.85 ? StackKind::thick_block
                        : StackKind::mixed;
}

inline Top draw_top(StackDice& dice) {
  const double which = dice.fraction();
  return which < 0.6 ? Top::pressure : which < 0.8 ? Top::plate : Top::bonded_plate;
}

inline Specimen random_stack(std::uint64_t seed) {
  StackDice dice(seed * 0x2545F4914F6CDD1DULL + 1);
  const StackKind kind = draw_kind(dice);
  const bool laminate = kind == StackKind::laminate || kind == StackKind::bare_laminate;
  Specimen s;
  s.name = "seed-" + std::to_string(seed);
  s.disc_diameter_m = dice.logarithmic(1.5e-3, 12e-3);
  s.faces = laminate ? Faces::bonded_laminate : Faces::bonded_base;
  s.top = kind == StackKind::laminate ? Top::pressure : draw_top(dice);
  s.materials.push_back(draw_soft(dice));
  const double least = kind == StackKind::mixed ? 1.0 : 100.0;
  s.materials.push_back(draw_film(dice, s.materials.front().youngs_modulus_Pa, least));
  add_capacitors(dice, kind, s);
  return s;
}

}  // namespace lcrig
