// SPDX-License-Identifier: Apache-2.0
#include "model/fem_space.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

constexpr double kOnLine = 1e-6;  // heights this close to a node line, in cells, are on it

}  // namespace

Height StackSpace::height(double z) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (z >= row.z0 && z <= row.z1) {
      const double zeta = (2 * z - row.z0 - row.z1) / (row.z1 - row.z0);
      const bool on_line = std::abs(zeta) > 1 - kOnLine;
      return {static_cast<int>(i), on_line ? std::copysign(1.0, zeta) : zeta};
    }
  }
  return {};
}

Result<std::vector<StackSpace::Capacitor>> StackSpace::partition(
    const std::vector<double>& thickness_m) const {
  if (rows_.empty()) return fail(Errc::invalid_request, "nothing here can be pressed");
  if (!one_field_) {
    return fail(Errc::invalid_request,
                "only one block without films in it can be cut anew over the same field");
  }
  const Slab& like = capacitors_.front().front();
  for (const auto& capacitor : capacitors_) {
    for (const Slab& slab : capacitor) {
      if (slab.rigid || slab.relative_permittivity != like.relative_permittivity) {
        return fail(Errc::invalid_request, "only a block of one soft material can be cut anew");
      }
    }
  }
  double z = 0;
  std::vector<Capacitor> result;
  for (const double t : thickness_m) {
    if (!(t > 0)) {
      return fail(Errc::invalid_request, "partition: thickness {} m must be positive", t);
    }
    const double inside = 1e-9 * t;
    const double top = z + t;
    result.push_back({{t, like.relative_permittivity, false, height(z + inside),
                       height(std::min(top - inside, rows_.back().z1))}});
    z = top;
  }
  if (std::abs(z - rows_.back().z1) > 1e-9 * z) {
    return fail(Errc::invalid_request, "partition: layers add up to {} mm, the block has {} mm",
                z * 1e3, rows_.back().z1 * 1e3);
  }
  return result;
}

std::vector<double> StackSpace::displacement(const std::vector<double>& u, Height h,
                                             int component) const {
  const Row& row = rows_[static_cast<std::size_t>(h.row)];
  const auto weight = lagrange(degree_, h.zeta).value;
  std::vector<double> values(r_.size(), 0.0);
  for (std::size_t i = 0; i < r_.size(); ++i) {
    for (std::size_t k = 0; k <= static_cast<std::size_t>(degree_); ++k) {
      const int eq = equation(row.line[k], static_cast<int>(i), component);
      values[i] += eq >= 0 ? weight[k] * u[static_cast<std::size_t>(eq)] : 0;
    }
  }
  return values;
}

double StackSpace::top_area_ratio(const std::vector<double>& u) const {
  const int rim = static_cast<int>(r_.size()) - 1;
  const int eq = top_line_ >= 0 ? equation(top_line_, rim, 0) : -1;
  const double stretch = eq >= 0 ? 1 + u[static_cast<std::size_t>(eq)] / radius_m() : 1;
  return stretch * stretch;
}

double StackSpace::shortening_m(const std::vector<double>& u) const {
  double work = 0;  // work of a unit pressure: area times mean displacement
  for (std::size_t i = 0; i < unit_load_.size(); ++i) work += unit_load_[i] * u[i];
  return work / area_m2_;
}

}  // namespace lcrig
