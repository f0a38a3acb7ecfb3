// SPDX-License-Identifier: Apache-2.0
// The stack as a finite-element space: displacement of degree two or four in each direction on a
// tensor grid. The equations of fixed, tied and sliding nodes are already worked out. Used by the
// finite-element levels.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/result.hpp"
#include "model/fem_mesh.hpp"
#include "model/lagrange.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// Elastic constants of one row of cells. SI.
struct ElasticLaw {
  double mu = 0;  // Pa
  double inverse_lambda = 0;  // 1/Pa; 0: incompressible
  bool operator==(const ElasticLaw&) const = default;
};
// If 1/lambda is below this times 1/mu, condensing the pressure in a cell would lose digits.
// Iterating then reaches the smaller true value in one or two more solves.
inline constexpr double kLeastInverseLambda = 1e-7;
// finite: computed from mu and nu. Otherwise computed from E and nu.
ElasticLaw elastic_law(const Material& material, bool finite);

// A height in the mesh: a row of cells, and the place in it from -1 (bottom) to 1 (top).
struct Height {
  int row = -1;  // -1: it is in no row but in a rigid layer
  double zeta = 0;
};

// Variations that a specimen file cannot describe, for verification against known solutions.
struct SpaceVariation {
  // cells for each block's height, and twice as many along the radius; 0: the graded mesh
  int uniform_cells = 0;
  bool wall = false;  // the rim slides along a rigid wall
  std::function<double(double r_m)> load;  // pressure profile over the top; empty: 1
};

class StackSpace {
 public:
  struct Row {
    std::array<int, kMostNodes> line;  // node lines from bottom to top; degree + 1 of them count
    double z0, z1;  // m
    ElasticLaw law;
  };
  // A layer of the stack, for the capacitance.
  struct Slab {
    double thickness_m, relative_permittivity;
    bool rigid;
    Height bottom, top;  // unused when rigid
  };

  // Errors: more unknowns than allowed; faces and top contradict each other.
  static Result<StackSpace> make(const Specimen& specimen, const MeshSettings& mesh, bool finite,
                                 const SpaceVariation& variation = {});

  int degree() const { return degree_; }  // of the displacement, in each direction
  const std::vector<double>& radii() const { return r_; }  // nodes, m
  const std::vector<Row>& rows() const { return rows_; }
  using Capacitor = std::vector<Slab>;  // base to top
  const std::vector<Capacitor>& capacitors() const { return capacitors_; }
  int cells_per_row() const { return static_cast<int>(r_.size() - 1) / degree_; }
  int equations() const { return equations_; }
  // Equation of a node's displacement (component 0: radial, 1: axial). -1: the node is fixed.
  int equation(int line, int node, int component) const {
    return equation_[static_cast<std::size_t>(component)]
                    [static_cast<std::size_t>(line) * r_.size() + static_cast<std::size_t>(node)];
  }
  // Nodal forces of a unit dead pressure on the top face, by equation, N per Pa.
  const std::vector<double>& unit_load() const { return unit_load_; }
  double radius_m() const { return r_.back(); }
  // Area of the uppermost soft face under displacements u, divided by its area at rest.
  double top_area_ratio(const std::vector<double>& u) const;
  // The place of a height z (m, undeformed) in the rows of the soft layers.
  Height height(double z) const;
  // The capacitors that result from other cuts of the block. Errors: the stack is not one block of
  // one soft material, or the thicknesses (m, base to top) do not add up to it.
  Result<std::vector<Capacitor>> partition(const std::vector<double>& thickness_m) const;
  // Displacements u (by equation) at the nodes of a height.
  std::vector<double> displacement(const std::vector<double>& u, Height h, int component) const;
  // How far the top face (or the rigid top) went down, m, as the mean over its area.
  double shortening_m(const std::vector<double>& u) const;

 private:
  friend class SpaceBuilder;
  int degree_ = 2;
  std::vector<double> r_;
  std::vector<Row> rows_;
  std::vector<Capacitor> capacitors_;
  std::array<std::vector<int>, 2> equation_;
  int equations_ = 0;
  std::vector<double> unit_load_;
  double area_m2_ = 0;
  int top_line_ = -1;  // -1: nothing can move
  bool one_field_ = false;  // one block without films in it
};

}  // namespace lcrig
