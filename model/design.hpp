// SPDX-License-Identifier: Apache-2.0
// Finds the best partition of a soft block into capacitors. `lcrig model design` prints it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/quantity.hpp"
#include "model/specimen.hpp"

namespace lcrig {

struct DesignRequest {
  int capacitors = 4;
  Length total = Length::from_si(1e-3);
  Length least_layer = Length::from_si(0.1e-3);
  Length disc_diameter = Length::from_si(4e-3);
  // with `bonded_laminate` every layer lies between rigid electrodes
  Faces faces = Faces::bonded_base;
  Top top = Top::pressure;
  Material material{"PDMS", 2.75, false, 200e3, 0.49, {}};
  Pressure max_pressure = Pressure::from_si(100e3);  // end of the range of the fitted sensitivity
};

struct DesignOption {
  std::string placement;
  std::vector<double> thickness_m;  // base to top
  double c0_F = 0;
  double initial_F_Pa = 0;  // sensitivity at zero pressure
  // straight line through 11 points up to max_pressure; 0: one of them cannot be solved
  double fitted_F_Pa = 0;
  double gain = 0;  // initial sensitivity over that of equal layers, less 1
};

struct Design {
  std::vector<DesignOption> options;  // best first
  std::string method;  // closed form or computation, and the reason for it
  // step of the grid on which every partition was tried; 0: the closed form needs no search
  double search_grid_m = 0;
};

// Errors: capacitors * least_layer > total; sizes out of range.
Result<Design> design_partition(const DesignRequest& request);

nlohmann::json to_json(const Design& design);

}  // namespace lcrig
