// SPDX-License-Identifier: Apache-2.0
// A level of the model, tabulated once as a monotone interpolant. Simulated benches and the plan of
// a run evaluate it.
#pragma once

#include <memory>
#include <vector>

#include "model/level.hpp"
#include "model/plant.hpp"

namespace lcrig {

// Monotone cubic through samples of a function that rises from 0 at 0, on a uniform grid. Beyond
// the last sample it continues as a straight line with the last slope.
class MonotoneTable {
 public:
  MonotoneTable() = default;
  // values[0] == 0, rising; initial_slope is the slope at 0.
  MonotoneTable(double step, const std::vector<double>& values, double initial_slope);
  double operator()(double x) const;

 private:
  struct Node {
    double value, slope;
  };
  double step_ = 1;
  std::vector<Node> nodes_;
};

class TabulatedResponse final : public SpecimenResponse {
 public:
  TabulatedResponse(double c0_F, MonotoneTable shortening, MonotoneTable delta, double max_force_N,
                    double relative_error)
      : c0_F_(c0_F),
        shortening_(std::move(shortening)),
        delta_(std::move(delta)),
        max_force_N_(max_force_N),
        relative_error_(relative_error) {}

  double shortening_m(double force_N) const override { return shortening_(force_N); }
  double capacitance_F(double force_N) const override { return c0_F_ + delta_(force_N); }
  double delta_capacitance_F(double force_N) const { return delta_(force_N); }
  double c0_F() const override { return c0_F_; }
  double max_force_N() const { return max_force_N_; }  // both curves are straight beyond it
  // of the table with respect to its level
  double relative_error() const { return relative_error_; }

 private:
  double c0_F_;
  MonotoneTable shortening_, delta_;
  double max_force_N_, relative_error_;
};

// Tabulates `settings` from 0 to max_force (dead load over the disc area). Shortening and delta C
// deviate from the level by at most tolerance/10, relative, at every force; this is verified while
// the table is built. If the level finds no equilibrium at some force, the table ends at the last
// force it could solve (see max_force_N()). Errors: as make_level_model; tolerance outside 1e-6 to
// 1; not even a thousandth of max_force can be solved.
Result<std::unique_ptr<TabulatedResponse>> make_response(const Specimen& specimen,
                                                         const LevelSettings& settings,
                                                         Force max_force, double tolerance);

}  // namespace lcrig
