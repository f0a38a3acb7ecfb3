// SPDX-License-Identifier: Apache-2.0
#include "analysis/uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/line_fit.hpp"

namespace lcrig {

namespace {
constexpr double kWholeAgain = 1 + 1e-12;  // keeps 3 that is rounded to 2.999... at 3
}  // namespace

const UncertaintyPart* Uncertainty::dominating() const {
  const auto larger = [](const UncertaintyPart& a, const UncertaintyPart& b) {
    return a.standard_uncertainty < b.standard_uncertainty;
  };
  const auto it = std::max_element(parts.begin(), parts.end(), larger);
  return it == parts.end() ? nullptr : &*it;
}

std::vector<std::string> Uncertainty::gaps() const {
  std::vector<std::string> out;
  for (const UncertaintyPart& p : parts) {
    if (p.is_gap) out.push_back(p.name);
  }
  return out;
}

void combine(Uncertainty& uncertainty, double confidence) {
  double variance = 0;
  double denominator = 0;  // of Welch and Satterthwaite (GUM G.4.1)
  for (const UncertaintyPart& part : uncertainty.parts) {
    const double u2 = part.standard_uncertainty * part.standard_uncertainty;
    variance += u2;
    if (std::isfinite(part.degrees_of_freedom)) denominator += u2 * u2 / part.degrees_of_freedom;
  }
  uncertainty.combined = std::sqrt(variance);
  uncertainty.effective_degrees_of_freedom =
      denominator > 0 ? std::max(1.0, std::floor(variance * variance / denominator * kWholeAgain))
                      : std::numeric_limits<double>::infinity();
  uncertainty.confidence = confidence;
  uncertainty.coverage_factor =
      coverage_factor(confidence, uncertainty.effective_degrees_of_freedom);
  uncertainty.expanded =
      std::max(uncertainty.least, uncertainty.coverage_factor * uncertainty.combined);
}

double rectangular(double half_width) {
  return std::abs(half_width) / std::sqrt(3.0);
}

}  // namespace lcrig
