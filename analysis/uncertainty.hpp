// SPDX-License-Identifier: Apache-2.0
// The parts that make up the uncertainty of a result (GUM), and how they are combined and expanded.
// The analysis fills it, and reports and the budget show it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "base/enum_words.hpp"

namespace lcrig {

// A: evaluated from the scatter of the readings. B: evaluated from other knowledge or assumptions.
enum class UncertaintyKind { a, b };
template <>
inline constexpr EnumWords<2> kWordsOf<UncertaintyKind>{"A", "B"};

// What an error comes from. Two runs share the errors of a source only if both prove that they used
// the same one (analysis/comparison.hpp). Those of `run` are never shared. A choice is no error: it
// belongs to what the result refers to, and only equal choices are compared.
enum class ErrorSource { run, meter, cell, probe, branch, time };
template <>
inline constexpr EnumWords<6> kWordsOf<ErrorSource>{
    "run", "meter", "load cell", "probe", "choice of branch", "choice of time"};

struct UncertaintyPart {
  std::string name;  // "scatter of the readings", "force class"
  double standard_uncertainty = 0;  // in the unit of the result
  UncertaintyKind kind = UncertaintyKind::b;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  // More readings make it smaller. An error that all readings share does not shrink.
  bool shrinks = false;
  bool alike_in_repeats = false;  // of one run: more repeats do not make it smaller
  ErrorSource source = ErrorSource::run;
  std::string basis;  // "class 1: limits of 1 % of reading, rectangular; assumed"
  bool is_gap = false;  // not known: named, but not in the uncertainty
};

// Confidence of intervals and expanded uncertainties if nobody asks for another one.
inline constexpr double kConfidence = 0.95;

// The results that have an uncertainty.
enum class UncertainResult {
  sensitivity,
  c0,
  delta_C,
  dynamic_range,
  force_sensitivity,
  hysteresis
};

struct Uncertainty {
  UncertainResult result = UncertainResult::sensitivity;
  std::string quantity;  // "sensitivity 0-30 kPa"
  std::string unit;  // "fF/kPa"
  std::string estimand;  // the estimand of the result
  double value = 0;
  std::vector<UncertaintyPart> parts;
  // The members below are filled by combine().
  double combined = 0;  // root of the sum of squares
  double effective_degrees_of_freedom = std::numeric_limits<double>::infinity();
  double coverage_factor = 2;
  double expanded = 0;  // combined times coverage factor, at least `least`
  double least = 0;  // half-width of the interval from the scatter alone
  double confidence = kConfidence;

  const UncertaintyPart* dominating() const;  // null: there are no parts
  std::vector<std::string> gaps() const;  // names of what is not in it
};

// Combines the parts: root sum of squares, Welch and Satterthwaite's degrees of freedom (truncated
// to a whole number, as in GUM G.4.1), and Student's t. The result is never less than the
// half-width from the scatter alone. The parts are not correlated with each other; a correlation
// between readings is already included in each part.
void combine(Uncertainty& uncertainty, double confidence = kConfidence);

// Standard uncertainty of limits +-a between which all values are equally likely (GUM 4.3.7).
double rectangular(double half_width);

}  // namespace lcrig
