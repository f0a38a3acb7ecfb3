// SPDX-License-Identifier: Apache-2.0
#include "model/mesh_limit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lcrig {
namespace {

constexpr double kRounding = 1e-15;

constexpr double kHighestOrder = 16;
constexpr int kBisections = 40;

// Error that remains after the last step, relative to this step, at this order.
double missing(double order, double halvings) {
  return 1 / (std::exp2(order * halvings) - 1);
}

struct MeshStep {
  double change, halvings;
};

// The order at which two steps have the observed ratio. `between`: halvings from the end of the
// first to the end of the last.
double order_of(const MeshStep& first, const MeshStep& last, double between) {
  const double ratio = first.change / last.change;
  double low = 0, high = kHighestOrder;
  for (int i = 0; i < kBisections; ++i) {
    const double order = (low + high) / 2;
    const double found =
        std::exp2(order * between) * missing(order, last.halvings) / missing(order, first.halvings);
    (found < ratio ? low : high) = order;
  }
  return low;
}

}  // namespace

MeshLimit limit_of(const std::vector<double>& values, const MeshSequence& meshes) {
  std::vector<MeshStep> steps;
  for (std::size_t i = values.size() > 4 ? values.size() - 4 : 0; i + 1 < values.size(); ++i) {
    steps.push_back({values[i + 1] - values[i], meshes.halvings[i]});
  }
  MeshLimit limit;
  limit.value = values.back();
  const double rounding = 8 * kRounding * std::abs(values.back());
  const MeshStep last = steps.back(), before = steps[steps.size() - 2];
  limit.doubt = std::max(std::max(std::abs(last.change), std::abs(before.change)), rounding);
  if (limit.doubt <= rounding) {
    limit.settled = true;
    return limit;
  }
  const double design = meshes.orders.most;
  const double at_design = std::abs(before.change) * std::exp2(-design * last.halvings) *
                           missing(design, before.halvings) / missing(design, last.halvings);
  const double step = std::max(std::abs(last.change), at_design);
  if (last.change * before.change <= 0) {  // they alternate: the limit is between the last two
    limit.settled = std::abs(last.change) <= std::abs(before.change) / 2;
    limit.doubt = limit.settled ? std::max(step, rounding) : limit.doubt;
    return limit;
  }
  const double of_two = order_of(before, last, last.halvings);
  limit.order = of_two;
  if (steps.size() > 2 && steps.front().change * last.change > 0) {
    // a single ratio scatters, so all steps are used
    limit.order = order_of(steps.front(), last, before.halvings + last.halvings);
  }
  limit.settled = of_two >= kLeastOrder / 2 && limit.order >= kLeastOrder;
  if (!limit.settled) return limit;
  limit.value += last.change * missing(limit.order, last.halvings);
  const double sure = std::min(limit.order, meshes.orders.least);
  limit.doubt = std::max(step * missing(sure, last.halvings), rounding);
  return limit;
}

}  // namespace lcrig
