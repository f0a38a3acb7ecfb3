// SPDX-License-Identifier: Apache-2.0
#include "model/fem_space.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "model/fem_blocks.hpp"
#include "model/gauss.hpp"

namespace lcrig {
namespace {

// How a node line moves.
struct Line {
  bool radial_fixed = false;
  bool axial_fixed = false;
  int tie = -1;  // all nodes of all lines with the same number move together
  int axial_twin = -1;  // each node has the axial displacement of its counterpart on that line
};

}  // namespace

ElasticLaw elastic_law(const Material& m, bool finite) {
  const double mu =
      finite ? m.shear_modulus_Pa() : m.youngs_modulus_Pa / (2 * (1 + m.poisson_ratio));
  const double nu = m.poisson_ratio;
  constexpr double kNoLambda = 1e12;  // a material with nu = 0 gets mu over this as its lambda
  const double ratio = nu > 0 ? (1 - 2 * nu) / (2 * nu) : kNoLambda;
  return {mu, std::min(ratio, kNoLambda) / mu};
}

class SpaceBuilder {
 public:
  SpaceBuilder(const Specimen& specimen, const MeshSettings& mesh, bool finite,
               const SpaceVariation& variation)
      : s_(specimen),
        variation_(variation),
        mesh_(mesh),
        finite_(finite),
        bonded_(specimen.faces != Faces::free),
        blocks_(find_blocks(specimen)),
        style_{mesh.refinement,
               bonded_,
               blocks_.size() == 1,
               finite || mesh.mild_corners,
               thinnest_soft_m(specimen, blocks_),
               decay_lengths_m(specimen, blocks_)} {}

  Result<StackSpace> build() {
    if (!bonded_ && s_.top == Top::bonded_plate) {
      return fail(Errc::invalid_request,
                  "specimen {}: faces `free` and top `bonded_plate` contradict each other",
                  s_.name);
    }
    if (mesh_.refinement < kCoarsestMember || mesh_.refinement > kFinestMember) {
      return fail(Errc::invalid_request, "mesh refinement {} must be {} to {}", mesh_.refinement,
                  kCoarsestMember, kFinestMember);
    }
    space_.area_m2_ = s_.area_m2();
    space_.degree_ = style_.degree();
    add_radii();
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (blocks_[i].rigid) {
        add_rigid();
      } else {
        add_block(blocks_[i]);
        add_film_above(i);
      }
      if (unknowns() > mesh_.max_unknowns) {
        return fail(
            Errc::invalid_request,
            "specimen {}: the mesh needs more than {} unknowns; take a coarser mesh or fewer "
            "layers",
            s_.name, mesh_.max_unknowns);
      }
    }
    close_top();
    space_.top_line_ = below_;
    space_.one_field_ = blocks_.size() == 1 && s_.faces != Faces::bonded_laminate;
    number();
    add_load();
    add_slabs();
    return std::move(space_);
  }

