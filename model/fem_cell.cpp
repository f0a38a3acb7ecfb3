// SPDX-License-Identifier: Apache-2.0
#include "model/fem_cell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lcrig {
namespace {

constexpr int kPoints = 9;
// For 1/lambda below this times 1/mu the condensation would lose its digits; the smaller true value
// is reached by iterating (FemSystem), which needs one or two more solves.
constexpr double kLeastInverseLambda = 1e-7;

// Shape functions of the reference square at the 3 x 3 Gauss points.
struct Reference {
  double n[kPoints][kCellNodes], dx[kPoints][kCellNodes], dy[kPoints][kCellNodes];
  double x[kPoints], y[kPoints], weight[kPoints];
};

Reference make_reference() {
  Reference ref{};
  const double g = std::sqrt(0.6);
  const double points[3] = {-g, 0, g};
  const double weights[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  const auto shape = [](double x, int a) {
    return a == 0 ? x * (x - 1) / 2 : a == 1 ? 1 - x * x : x * (x + 1) / 2;
  };
  const auto slope = [](double x, int a) { return a == 0 ? x - 0.5 : a == 1 ? -2 * x : x + 0.5; };
  for (int q = 0; q < kPoints; ++q) {
    const double x = points[q % 3], y = points[q / 3];
    ref.x[q] = x;
    ref.y[q] = y;
    ref.weight[q] = weights[q % 3] * weights[q / 3];
    for (int a = 0; a < kCellNodes; ++a) {
      ref.n[q][a] = shape(x, a % 3) * shape(y, a / 3);
      ref.dx[q][a] = slope(x, a % 3) * shape(y, a / 3);
      ref.dy[q][a] = shape(x, a % 3) * slope(y, a / 3);
    }
  }
  return ref;
}
const Reference kRef = make_reference();

// Gradients of the shape functions at one integration point, and the displacement gradient H.
struct Point {
  double w;  // weight, m3
  double gr[kCellNodes], gz[kCellNodes], gt[kCellNodes];  // d/dR, d/dZ, 1/R
  double rr = 0, rz = 0, tt = 0, zr = 0, zz = 0;  // H
};

Point make_point(const CellGeometry& c, int q, const std::array<double, kCellDofs>& u) {
  Point p;
  const double hr = c.r1 - c.r0, hz = c.z1 - c.z0;
  const double radius = (c.r0 + c.r1) / 2 + kRef.x[q] * hr / 2;
  p.w = kRef.weight[q] * hr * hz / 4 * 2 * std::numbers::pi * radius;
  for (int a = 0; a < kCellNodes; ++a) {
    p.gr[a] = kRef.dx[q][a] * 2 / hr;
    p.gz[a] = kRef.dy[q][a] * 2 / hz;
    p.gt[a] = kRef.n[q][a] / radius;
    const double ur = u[static_cast<std::size_t>(2 * a)];
    const double uz = u[static_cast<std::size_t>(2 * a + 1)];
    p.rr += p.gr[a] * ur;
    p.rz += p.gz[a] * ur;
    p.tt += p.gt[a] * ur;
    p.zr += p.gr[a] * uz;
    p.zz += p.gz[a] * uz;
  }
  return p;
}

// F^-T (in-plane block and hoop), ln J and F - F^-T, all without cancellation at small strain.
struct Strain {
  double g[2][2] = {{1, 0}, {0, 1}};
  double gt = 1;
  double log_j = 0, j = 1;
  double d[2][2], dt;  // F - F^-T; linear: H + H^T
  bool valid = true;
};

Strain strain_linear(const Point& p) {
  Strain s;
  s.log_j = p.rr + p.tt + p.zz;
  s.d[0][0] = 2 * p.rr;
  s.d[0][1] = s.d[1][0] = p.rz + p.zr;
  s.d[1][1] = 2 * p.zz;
  s.dt = 2 * p.tt;
  return s;
}

Strain strain_finite(const Point& p) {
  Strain s;
  const double plane = p.rr + p.zz + (p.rr * p.zz - p.rz * p.zr);  // in-plane J - 1
  if (!(plane > -1) || !(p.tt > -1)) {
    s.valid = false;
    return s;
  }
  const double j = 1 + plane;
  s.log_j = std::log1p(plane) + std::log1p(p.tt);
  s.j = j * (1 + p.tt);
  s.g[0][0] = (1 + p.zz) / j;
  s.g[0][1] = -p.zr / j;
  s.g[1][0] = -p.rz / j;
  s.g[1][1] = (1 + p.rr) / j;
  s.gt = 1 / (1 + p.tt);
  // F - F^-T = F^-T (F^T F - 1), and F^T F - 1 = H + H^T + H^T H
  const double e00 = 2 * p.rr + p.rr * p.rr + p.zr * p.zr;
  const double e01 = p.rz + p.zr + p.rr * p.rz + p.zr * p.zz;
  const double e11 = 2 * p.zz + p.rz * p.rz + p.zz * p.zz;
  s.d[0][0] = s.g[0][0] * e00 + s.g[0][1] * e01;
  s.d[0][1] = s.g[0][0] * e01 + s.g[0][1] * e11;
  s.d[1][0] = s.g[1][0] * e00 + s.g[1][1] * e01;
  s.d[1][1] = s.g[1][0] * e01 + s.g[1][1] * e11;
  s.dt = s.gt * p.tt * (2 + p.tt);
  return s;
}

using Small = std::array<std::array<double, kCellPressures>, kCellPressures>;
using Coupling = std::array<std::array<double, kCellPressures>, kCellDofs>;

void add_forces(const Point& pt, const Strain& s, double mu, double pressure, CellResult& out) {
  double stress[2][2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) stress[i][j] = pt.w * (mu * s.d[i][j] + pressure * s.g[i][j]);
  }
  const double hoop = pt.w * (mu * s.dt + pressure * s.gt);
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const double gr = pt.gr[a], gz = pt.gz[a], gt = pt.gt[a];
    out.force[2 * a] += stress[0][0] * gr + stress[0][1] * gz + hoop * gt;
    out.force[2 * a + 1] += stress[1][0] * gr + stress[1][1] * gz;
  }
}

