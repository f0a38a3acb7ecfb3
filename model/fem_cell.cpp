// SPDX-License-Identifier: Apache-2.0
#include "model/fem_cell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/fem_vector.hpp"

namespace lcrig {
namespace {

constexpr int kPoints = 9;
// One value for each node, in groups of four; the last three are zero.
constexpr std::size_t kPaddedNodes = 12;
using Nodes = std::array<double, kPaddedNodes>;

// Shape functions of the reference square at the 3 x 3 Gauss points.
struct Reference {
  Nodes n[kPoints], dx[kPoints], dy[kPoints];
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
      const auto at = static_cast<std::size_t>(a);
      ref.n[q][at] = shape(x, a % 3) * shape(y, a / 3);
      ref.dx[q][at] = slope(x, a % 3) * shape(y, a / 3);
      ref.dy[q][at] = shape(x, a % 3) * slope(y, a / 3);
    }
  }
  return ref;
}
const Reference kRef = make_reference();

// Radial and axial values for each node.
struct Pair {
  Nodes r{}, z{};
};

// Gradients of the shape functions at one integration point, and the displacement gradient H.
struct Point {
  double w;  // weight, m3
  Nodes gr, gz, gt;  // d/dR, d/dZ, 1/R
  double rr, rz, tt, zr, zz;  // H
};

