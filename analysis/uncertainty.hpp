// SPDX-License-Identifier: Apache-2.0
// The parts that the uncertainty of a result is made of (GUM), combined and expanded. The analysis
// fills it, reports and the budget show it.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace lcrig {

// A: from the scatter of the readings. B: from what is known or assumed otherwise.
enum class UncertaintyKind { a, b };

struct UncertaintyPart {
  std::string name;  // "scatter of the readings", "force class"
  double standard_uncertainty = 0;  // in the unit of the result
  UncertaintyKind kind = UncertaintyKind::b;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  // More readings make it smaller. What all readings share does not shrink.
  bool shrinks = false;
  // Common to all runs on this rig: cancels in a ratio of two runs.
  bool shared_by_runs = false;
  std::string basis;  // "class 1: limits of 1 % of reading, rectangular; assumed"
};

// Of an interval and of an expanded uncertainty, where nobody asks for another one.
inline constexpr double kConfidence = 0.95;

// The results whose uncertainty the meter's digit adds to, beside the sensitivities.
enum class UncertainResult { other, c0, delta_C, dynamic_range };

struct Uncertainty {
  UncertainResult result = UncertainResult::other;
  std::string quantity;  // "sensitivity 0-30 kPa"
  std::string unit;  // "fF/kPa"
  std::string estimand;  // that of the result
  double value = 0;
  std::vector<UncertaintyPart> parts;
  // Filled by combine().
  double combined = 0;  // root of the sum of squares
  double effective_degrees_of_freedom = std::numeric_limits<double>::infinity();
  double coverage_factor = 2;
  double expanded = 0;  // combined times coverage factor; not below `least`
  double least = 0;  // half-width of the interval of scatter alone
  double confidence = kConfidence;

  const UncertaintyPart* dominating() const;  // null: no parts
};

// Root sum of squares, Welch and Satterthwaite's degrees of freedom (truncated to a whole number,
// as GUM G.4.1 has it), Student's t; never less than the half-width of the scatter alone. The parts
// are not correlated with each other; what is common to the readings is already inside each part.
void combine(Uncertainty& uncertainty, double confidence = kConfidence);

// Standard uncertainty of limits +-a, all values between them alike (GUM 4.3.7).
double rectangular(double half_width);

}  // namespace lcrig