// d ln J / du times the pressure basis.
void add_coupling(const Point& pt, const Strain& s, const double basis[3], Coupling& coupling) {
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const double gr = pt.gr[a], gz = pt.gz[a], gt = pt.gt[a];
    const double yr = pt.w * (s.g[0][0] * gr + s.g[0][1] * gz + s.gt * gt);
    const double yz = pt.w * (s.g[1][0] * gr + s.g[1][1] * gz);
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      coupling[2 * a][k] += yr * basis[k];
      coupling[2 * a + 1][k] += yz * basis[k];
    }
  }
}

// Tangent of one point: with y_a = F^-T grad N_a and c = mu - p,
//   K_ab = mu (grad N_a . grad N_b) 1 + c y_b y_a^T, plus the hoop part.
void add_tangent(const Point& pt, const Strain& s, double mu, double pressure, CellResult& out) {
  double yr[kCellNodes], yz[kCellNodes];
  for (int a = 0; a < kCellNodes; ++a) {
    yr[a] = s.g[0][0] * pt.gr[a] + s.g[0][1] * pt.gz[a];
    yz[a] = s.g[1][0] * pt.gr[a] + s.g[1][1] * pt.gz[a];
  }
  const double m = pt.w * mu;
  const double c = pt.w * (mu - pressure);
  const double hoop = m + c * s.gt * s.gt;
  for (int a = 0; a < kCellNodes; ++a) {
    auto& row_r = out.stiffness[static_cast<std::size_t>(2 * a)];
    auto& row_z = out.stiffness[static_cast<std::size_t>(2 * a + 1)];
    const double mr = m * pt.gr[a], mz = m * pt.gz[a], ht = hoop * pt.gt[a];
    const double cr = c * yr[a], cz = c * yz[a];
    for (int b = 0; b <= a; ++b) {
      const auto col = static_cast<std::size_t>(2 * b);
      const double same = mr * pt.gr[b] + mz * pt.gz[b];
      row_r[col] += same + cr * yr[b] + ht * pt.gt[b];
      row_r[col + 1] += cz * yr[b];
      row_z[col] += cr * yz[b];
      row_z[col + 1] += same + cz * yz[b];
    }
  }
}

// Inverse of a symmetric positive 3 x 3 matrix.
Small inverse(const Small& m) {
  const double c00 = m[1][1] * m[2][2] - m[1][2] * m[1][2];
  const double c01 = m[0][2] * m[1][2] - m[0][1] * m[2][2];
  const double c02 = m[0][1] * m[1][2] - m[0][2] * m[1][1];
  const double c11 = m[0][0] * m[2][2] - m[0][2] * m[0][2];
  const double c12 = m[0][1] * m[0][2] - m[0][0] * m[1][2];
  const double c22 = m[0][0] * m[1][1] - m[0][1] * m[0][1];
  const double det = m[0][0] * c00 + m[0][1] * c01 + m[0][2] * c02;
  return {{{c00 / det, c01 / det, c02 / det},
           {c01 / det, c11 / det, c12 / det},
           {c02 / det, c12 / det, c22 / det}}};
}

