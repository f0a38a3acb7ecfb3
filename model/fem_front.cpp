// SPDX-License-Identifier: Apache-2.0
#include "model/fem_front.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcrig {
namespace {

constexpr std::size_t kTileColumns = 4;
constexpr std::size_t kPanel = 16;  // columns whose products with earlier ones are taken at once

// Half of a tile's rows. The compiler splits it where the processor has shorter registers.
using Rows [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;

struct Columns {
  double* data;
  std::size_t stride;
};

[[gnu::always_inline]] inline Rows& rows(double* at) {
  return *reinterpret_cast<Rows*>(at);
}

// c -= a b^T for one tile of c; a has its rows and b its columns.
[[gnu::always_inline]] inline void wide_tile(Columns c, Columns a, Columns b, std::size_t depth) {
  Rows s00{}, s01{}, s02{}, s03{}, s10{}, s11{}, s12{}, s13{};
  for (std::size_t k = 0; k < depth; ++k) {
    const double* factor = b.data + k * b.stride;
    const Rows upper = rows(a.data + k * a.stride), lower = rows(a.data + k * a.stride + 4);
    s00 += upper * factor[0];
    s10 += lower * factor[0];
    s01 += upper * factor[1];
    s11 += lower * factor[1];
    s02 += upper * factor[2];
    s12 += lower * factor[2];
    s03 += upper * factor[3];
    s13 += lower * factor[3];
  }
  rows(c.data) -= s00;
  rows(c.data + 4) -= s10;
  rows(c.data + c.stride) -= s01;
  rows(c.data + c.stride + 4) -= s11;
  rows(c.data + 2 * c.stride) -= s02;
  rows(c.data + 2 * c.stride + 4) -= s12;
  rows(c.data + 3 * c.stride) -= s03;
  rows(c.data + 3 * c.stride + 4) -= s13;
}

[[gnu::always_inline]] inline void narrow_tile(Columns c, Columns a, Columns b, std::size_t depth) {
  Rows upper{}, lower{};
  for (std::size_t k = 0; k < depth; ++k) {
    const double factor = b.data[k * b.stride];
    upper += rows(a.data + k * a.stride) * factor;
    lower += rows(a.data + k * a.stride + 4) * factor;
  }
  rows(c.data) -= upper;
  rows(c.data + 4) -= lower;
}

// The columns first to end of c -= a b^T, on and below the diagonal, down to row `size`.
[[gnu::always_inline]] inline void subtract_product(Columns c, Columns a, Columns b,
                                                    std::size_t first, std::size_t end,
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
[[gnu::always_inline]] inline double eliminate_in(const FrontMatrix& m, double* scratch) {
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
        rows(scaled.data + k * scaled.stride + i) = rows(column + i);
        rows(column + i) *= inverse;
      }
      column[k] = pivot;
    }
  }
  const std::size_t rest = m.size - m.eliminated;
  subtract_product({m.rest, m.padded_rest()}, from(l, m.eliminated, 0),
                   from(scaled, m.eliminated, 0), 0, rest, rest, m.eliminated);
  return least;
}

#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] double eliminate_avx2(const FrontMatrix& matrix, double* scratch) {
  return eliminate_in(matrix, scratch);
}
#endif

double eliminate_plain(const FrontMatrix& matrix, double* scratch) {
  return eliminate_in(matrix, scratch);
}

}  // namespace

std::optional<double> eliminate(const FrontMatrix& matrix, double* scratch) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const double least = avx2 ? eliminate_avx2(matrix, scratch) : eliminate_plain(matrix, scratch);
#else
  const double least = eliminate_plain(matrix, scratch);
#endif
  return std::isnan(least) ? std::nullopt : std::optional(least);
}

}  // namespace lcrig
