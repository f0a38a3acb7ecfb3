// SPDX-License-Identifier: Apache-2.0
#include "model/compare.hpp"

namespace lcrig {

const std::vector<std::string_view>& paper_errata() {
  static const std::vector<std::string_view> kErrata{
      "Eq. 1-4: F = -A dP and F = k dt with dt < 0 make F positive in tension although it is "
      "called "
      "the applied force; compressive: dP = F/A, F = -k dt. \"Electric permeability\" is "
      "permittivity.",
      "Eq. 14: C0 = gamma A/(t_tot x (1-x)); 1/t_tot is missing.",
      "Eq. 16: x_i > x_min must be >=, else the maximum is not attained; eq. 17: \"min\" is x_min.",
      "Eq. 19, 20: x_1 = ... = x_{N-1} = x_min (x_{N-2} in 20); the dots are missing, and the "
      "appendix uses x for absolute thickness.",
      "Eq. 21: x_N = Delta - (N-1) t_min; one sign is wrong.",
      "Table I: E = 200 kPa and nu = 0.49 give mu = 67.1 kPa; mu = 42 kPa belongs to E = 125 kPa. "
      "The linear and the neo-Hookean results are for different materials; nu of the neo-Hookean "
      "one is not stated as lambda or K.",
      "Table I has no data for kapton although C0 needs them.",
      "Fig. 5b: t1..t6 = 100 um contradicts t_tot = 1 mm (166.7 um).",
      "C0 uses 25 um of PDMS, made is about 24 um (3.690 pF). With the second film's print facing "
      "the PDMS the dielectric would be PDMS alone (12.2 to 12.7 pF).",
      "\"2N right electrodes and 2N-1 left electrodes\": N capacitors have N and N plates, or N+1 "
      "shared ones.",
      "\"235 %\" is 235.7; the FEM columns give 89.9, 47.9 and 180.9.",
      "\"Validated the entire mathematical demonstration\": the FEM gives +7 % where the model "
      "says "
      "+96 %, and +130 % where it says +65 %.",
      "Dynamic range is defined as max/min but measured as dC/C0, which the model says does not "
      "depend on N.",
      "\"14 loads, 10 to 100 kPa\": equal steps are 6.92 kPa; the regions 0-30 and 35-100 leave a "
      "gap. The probe's diameter is not given.",
      "The linear model is used up to 50 % strain; it is singular at P = E = 200 kPa.",
      "The parallel plate ignores the fringe: +3.6 % of C0 at 100 um (dielectric between the "
      "plates "
      "only), +9.7 % (same dielectric outside).",
      "Equal pressure and equal strain of all layers hold only with frictionless faces."};
  return kErrata;
}

}  // namespace lcrig
