// SPDX-License-Identifier: Apache-2.0
// Property: a model can work with every accepted specimen.
#include <cmath>

#include "model/specimen_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace lcrig::fuzz {

namespace {

void require_positive(double value, const char* what) {
  require(std::isfinite(value) && value > 0, std::string(what) + " is not a positive number");
}

void require_sound(const Specimen& s) {
  require(check_text("name", s.name, kNameMax).has_value() && !s.name.empty(), "a bad name");
  require_positive(s.disc_diameter_m, "disc_diameter");
  require_positive(s.area_m2(), "area");
  require(!s.capacitors.empty(), "no capacitor");
  for (const Capacitor& capacitor : s.capacitors) {
    require(!capacitor.layers.empty(), "no layer");
    for (const Layer& layer : capacitor.layers) {
      require_positive(layer.thickness_m, "thickness");
      const Material& m = s.materials.at(layer.material);
      require_positive(m.relative_permittivity, "permittivity");
      if (!m.rigid) require_positive(m.youngs_modulus_Pa, "modulus");
    }
  }
}

}  // namespace

void read_specimen(std::string_view input) {
  const auto specimen = parse_specimen(input, "fuzz.json");
  if (!specimen) return require_good_message(specimen.error());
  require_sound(*specimen);
}

}  // namespace lcrig::fuzz
