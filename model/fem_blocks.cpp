// SPDX-License-Identifier: Apache-2.0
#include "model/fem_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

constexpr double kNoLength_m = 1e9;

bool is_soft_block(const Specimen& s, const Block& block) {
  return s.is_soft(s.materials[block.material]);
}

// A soft sheet between stiff faces. SI.
struct Sheet {
  double thickness, shear, confined;  // m, Pa, Pa; confined: M = lambda + 2 mu, huge at nu = 0.5
  double pressure_length;  // m
};

Sheet sheet_of(const Specimen& s, const Block& block) {
  const Material& m = s.materials[block.material];
  const double nu = m.poisson_ratio;
  const double t = block.z1 - block.z0;
  const double mu = m.youngs_modulus_Pa / (2 * (1 + nu));
  const double ratio = std::min((2 - 2 * nu) / (1 - 2 * nu), 1e12);  // M/mu
  return {t, mu, mu * ratio, std::sqrt(ratio / 12) * t};
}

// Where the sheet yields like springs, a film bends over (4 D t/M)^1/4. Within its pressure length
// the sheet yields by flowing sideways, and the film bends over (D t^3/12 mu)^1/6.
double bending_length_m(const Specimen& s, const Block& film, const Sheet& sheet) {
  const Material& m = s.materials[film.material];
  const double h = film.z1 - film.z0;
  const double stiffness =
      m.youngs_modulus_Pa * h * h * h / (12 * (1 - m.poisson_ratio * m.poisson_ratio));  // N m
  const double t = sheet.thickness;
  const double on_springs = std::pow(4 * stiffness * t / sheet.confined, 0.25);
  return on_springs > sheet.pressure_length
             ? on_springs
             : std::pow(stiffness * t * t * t / (12 * sheet.shear), 1.0 / 6);
}

}  // namespace

std::vector<Block> find_blocks(const Specimen& s) {
  std::vector<Block> blocks;
  double z = 0;
  for (const auto& capacitor : s.capacitors) {
    for (const auto& layer : capacitor.layers) {
      const bool rigid = s.material(layer).rigid;
      const double top = z + layer.thickness_m;
      const bool joins = !blocks.empty() && blocks.back().material == layer.material &&
                         s.faces == Faces::bonded_base && !rigid;
      if (joins) {
        if (&layer == &capacitor.layers.front()) blocks.back().cuts.push_back(z);
        blocks.back().z1 = top;
      } else {
        blocks.push_back({z, top, layer.material, rigid, {}});
      }
      z = top;
    }
  }
  return blocks;
}

std::vector<double> decay_lengths_m(const Specimen& s, const std::vector<Block>& blocks) {
  std::vector<double> lengths;
  const auto add_bending = [&](const Block& film, const Sheet& sheet) {
    if (!film.rigid && !is_soft_block(s, film)) lengths.push_back(bending_length_m(s, film, sheet));
  };
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].rigid || !is_soft_block(s, blocks[i])) continue;
    const Sheet sheet = sheet_of(s, blocks[i]);
    lengths.push_back(sheet.pressure_length);
    if (i > 0) add_bending(blocks[i - 1], sheet);
    if (i + 1 < blocks.size()) add_bending(blocks[i + 1], sheet);
  }
  std::erase_if(lengths, [&](double length) { return !(length <= s.disc_diameter_m / 4); });
  std::sort(lengths.begin(), lengths.end());
  lengths.erase(std::unique(lengths.begin(), lengths.end()), lengths.end());
  return lengths;
}

double thinnest_soft_m(const Specimen& s, const std::vector<Block>& blocks) {
  double thinnest = kNoLength_m;
  for (const Block& block : blocks) {
    if (is_soft_block(s, block)) thinnest = std::min(thinnest, block.z1 - block.z0);
  }
  return thinnest;
}

}  // namespace lcrig
