// SPDX-License-Identifier: Apache-2.0
#include "model/fem_capacitance.hpp"

#include <numbers>

#include "model/gauss.hpp"

namespace lcrig {
namespace {

// Value and slope (per unit of xi) of a polynomial through the nodes of a cell.
struct Polynomial {
  double value = 0, slope = 0;
};
Polynomial polynomial(const double* nodes, int degree, const Lagrange& shape) {
  Polynomial result;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(degree); ++i) {
    result.value += nodes[i] * shape.value[i];
    result.slope += nodes[i] * shape.slope[i];
  }
  return result;
}

// For one capacitor, by radial node, in m: closing of the dielectric (sum of thickness loss over
// eps_r) and radial displacement of the upper electrode.
struct Profile {
  double gap_m = 0;
  std::vector<double> closing, radial;
};

Profile profile_of(const StackSpace& space, const StackSpace::Capacitor& slabs,
                   const std::vector<double>& u, double scale) {
  Profile profile;
  profile.closing.assign(space.radii().size(), 0);
  profile.radial.assign(space.radii().size(), 0);
  for (const auto& slab : slabs) {
    profile.gap_m += slab.thickness_m / slab.relative_permittivity;
    if (slab.rigid) continue;
    const auto low = space.displacement(u, slab.bottom, 1);
    const auto high = space.displacement(u, slab.top, 1);
    for (std::size_t i = 0; i < low.size(); ++i) {
      profile.closing[i] += scale * (low[i] - high[i]) / slab.relative_permittivity;
    }
  }
  if (!slabs.back().rigid) {
    profile.radial = space.displacement(u, slabs.back().top, 0);
    for (double& value : profile.radial) value *= scale;
  }
  return profile;
}

Result<double> change_of(const StackSpace& space, const Profile& profile, ElectrodeArea area) {
  const auto& r = space.radii();
  double sum = 0;  // of (r dr/gap - R dR/gap0), m
  const int degree = space.degree();
  const auto nodes = static_cast<std::size_t>(degree);
  for (std::size_t i = 0; i + nodes < r.size(); i += nodes) {
    for (const auto& [x, weight] : kGauss5) {
      const Lagrange shape = lagrange(degree, x);
      const auto R = polynomial(&r[i], degree, shape);
      const double closing = polynomial(&profile.closing[i], degree, shape).value;
      double stretch = 0;  // r dr - R dR
      if (area == ElectrodeArea::deformed) {
        const auto ur = polynomial(&profile.radial[i], degree, shape);
        stretch = ur.value * R.slope + R.value * ur.slope + ur.value * ur.slope;
      }
      const double gap = profile.gap_m - closing;
      if (!(gap > 0)) {
        return fail(Errc::invalid_request, "a layer has closed at radius {:.4g} mm", R.value * 1e3);
      }
      sum +=
          weight * (stretch * profile.gap_m + R.value * R.slope * closing) / (gap * profile.gap_m);
    }
  }
  return kVacuumPermittivity_F_m * 2 * std::numbers::pi * sum;
}

}  // namespace

Result<std::vector<double>> capacitance_changes(
    const StackSpace& space, const std::vector<StackSpace::Capacitor>& capacitors,
    const std::vector<double>& u, double scale, ElectrodeArea area) {
  std::vector<double> changes;
  for (const auto& slabs : capacitors) {
    auto change = change_of(space, profile_of(space, slabs, u, scale), area);
    if (!change) return fail(change.error());
    changes.push_back(*change);
  }
  return changes;
}

}  // namespace lcrig