double dot(const double a[3], const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// mu/2 (I1 - 3 - 2 ln J), or its linearization mu eps:eps, at one point.
double shear_energy(Kinematics kinematics, const Point& p, const Strain& s, double mu) {
  if (kinematics == Kinematics::linear) {
    return mu / 4 *
           (s.d[0][0] * s.d[0][0] + s.d[1][1] * s.d[1][1] + s.dt * s.dt +
            2 * s.d[0][1] * s.d[0][1]);
  }
  const double trace = 2 * (p.rr + p.tt + p.zz) + p.rr * p.rr + p.rz * p.rz + p.tt * p.tt +
                       p.zr * p.zr + p.zz * p.zz;  // I1 - 3
  return mu / 2 * (trace - 2 * s.log_j);
}

// All integration points of a cell, and the integrals that decide the pressure.
struct Points {
  Point at[kPoints];
  Strain strain[kPoints];
  double basis[kPoints][kCellPressures];
  Small mass{};
  std::array<double, kCellPressures> volume{};  // of ln J
  double volume_scale = 0;
};

bool make_points(Kinematics kinematics, const CellGeometry& cell,
                 const std::array<double, kCellDofs>& u, Points& points) {
  for (int q = 0; q < kPoints; ++q) {
    Point& pt = points.at[q] = make_point(cell, q, u);
    const Strain& s = points.strain[q] =
        kinematics == Kinematics::linear ? strain_linear(pt) : strain_finite(pt);
    if (!s.valid) return false;
    double* basis = points.basis[q];
    basis[0] = 1;
    basis[1] = kRef.x[q];
    basis[2] = kRef.y[q];
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      points.volume[k] += pt.w * basis[k] * s.log_j;
      for (std::size_t l = 0; l < kCellPressures; ++l) {
        points.mass[k][l] += pt.w * basis[k] * basis[l];
      }
    }
    points.volume_scale += pt.w * std::abs(s.log_j);
  }
  return true;
}

// What the volume equations lack at p; returns the energy of the pressure terms.
double add_volume(const Points& points, double inverse_lambda,
                  const std::array<double, kCellPressures>& p, CellResult& out) {
  double energy = 0;
  out.lack_scale = points.volume_scale;
  for (std::size_t k = 0; k < kCellPressures; ++k) {
    const double stored = inverse_lambda * dot(points.mass[k].data(), p);
    out.lack[k] = points.volume[k] - stored;
    out.lack_scale += std::abs(stored);
    energy += p[k] * (points.volume[k] - stored / 2);
  }
  return energy;
}

Small gain_of(const Small& mass, const ElasticLaw& law) {
  Small scaled = mass;
  for (auto& row : scaled) {
    for (double& value : row) value *= std::max(law.inverse_lambda, kLeastInverseLambda / law.mu);
  }
  return inverse(scaled);
}

// Eliminates the pressure increment from forces and stiffness.
void condense(bool tangent, CellResult& out) {
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    double bg[kCellPressures];
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      bg[k] = dot(out.coupling[i].data(), out.gain[k]);
    }
    out.condensed_force[i] = out.force[i] + dot(bg, out.lack);
    for (std::size_t j = 0; tangent && j <= i; ++j) {
      out.stiffness[i][j] += dot(bg, out.coupling[j]);
      out.stiffness[j][i] = out.stiffness[i][j];
    }
  }
}

}  // namespace

bool evaluate_cell(Kinematics kinematics, const CellGeometry& cell, const ElasticLaw& law,
                   const std::array<double, kCellDofs>& u,
                   const std::array<double, kCellPressures>& p, bool tangent, CellResult& out) {
  Points points;
  if (!make_points(kinematics, cell, u, points)) return false;
  out.energy = add_volume(points, law.inverse_lambda, p, out);
  out.gain = gain_of(points.mass, law);
  out.force.fill(0);
  out.coupling = {};
  out.min_j = 1;
  if (tangent) out.stiffness = {};
  for (int q = 0; q < kPoints; ++q) {
    const Point& pt = points.at[q];
    const Strain& s = points.strain[q];
    const double pressure = dot(points.basis[q], p);
    add_forces(pt, s, law.mu, pressure, out);
    add_coupling(pt, s, points.basis[q], out.coupling);
    out.energy += pt.w * shear_energy(kinematics, pt, s, law.mu);
    out.min_j = std::min(out.min_j, s.j);
    if (tangent) {  // linear elasticity is the tangent at rest: F = 1 and no pressure
      add_tangent(pt, s, law.mu, kinematics == Kinematics::linear ? 0 : pressure, out);
    }
  }
  condense(tangent, out);
  return true;
}

}  // namespace lcrig
