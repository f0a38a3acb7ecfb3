// SPDX-License-Identifier: Apache-2.0
// What a specimen file comes to, for a person who wrote it: a mistake in it shows here.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "model/specimen.hpp"

namespace lcrig {

struct SpecimenFigures {
  double c0_F = 0;
  double thickness_m = 0, soft_thickness_m = 0;  // of all layers; of those that strain
  double disc_diameter_m = 0, area_m2 = 0;  // of the disc, which the force is over
  // At small loads, by the cheapest level that applies; absent: rigid, or only finite elements
  // know.
  std::optional<double> stiffness_N_m;
  std::size_t capacitors = 0, layers = 0;
  Top top = Top::pressure;
};
SpecimenFigures figures_of(const Specimen& specimen);

std::string to_text(const SpecimenFigures& figures);
nlohmann::json to_json(const SpecimenFigures& figures);

}  // namespace lcrig
