// SPDX-License-Identifier: Apache-2.0
#include "model/plausible.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace lcrig {

namespace {

// A range with what its ends come from. docs/specimen-file.md, "Plausible values", has the same
// table.
struct Plausible {
  double least, most;  // in the unit that is printed
  const char* unit;
  const char* source;
};

// Polyacrylamide gels for cell culture: Tse and Engler, Curr. Protoc. Cell Biol. 47 (2010) 10.16,
// table 10.16.1. Diamond: E of 1050 to 1210 GPa.
constexpr Plausible kUsualYoungs{
    0.2, 1.2e9, "kPa", "from the softest gels for cell culture (0.2 kPa) to diamond (1.2 TPa)"};
// The same materials, by G = E/(2(1 + nu)) with nu of 0.5 and 0.
constexpr Plausible kUsualShear{0.2 / 3, 0.6e9, "kPa",
                                "from a third of the softest gel's modulus to half of diamond's"};
// Vacuum; ceramics of class 2 (IEC 60384-1), of which the highest in catalogues have 20 000.
constexpr Plausible kUsualPermittivity{1, 2e4, "", "from vacuum to ceramics of barium titanate"};
// Thinnest free film of PDMS: Thangawng et al., Biomed. Microdevices 9 (2007) 587, 70 nm.
constexpr double kThinnest_um = 0.07;
// Test pieces for compression are at most half as thick as wide: ISO 844, 50 mm of 100 mm; ISO
// 7743, 12.5 mm of 29 mm. The field of a thicker layer is not that of plates.
constexpr double kThicknessOfWidth = 0.5;
// Half of the gap that a fingertip resolves: Johnson and Phillips, J. Neurophysiol. 46 (1981) 1177,
// 0.87 mm. Largest test piece for compression: ISO 844, 100 mm.
constexpr Plausible kUsualDisc{
    0.4, 100, "mm",
    "from half of what a fingertip resolves (0.87 mm) to the largest test "
    "piece of ISO 844"};
// Coarsest grade of roughness, N12: Ra of 50 um (ISO 1302).
constexpr Plausible kUsualContactGap{0, 50, "um", "up to the coarsest roughness of ISO 1302 (N12)"};

class Questions {
 public:
  void ask(const std::string& place, double value, const Plausible& range) {
    if (value >= range.least * (1 - kRounding) && value <= range.most * (1 + kRounding)) return;
    out_.push_back(fmt::format("{} of {:.6g}{}{}, plausible is {:.3g} to {:.6g}{}{} ({})", place,
                               value, space(range), range.unit, range.least, range.most,
                               space(range), range.unit, range.source));
  }
  std::vector<std::string> take() { return std::move(out_); }

 private:
  static constexpr double kRounding = 1e-9;  // of a conversion between units
  static const char* space(const Plausible& range) { return *range.unit == '\0' ? "" : " "; }
  std::vector<std::string> out_;
};

void ask_material(const Material& m, Questions& q) {
  const std::string name = "material " + m.name + ": ";
  q.ask(name + "relative permittivity", m.relative_permittivity, kUsualPermittivity);
  if (m.rigid) return;
  q.ask(name + "Young's modulus", m.youngs_modulus_Pa * 1e-3, kUsualYoungs);
  if (m.given_shear_modulus_Pa) {
    q.ask(name + "shear modulus", *m.given_shear_modulus_Pa * 1e-3, kUsualShear);
  }
}

// Layers that are alike are asked for once.
void ask_layers(const Specimen& s, Questions& q) {
  const double most_um = kThicknessOfWidth * s.disc_diameter_m * 1e6;
  const Plausible thickness{kThinnest_um, most_um, "um",
                            "from the thinnest film of PDMS to half of the disc's diameter, as in "
                            "ISO 844"};
  std::set<std::pair<std::size_t, double>> asked;
  for (std::size_t c = 0; c < s.capacitors.size(); ++c) {
    const auto& layers = s.capacitors[c].layers;
    for (std::size_t i = 0; i < layers.size(); ++i) {
      if (!asked.emplace(layers[i].material, layers[i].thickness_m).second) continue;
      q.ask(fmt::format("capacitor {}, layer {}: thickness", c + 1, i + 1),
            layers[i].thickness_m * 1e6, thickness);
    }
  }
}

}  // namespace

std::vector<std::string> implausible_values(const Specimen& specimen) {
  Questions q;
  q.ask("disc diameter", specimen.disc_diameter_m * 1e3, kUsualDisc);
  for (const Material& m : specimen.materials) ask_material(m, q);
  ask_layers(specimen, q);
  if (specimen.contact_gap) {
    q.ask("contact gap: height", specimen.contact_gap->height_m * 1e6, kUsualContactGap);
  }
  return q.take();
}

}  // namespace lcrig