double sum(const Four& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

Point make_point(const CellGeometry& c, int q, const Pair& u) {
  Point p;
  const double hr = c.r1 - c.r0, hz = c.z1 - c.z0;
  const double radius = (c.r0 + c.r1) / 2 + kRef.x[q] * hr / 2;
  p.w = kRef.weight[q] * hr * hz / 4 * 2 * std::numbers::pi * radius;
  const double to_r = 2 / hr, to_z = 2 / hz, to_t = 1 / radius;
  Four rr{}, rz{}, tt{}, zr{}, zz{};
  for (std::size_t a = 0; a < kPaddedNodes; a += 4) {
    const Four gr = four(&kRef.dx[q][a]) * to_r, gz = four(&kRef.dy[q][a]) * to_z;
    const Four gt = four(&kRef.n[q][a]) * to_t;
    const Four ur = four(&u.r[a]), uz = four(&u.z[a]);
    four(&p.gr[a]) = gr;
    four(&p.gz[a]) = gz;
    four(&p.gt[a]) = gt;
    rr += gr * ur;
    rz += gz * ur;
    tt += gt * ur;
    zr += gr * uz;
    zz += gz * uz;
  }
  p.rr = sum(rr);
  p.rz = sum(rz);
  p.tt = sum(tt);
  p.zr = sum(zr);
  p.zz = sum(zz);
  return p;
}

// F^-T (in-plane block and hoop), ln J and F - F^-T, all without cancellation at small strain.
struct Strain {
  double g[2][2] = {{1, 0}, {0, 1}};
  double gt = 1;
  double log_j = 0, j = 1;
  double d[2][2], dt;  // F - F^-T
  bool valid = true;
};

Strain strain_of(const Point& p) {
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
using Coupling = std::array<Pair, kCellPressures>;

void add_forces(const Point& pt, const Strain& s, double mu, double pressure, Pair& force) {
  double stress[2][2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) stress[i][j] = pt.w * (mu * s.d[i][j] + pressure * s.g[i][j]);
  }
  const double hoop = pt.w * (mu * s.dt + pressure * s.gt);
  for (std::size_t a = 0; a < kPaddedNodes; a += 4) {
    const Four gr = four(&pt.gr[a]), gz = four(&pt.gz[a]);
    four(&force.r[a]) += stress[0][0] * gr + stress[0][1] * gz + hoop * four(&pt.gt[a]);
    four(&force.z[a]) += stress[1][0] * gr + stress[1][1] * gz;
  }
}

// y_a = F^-T grad N_a
Pair pulled_back(const Point& pt, const Strain& s) {
  Pair y;
  for (std::size_t a = 0; a < kPaddedNodes; a += 4) {
    const Four gr = four(&pt.gr[a]), gz = four(&pt.gz[a]);
    four(&y.r[a]) = s.g[0][0] * gr + s.g[0][1] * gz;
    four(&y.z[a]) = s.g[1][0] * gr + s.g[1][1] * gz;
  }
  return y;
}

// d ln J / du times the pressure basis.
void add_coupling(const Point& pt, const Strain& s, const Pair& y, const double basis[3],
                  Coupling& coupling) {
  for (std::size_t k = 0; k < kCellPressures; ++k) {
    const double weight = pt.w * basis[k];
    for (std::size_t a = 0; a < kPaddedNodes; a += 4) {
      four(&coupling[k].r[a]) += weight * (four(&y.r[a]) + s.gt * four(&pt.gt[a]));
      four(&coupling[k].z[a]) += weight * four(&y.z[a]);
    }
  }
}

// Rows and columns by component, then node. Only the columns up to a row's own node are valid.
struct Tangent {
  Nodes rr[kCellNodes]{}, rz[kCellNodes]{}, zr[kCellNodes]{}, zz[kCellNodes]{};
};

// Tangent of one point: with c = mu - p,
//   K_ab = mu (grad N_a . grad N_b) 1 + c y_b y_a^T, plus the hoop part.
void add_tangent(const Point& pt, const Strain& s, const Pair& y, double mu, double pressure,
                 Tangent& tangent) {
  const double m = pt.w * mu;
  const double c = pt.w * (mu - pressure);
  const double hoop = m + c * s.gt * s.gt;
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const double mr = m * pt.gr[a], mz = m * pt.gz[a], ht = hoop * pt.gt[a];
    const double cr = c * y.r[a], cz = c * y.z[a];
    for (std::size_t b = 0; b <= a; b += 4) {
      const Four same = mr * four(&pt.gr[b]) + mz * four(&pt.gz[b]);
      const Four yr = four(&y.r[b]), yz = four(&y.z[b]);
      four(&tangent.rr[a][b]) += same + cr * yr + ht * four(&pt.gt[b]);
      four(&tangent.rz[a][b]) += cz * yr;
      four(&tangent.zr[a][b]) += cr * yz;
      four(&tangent.zz[a][b]) += same + cz * yz;
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

// mu/2 (I1 - 3 - 2 ln J) at one point.
double shear_energy(const Point& p, const Strain& s, double mu) {
  const double trace = 2 * (p.rr + p.tt + p.zz) + p.rr * p.rr + p.rz * p.rz + p.tt * p.tt +
                       p.zr * p.zr + p.zz * p.zz;  // I1 - 3
  return mu / 2 * (trace - 2 * s.log_j);
}

// All integration points of a cell, and the integrals that determine the pressure.
struct Points {
  Point at[kPoints];
  Strain strain[kPoints];
  double basis[kPoints][kCellPressures];
  Small mass{};
  std::array<double, kCellPressures> volume{};  // of ln J
  double volume_scale = 0;
};

bool make_points(const CellGeometry& cell, const Pair& u, Points& points) {
  for (int q = 0; q < kPoints; ++q) {
    Point& pt = points.at[q] = make_point(cell, q, u);
    const Strain& s = points.strain[q] = strain_of(pt);
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

// Residual of the volume equations at p; returns the energy of the pressure terms.
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

void write_forces(const Pair& force, const Coupling& coupling, CellResult& out) {
  std::array<double, kCellPressures> missing{};  // pressure that corresponds to the missing volume
  for (std::size_t k = 0; k < kCellPressures; ++k) missing[k] = dot(out.gain[k].data(), out.lack);
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      out.coupling[2 * a][k] = coupling[k].r[a];
      out.coupling[2 * a + 1][k] = coupling[k].z[a];
    }
    out.force[2 * a] = force.r[a];
    out.force[2 * a + 1] = force.z[a];
  }
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    out.condensed_force[i] = out.force[i] + dot(missing.data(), out.coupling[i]);
  }
}

struct CellTask {
  const CellGeometry& cell;
  const ElasticLaw& law;
  const std::array<double, kCellDofs>& u;
  const std::array<double, kCellPressures>& p;
};

// Eliminates the pressure increment from the tangent.
void condense(const Coupling& coupling, const Small& gain, Tangent& tangent) {
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      double r = 0, z = 0;
      for (std::size_t l = 0; l < kCellPressures; ++l) {
        r += gain[k][l] * coupling[l].r[a];
        z += gain[k][l] * coupling[l].z[a];
      }
      for (std::size_t b = 0; b <= a; b += 4) {
        const Four cr = four(&coupling[k].r[b]), cz = four(&coupling[k].z[b]);
        four(&tangent.rr[a][b]) += r * cr;
        four(&tangent.rz[a][b]) += r * cz;
        four(&tangent.zr[a][b]) += z * cr;
        four(&tangent.zz[a][b]) += z * cz;
      }
    }
  }
}

