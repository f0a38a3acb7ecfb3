// SPDX-License-Identifier: Apache-2.0
#include "budget/loading_path.hpp"

#include <boost/math/tools/toms748_solve.hpp>

namespace lcrig {

double LoadingPath::at(double part) const {
  const auto short_of = [&](double force_N) { return run_.compression_m(force_N) - part * way_m_; };
  if (part >= 1) return peak_kPa_;
  if (short_of(0) >= 0) return 0;
  std::uintmax_t steps = 50;
  const auto force_N = boost::math::tools::toms748_solve(
      short_of, 0.0, peak_N_, boost::math::tools::eps_tolerance<double>(48), steps);
  return force_N.second / run_.area_m2 * 1e-3;
}

}  // namespace lcrig
