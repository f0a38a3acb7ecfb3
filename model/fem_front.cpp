// SPDX-License-Identifier: Apache-2.0
#include "model/fem_front.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/fem_vector.hpp"

namespace lcrig {
namespace {

constexpr std::size_t kTileColumns = 4;
constexpr std::size_t kPanel = 16;  // columns that are multiplied with earlier ones together

struct Columns {
  double* data;
  std::size_t stride;
};

// c -= a b^T for one tile of c. `a` holds its rows and `b` its columns.
void wide_tile(Columns c, Columns a, Columns b, std::size_t depth) {
  Four s00{}, s01{}, s02{}, s03{}, s10{}, s11{}, s12{}, s13{};
  for (std::size_t k = 0; k < depth; ++k) {
    const double* factor = b.data + k * b.stride;
    const Four upper = four(a.data + k * a.stride), lower = four(a.data + k * a.stride + 4);
    s00 += upper * factor[0];
    s10 += lower * factor[0];
    s01 += upper * factor[1];
    s11 += lower * factor[1];
    s02 += upper * factor[2];
    s12 += lower * factor[2];
    s03 += upper * factor[3];
    s13 += lower * factor[3];
  }
  four(c.data) -= s00;
  four(c.data + 4) -= s10;
  four(c.data + c.stride) -= s01;
  four(c.data + c.stride + 4) -= s11;
  four(c.data + 2 * c.stride) -= s02;
  four(c.data + 2 * c.stride + 4) -= s12;
  four(c.data + 3 * c.stride) -= s03;
  four(c.data + 3 * c.stride + 4) -= s13;
}

void narrow_tile(Columns c, Columns a, Columns b, std::size_t depth) {
  Four upper{}, lower{};
  for (std::size_t k = 0; k < depth; ++k) {
    const double factor = b.data[k * b.stride];
    upper += four(a.data + k * a.stride) * factor;
    lower += four(a.data + k * a.stride + 4) * factor;
  }
  four(c.data) -= upper;
  four(c.data + 4) -= lower;
}

// Columns first to end of c -= a b^T, on and below the diagonal, down to row `size`.
void subtract_product(Columns c, Columns a, Columns b, std::size_t first, std::size_t end,
                      std::size_t size, std::size_t depth) {
  const auto at = [](Columns m, std::size_t row, std::size_t column) {
    return Columns{m.data + column * m.stride + row, m.stride};
  };
  for (std::size_t j = first; j < end;) {
    const bool wide = j + kTileColumns <= end;
    for (std::size_t i = j / kTileRows * kTileRows; i < size; i += kTileRows) {
      if (wide) {
        wide_tile(at(c, i, j), at(a, i, 0), at(b, j, 0), depth);
      } else {
        narrow_tile(at(c, i, j), at(a, i, 0), at(b, j, 0), depth);
      }
    }
    j += wide ? kTileColumns : 1;
  }
}

// `scaled` becomes L D.
double eliminate_in(const FrontMatrix& m, double* scratch) {
  const Columns l{m.first, m.padded()}, scaled{scratch, m.padded()};
  const auto from = [](Columns c, std::size_t row, std::size_t column) {
    return Columns{c.data + column * c.stride + row, c.stride};
  };
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < m.eliminated; first += kPanel) {
    const std::size_t end = std::min(first + kPanel, m.eliminated);
    subtract_product(l, l, scaled, first, end, m.size, first);
    for (std::size_t k = first; k < end; ++k) {
      subtract_product(l, from(l, 0, first), from(scaled, 0, first), k, k + 1, m.size, k - first);
      double* column = l.data + k * l.stride;
      const double pivot = column[k];
      least = std::min(least, pivot);
      if (pivot == 0 || std::isnan(pivot)) return std::numeric_limits<double>::quiet_NaN();
      const double inverse = 1 / pivot;
      for (std::size_t i = k / kTileRows * kTileRows; i < m.padded(); i += 4) {
        four(scaled.data + k * scaled.stride + i) = four(column + i);
        four(column + i) *= inverse;
      }
      column[k] = pivot;
    }
  }
  const std::size_t rest = m.size - m.eliminated;
  subtract_product({m.rest, m.padded_rest()}, from(l, m.eliminated, 0),
                   from(scaled, m.eliminated, 0), 0, rest, rest, m.eliminated);
  return least;
}

// The first row below the diagonal from which on columns are processed in groups of four.
std::size_t first_four(std::size_t diagonal) {
  return (diagonal + 4) / 4 * 4;
}

void forward_one(const FrontMatrix& m, std::size_t j, double* x) {
  const double* column = m.column(j);
  const double value = x[j];
  const std::size_t begin = first_four(j);
  for (std::size_t i = j + 1; i < begin; ++i) x[i] -= column[i] * value;
  for (std::size_t i = begin; i < m.padded(); i += 4) four(x + i) -= four(column + i) * value;
}

// Processes four columns at once, of which the first is a multiple of four. x is then read and
// written only once for all of them.
void forward_four(const FrontMatrix& m, std::size_t j, double* x) {
  const double *a = m.column(j), *b = m.column(j + 1), *c = m.column(j + 2), *d = m.column(j + 3);
  x[j + 1] -= a[j + 1] * x[j];
  x[j + 2] -= a[j + 2] * x[j] + b[j + 2] * x[j + 1];
  x[j + 3] -= a[j + 3] * x[j] + b[j + 3] * x[j + 1] + c[j + 3] * x[j + 2];
  for (std::size_t i = j + 4; i < m.padded(); i += 4) {
    four(x + i) -= four(a + i) * x[j] + four(b + i) * x[j + 1] + four(c + i) * x[j + 2] +
                   four(d + i) * x[j + 3];
  }
}

int forward_in(const FrontMatrix& m, double* x) {
  std::size_t j = 0;
  for (; j + 4 <= m.eliminated; j += 4) forward_four(m, j, x);
  for (; j < m.eliminated; ++j) forward_one(m, j, x);
  return 0;
}

double total(const Four& sums) {
  return sums[0] + sums[1] + sums[2] + sums[3];
}

void backward_one(const FrontMatrix& m, std::size_t j, double* x) {
  const double* column = m.column(j);
  const std::size_t begin = first_four(j);
  double sum = 0;
  for (std::size_t i = j + 1; i < begin; ++i) sum += column[i] * x[i];
  Four sums{};
  for (std::size_t i = begin; i < m.padded(); i += 4) sums += four(column + i) * four(x + i);
  x[j] = x[j] / column[j] - (sum + total(sums));
}

void backward_four(const FrontMatrix& m, std::size_t j, double* x) {
  const double *a = m.column(j), *b = m.column(j + 1), *c = m.column(j + 2), *d = m.column(j + 3);
  Four of_a{}, of_b{}, of_c{}, of_d{};
  for (std::size_t i = j + 4; i < m.padded(); i += 4) {
    const Four at = four(x + i);
    of_a += four(a + i) * at;
    of_b += four(b + i) * at;
    of_c += four(c + i) * at;
    of_d += four(d + i) * at;
  }
  x[j + 3] = x[j + 3] / d[j + 3] - total(of_d);
  x[j + 2] = x[j + 2] / c[j + 2] - (total(of_c) + c[j + 3] * x[j + 3]);
  x[j + 1] = x[j + 1] / b[j + 1] - (total(of_b) + b[j + 2] * x[j + 2] + b[j + 3] * x[j + 3]);
  x[j] =
      x[j] / a[j] - (total(of_a) + a[j + 1] * x[j + 1] + a[j + 2] * x[j + 2] + a[j + 3] * x[j + 3]);
}

int backward_in(const FrontMatrix& m, double* x) {
  std::size_t j = m.eliminated;
  for (; j % 4 != 0; --j) backward_one(m, j - 1, x);
  for (; j > 0; j -= 4) backward_four(m, j - 4, x);
  return 0;
}

}  // namespace

std::optional<double> eliminate(const FrontMatrix& matrix, double* scratch) {
  const double least = run_fast<eliminate_in>(matrix, scratch);
  return std::isnan(least) ? std::nullopt : std::optional(least);
}

void solve_forward(const FrontMatrix& matrix, double* x) {
  run_fast<forward_in>(matrix, x);
}

void solve_backward(const FrontMatrix& matrix, double* x) {
  run_fast<backward_in>(matrix, x);
}

}  // namespace lcrig
