// SPDX-License-Identifier: Apache-2.0
// The upper bound of how hard the specimen can push back: specimen and frame in series, each as
// stiff as it can be. Plan and run compute with it how far the force rises while the frame stops.
#pragma once

#include <functional>
#include <limits>
#include <vector>

namespace lcrig {

// Travel beyond contact under a force, m: 0 at 0 N, then increasing. Empty: it does not give way.
using Compression = std::function<double(double force_N)>;

class ForceBound {
 public:
  // `specimen_m`: the least shortening of the specimen, tabulated here. Without it and without a
  // stiffness of the frame the force is unbounded: force_after_N is infinite.
  explicit ForceBound(const Compression& specimen_m,
                      double frame_stiffness_N_m = std::numeric_limits<double>::infinity());

  // The stiffness in each cell of the grid of forces, N/m, to be stored; and the bound again. A
  // table of another grid is unbounded where it ends.
  const std::vector<double>& table_N_m() const { return stiffness_; }
  static ForceBound from_table(std::vector<double> stiffness_N_m);

  // Lowers the bound by a known stiffness: nowhere is the contact stiffer than growth(force) times
  // `stiffness_N_m`.
  void limit_to(double stiffness_N_m, const std::function<double(double force_N)>& growth);

  // Raises the bound: nowhere is the contact less stiff than `other`.
  void at_least(const ForceBound& other);

  bool is_bounded() const;
  // The largest stiffness that the contact can have at this force, N/m.
  double stiffness_N_m(double force_N) const;
  // The force after `way_m` towards the specimen. It exceeds stiffness times way, because a contact
  // stiffens.
  double force_after_N(double force_N, double way_m) const;
  // The largest force from which `way_m` leads to at most `force_N`; 0 when the whole compression
  // is shorter than that.
  double force_before_N(double force_N, double way_m) const;
  // The least way from one force to a larger one.
  double way_m(double from_N, double to_N) const;

 private:
  ForceBound() = default;

  std::vector<double> stiffness_;  // of each cell of the force grid, N/m
};

}  // namespace lcrig
