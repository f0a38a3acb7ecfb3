// SPDX-License-Identifier: Apache-2.0
// Fits shear modulus, contact offset and C0 to a recorded run, and tests whether the law can
// describe it. `lcrig model fit` prints it; docs/model.md, "Fit", explains the numbers.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/quantity.hpp"
#include "model/level.hpp"

namespace lcrig {

// The mean of some readings.
struct FitPoint {
  FitPoint() = default;
  FitPoint(double pressure, double delta_capacitance, double error = 0, std::int32_t of_repeat = 0)
      : pressure_Pa(pressure),
        delta_capacitance_F(delta_capacitance),
        standard_error_F(error),
        repeat(of_repeat) {}
  double pressure_Pa = 0;  // force over the area of the disc; 0: at rest after a load
  double delta_capacitance_F = 0;
  double standard_error_F = 0;  // of the noise of its readings; 0 for all points: not known
  std::int32_t repeat = 0;  // the points of one repeat may share errors
  // Points of several repeats with the same cell were taken at the same place of their repeats. 0
  // for all points: the first points of all repeats are alike, and so on.
  std::int32_t cell = 0;
  double time_s = 0;  // since C0 was measured
  // Pressure that each element of FitData::creep_times_s remembers, Pa. Empty: not known.
  std::vector<double> memory_Pa;
  double held_decades = 0;  // log10(1 + time since this load was reached over 1 s)
  double gap_F = 0;  // unloading branch less loading branch; 0: no hysteresis is known
};

struct C0Error {
  C0Error() = default;
  explicit C0Error(double error, double freedom = std::numeric_limits<double>::infinity())
      : standard_error_F(error), degrees_of_freedom(freedom) {}
  double standard_error_F = 0;  // 0: C0 is not fitted
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

struct FitData {
  FitData() = default;
  explicit FitData(std::vector<FitPoint> all, const C0Error& error = {})
      : points(std::move(all)), c0(error) {}
  std::vector<FitPoint> points;
  C0Error c0;  // of the C0 that was subtracted for delta C; all points share it
  // Time constants of elements that creep (FitPoint::memory_Pa), s.
  std::vector<double> creep_times_s;
  // Drift that was subtracted, in proportion to time_s: its standard error, and the rate at which
  // the same procedure takes the memory of each element for a drift.
  double drift_error_F_s = 0;
  std::vector<double> memory_drift_Pa_s;
  double measured_c0_F = 0;  // 0: not known
  double c0_tolerance = 0;  // relative; a larger difference to the model's C0 is a finding
};

struct FitValue {
  double value = 0;
  double standard_error = 0;
  double ci95_low = 0, ci95_high = 0;
  // How far the value moves when the model's delta C has a relative error of 1 everywhere.
  // Multiplied by the estimated error of the level it gives the model's part of the uncertainty.
  double per_model_error = 0;
};

// Where the half-width of the modulus comes from, as standard errors relative to it. The last two
// are shifts: the interval includes the values that hold if what the file says is wrong by as much
// as C0 shows, and if the specimen is half way between its branches.
struct FitParts {
  double repeats = 0;  // scatter between repeats; with one repeat, noise of its readings
  double c0 = 0, drift = 0, creep = 0, misfit = 0;
  double geometry = 0, hysteresis = 0;
};

enum class FitPatternKind { creep, hysteresis, size, faces, law };
template <>
inline constexpr EnumWords<5> kWordsOf<FitPatternKind>{"creep", "hysteresis", "size", "faces",
                                                       "law"};

// One way in which the data depart from the law.
struct FitPattern {
  FitPatternKind kind;
  double size_percent = 0;  // creep: of the load; hysteresis, law: of the span; size: of C0
  std::string text;
};

// A datum against the law alone: without creep and without an allowance for misfit.
struct FitPull {
  double pressure_Pa = 0, time_s = 0;
  double residual_F = 0;
  double pull = 0;  // residual in its known standard deviations
};

struct FitMisfit {
  double chi2 = 0, degrees_of_freedom = 0, p = 1;  // of the law alone, known scatter
  double law_F = 0;  // root mean square of what the law leaves after creep
  std::vector<FitPattern> patterns;  // empty: the law describes the data
  std::vector<FitPull> pulls;  // of the means over the repeats, in the order of a repeat
  double c0_pull = 0;  // of C0's datum; 0 when it is not fitted
  bool found() const { return !patterns.empty() || p < 0.01; }
};

struct Fit {
  // Of the soft layers, for a load that has just been applied; nu stays as given. What yields
  // faster than FitData::creep_times_s counts as elastic.
  FitValue shear_modulus_Pa;
  // Zero of the cell, plus the pressure that is needed before the faces touch everywhere. A fit
  // cannot separate the two.
  FitValue contact_offset_Pa;
  // true C0 less the C0 that was subtracted for delta C; 0 when it is not fitted
  FitValue c0_shift_F;
  FitParts parts;
  FitMisfit misfit;
  double residual_F = 0;  // root mean square of the points about the law with creep
  double correlation = 0;  // of modulus and offset
  int points = 0, iterations = 0;
  int repeats = 0;  // repeats behind the standard errors; 0: residuals are behind them
};

// Fits delta C(P) = model(P + memory - offset; mu) + shift. The specimen must have exactly one soft
// material: not rigid, and not a hundred times stiffer than another. The shift is fitted if C0 has
// an error. Standard errors come from the repeats as a sample (with one repeat from the noise of
// the points), plus those of C0, drift, creep and misfit, which all repeats share. Errors: levels
// at fewer than three pressures; several soft materials; no convergence; a level that has no answer
// near the data; a misfit so large that the modulus means nothing.
Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const FitData& data);

// 97.5 % quantile of Student's t. Less than one degree of freedom counts as one.
double student_t975(double degrees_of_freedom);

}  // namespace lcrig