 private:
  void add_radii() {
    const double radius = s_.disc_diameter_m / 2;
    const auto edges = variation_.uniform_cells > 0
                           ? even_edges(0, radius, 2 * variation_.uniform_cells)
                           : radial_edges(radius, style_);
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
      const auto nodes = even_edges(edges[i], edges[i + 1], space_.degree_);
      space_.r_.insert(space_.r_.end(), nodes.begin(), nodes.end() - 1);
    }
    space_.r_.push_back(edges.back());
  }

  void add_block(const Block& block) {
    const Material& m = s_.materials[block.material];
    const ElasticLaw law = elastic_law(m, finite_);
    const bool stiff = !soft(block);
    const auto z = variation_.uniform_cells > 0
                       ? even_edges(block.z0, block.z1, variation_.uniform_cells)
                       : axial_edges(block.z0, block.z1, stiff, style_, block.cuts);
    int bottom = below_;
    if (on_base_ || tie_below_ >= 0 || !bonded_) {
      bottom = add_line();
      Line& line = lines_.back();
      line.axial_fixed = on_base_;
      line.tie = tie_below_;
      line.radial_fixed = bonded_;  // the base and rigid layers hold what is bonded to them
      line.axial_twin = !on_base_ && tie_below_ < 0 ? below_ : -1;
    }
    for (std::size_t i = 0; i + 1 < z.size(); ++i) {
      auto& row = space_.rows_.emplace_back(StackSpace::Row{{bottom}, z[i], z[i + 1], law});
      for (int k = 1; k <= space_.degree_; ++k) {
        bottom = row.line[static_cast<std::size_t>(k)] = add_line();
      }
    }
    below_ = bottom;
    tie_below_ = -1;
    on_base_ = false;
  }

  // A rigid layer ties the line below it and the line above it together.
  void add_rigid() {
    if (below_ >= 0 && tie_below_ < 0) {
      tie_below_ = ties_++;
      Line& line = lines_[static_cast<std::size_t>(below_)];
      line.tie = tie_below_;
      line.radial_fixed = bonded_;
    }
  }

  // In a laminate every soft layer lies between stiff films. Where the specimen lists no film above
  // a soft layer, the electrode is the film: rigid and without thickness.
  void add_film_above(std::size_t block) {
    const bool next_is_film = block + 1 < blocks_.size() && !soft(blocks_[block + 1]);
    if (s_.faces == Faces::bonded_laminate && soft(blocks_[block]) && !next_is_film) add_rigid();
  }

  bool soft(const Block& block) const { return s_.is_soft(s_.materials[block.material]); }

  int add_line() {
    lines_.emplace_back();
    return static_cast<int>(lines_.size()) - 1;
  }

  void close_top() {
    if (below_ < 0 || s_.top == Top::pressure) return;
    Line& line = lines_[static_cast<std::size_t>(below_)];
    if (line.tie < 0) line.tie = ties_++;
    line.radial_fixed = line.radial_fixed || s_.top == Top::bonded_plate;
  }

  void number() {
    const std::size_t nodes = space_.r_.size();
    std::vector<int> tied(static_cast<std::size_t>(ties_), -1);
    int next = 0;
    for (auto& component : space_.equation_) component.assign(lines_.size() * nodes, -1);
    for (std::size_t l = 0; l < lines_.size(); ++l) {
      const Line& line = lines_[l];
      for (std::size_t i = 0; i < nodes; ++i) {
        const bool at_wall = variation_.wall && i + 1 == nodes;
        if (i > 0 && !line.radial_fixed && !at_wall) space_.equation_[0][l * nodes + i] = next++;
        int& axial = space_.equation_[1][l * nodes + i];
        if (line.axial_fixed) continue;
        if (line.axial_twin >= 0) {
          axial = space_.equation_[1][static_cast<std::size_t>(line.axial_twin) * nodes + i];
        } else if (line.tie >= 0) {
          int& shared = tied[static_cast<std::size_t>(line.tie)];
          shared = shared < 0 ? next++ : shared;
          axial = shared;
        } else {
          axial = next++;
        }
      }
    }
    space_.equations_ = next;
  }

  // Consistent nodal forces: the integral of 2 pi R N times the profile, by five Gauss points.
  void add_load() {
    space_.unit_load_.assign(static_cast<std::size_t>(space_.equations_), 0);
    if (below_ < 0) return;
    const auto& r = space_.r_;
    const auto degree = static_cast<std::size_t>(space_.degree_);
    for (std::size_t i = 0; i + degree < r.size(); i += degree) {
      const double half = (r[i + degree] - r[i]) / 2;
      for (const auto& [x, weight] : kGauss5) {
        const double radius = r[i] + (1 + x) * half;
        const double force = 2 * std::numbers::pi * radius * half * weight *
                             (variation_.load ? variation_.load(radius) : 1);
        const auto shape = lagrange(space_.degree_, x).value;
        for (std::size_t k = 0; k <= degree; ++k) {
          const int eq = space_.equation(below_, static_cast<int>(i + k), 1);
          if (eq >= 0) space_.unit_load_[static_cast<std::size_t>(eq)] -= force * shape[k];
        }
      }
    }
  }

  void add_slabs() {
    double z = 0;
    for (const auto& capacitor : s_.capacitors) {
      auto& slabs = space_.capacitors_.emplace_back();
      for (const auto& layer : capacitor.layers) {
        const Material& m = s_.material(layer);
        const double top = z + layer.thickness_m;
        StackSpace::Slab slab{layer.thickness_m, m.relative_permittivity, m.rigid, {}, {}};
        if (!m.rigid) {
          const double inside = 1e-9 * layer.thickness_m;  // stays within this layer's own rows
          slab.bottom = space_.height(z + inside);
          slab.top = space_.height(top - inside);
        }
        slabs.push_back(slab);
        z = top;
      }
    }
  }

  std::size_t unknowns() const { return 2 * space_.r_.size() * lines_.size(); }

  const Specimen& s_;
  const SpaceVariation& variation_;
  const MeshSettings& mesh_;
  bool finite_, bonded_;
  std::vector<Block> blocks_;
  MeshStyle style_;
  StackSpace space_;
  std::vector<Line> lines_;
  int below_ = -1;  // line that the next block stands on; -1: the base
  int tie_below_ = -1;  // tie of the rigid layer that the next block stands on; -1: none
  bool on_base_ = true;  // nothing below can move
  int ties_ = 0;
};

Result<StackSpace> StackSpace::make(const Specimen& specimen, const MeshSettings& mesh, bool finite,
                                    const SpaceVariation& variation) {
  return SpaceBuilder(specimen, mesh, finite, variation).build();
}

}  // namespace lcrig
