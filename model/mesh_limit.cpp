// SPDX-License-Identifier: Apache-2.0
#include "model/mesh_limit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lcrig {
namespace {

// The order that every corner allows: displacement goes like r^(1/2) at worst, a functional
// converges twice as fast, and at a corner with the mildest grading cells shrink with the square of
// their number. Coarse meshes may show a higher order by chance, so the doubt does not count on it.
constexpr double kMostOrder = 2;
// The order that the grading gives to the worst corner, see `model/fem_mesh.cpp`. A step that falls
// faster than this is small by chance.
constexpr double kDesignOrder = 3;
constexpr double kLeastOrder = 1;  // the family promises to halve the error at each step
constexpr double kRounding = 1e-15;

}  // namespace

MeshLimit limit_of(const std::vector<double>& values) {
  std::vector<double> steps;
  for (std::size_t i = values.size() > 4 ? values.size() - 4 : 0; i + 1 < values.size(); ++i) {
    steps.push_back(values[i + 1] - values[i]);
  }
  MeshLimit limit;
  limit.value = values.back();
  const double rounding = 8 * kRounding * std::abs(values.back());
  const double last = steps.back();
  const double before = steps[steps.size() - 2];
  limit.doubt = std::max(std::max(std::abs(last), std::abs(before)), rounding);
  if (limit.doubt <= rounding) {
    limit.settled = true;
    return limit;
  }
  const double step = std::max(std::abs(last), std::abs(before) * std::exp2(-kDesignOrder));
  if (last * before <= 0) {  // the values alternate, so the limit lies between the last two
    limit.settled = std::abs(last) <= std::abs(before) / 2;
    limit.doubt = limit.settled ? std::max(step, rounding) : limit.doubt;
    return limit;
  }
  // A single ratio scatters, so the mean over three steps is taken.
  const double first = steps.front() * last > 0 ? steps.front() : before;
  const double count = steps.front() * last > 0 ? static_cast<double>(steps.size() - 1) : 1;
  const double order = std::log2(first / last) / count;
  limit.order = order;
  const bool still = std::log2(before / last) >= kLeastOrder / 2;
  limit.settled = still && order >= kLeastOrder;
  if (!limit.settled) return limit;
  limit.value += last / (std::exp2(order) - 1);
  limit.doubt = std::max(step / (std::exp2(std::min(order, kMostOrder)) - 1), rounding);
  return limit;
}

}  // namespace lcrig