void write_tangent(const Tangent& tangent, CellResult& out) {
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      out.stiffness[2 * a][2 * b] = out.stiffness[2 * b][2 * a] = tangent.rr[a][b];
      out.stiffness[2 * a + 1][2 * b] = out.stiffness[2 * b][2 * a + 1] = tangent.zr[a][b];
      out.stiffness[2 * a + 1][2 * b + 1] = out.stiffness[2 * b + 1][2 * a + 1] = tangent.zz[a][b];
      if (a != b) {
        out.stiffness[2 * a][2 * b + 1] = out.stiffness[2 * b + 1][2 * a] = tangent.rz[a][b];
      }
    }
  }
}

Tangent tangent_of(const Points& points, const CellTask& task, const Coupling& coupling,
                   const Small& gain) {
  Tangent tangent;
  for (int q = 0; q < kPoints; ++q) {
    const Point& pt = points.at[q];
    const Strain& s = points.strain[q];
    const double pressure = dot(points.basis[q], task.p);
    add_tangent(pt, s, pulled_back(pt, s), task.law.mu, pressure, tangent);
  }
  condense(coupling, gain, tangent);
  return tangent;
}

bool evaluate(const CellTask* task, CellResult* result) {
  const auto& [cell, law, u, p] = *task;
  CellResult& out = *result;
  Pair by_node;
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    by_node.r[a] = u[2 * a];
    by_node.z[a] = u[2 * a + 1];
  }
  Points points;
  if (!make_points(cell, by_node, points)) return false;
  out.energy = add_volume(points, law.inverse_lambda, p, out);
  out.gain = gain_of(points.mass, law);
  out.min_j = 1;
  Pair force;
  Coupling coupling{};
  for (int q = 0; q < kPoints; ++q) {
    const Point& pt = points.at[q];
    const Strain& s = points.strain[q];
    const double pressure = dot(points.basis[q], p);
    const Pair y = pulled_back(pt, s);
    add_forces(pt, s, law.mu, pressure, force);
    add_coupling(pt, s, y, points.basis[q], coupling);
    out.energy += pt.w * shear_energy(pt, s, law.mu);
    out.min_j = std::min(out.min_j, s.j);
  }
  write_forces(force, coupling, out);
  write_tangent(tangent_of(points, *task, coupling, out.gain), out);
  return true;
}

}  // namespace

bool evaluate_cell(const CellGeometry& cell, const ElasticLaw& law,
                   const std::array<double, kCellDofs>& u,
                   const std::array<double, kCellPressures>& p, CellResult& out) {
  const CellTask task{cell, law, u, p};
  return run_fast<evaluate>(&task, &out);
}

}  // namespace lcrig
