// SPDX-License-Identifier: Apache-2.0
// The fit's model at one place of its parameters: residuals, derivatives, and which errors the data
// share. Private to model/fit*.cpp.
#pragma once

#include <Eigen/Dense>

#include "model/fit.hpp"
#include "model/fit_cells.hpp"
#include "model/fit_curve.hpp"
#include "model/fit_scales.hpp"

namespace lcrig {

inline constexpr const char* kNoConvergence =
    "fit: no convergence; the points do not determine modulus and offset together";

// Parameters of the linearized problem are log(mu / mu of the place), offset over the highest
// pressure, and shift over the span. Values are in F.
struct FitPlace {
  double mu_Pa = 0, offset_Pa = 0, shift_F = 0;
  // Share of the pressure by which each element finally yields; the last one is per decade since
  // the load was reached.
  Eigen::VectorXd amplitudes;
  FitCurve curve;
};

class FitPlaces {
 public:
  static Result<FitPlaces> make(const Specimen& specimen, const LevelSettings& settings,
                                const FitData& data);
  const FitCells& cells() const { return cells_; }
  const FitData& data() const { return data_; }
  const Specimen& specimen() const { return specimen_; }
  const LevelSettings& settings() const { return settings_; }
  bool with_c0() const { return data_.c0.standard_error_F > 0; }
  int different_pressures() const;
  double start_mu_Pa() const { return start_mu_Pa_; }

  FitPlace start() const { return start_; }
  // Towards the parameters `target` of a problem that was linearized at `from`.
  Result<FitPlace> stepped(const FitPlace& from, const Eigen::VectorXd& target,
                           double length) const;
  // The curve of a specimen like ours with this modulus.
  Result<FitCurve> curve(const Specimen& specimen, double mu_Pa) const;
  Result<ScaledProblem> problem(const FitPlace& at) const;
  Eigen::VectorXd law(const FitPlace& at) const;  // delta C of each cell without shift
  // Data less the model with its creep, C0's datum last.
  Eigen::VectorXd residuals(const FitPlace& at, const ScaledProblem& problem) const;
  // Of the repeats from their mean, less what the creep of this place makes of their histories.
  Eigen::MatrixXd deviations(const FitPlace& at) const;
  void judge_repeats(const FitPlace& at) { cells_.judge_repeats(deviations(at)); }
  // Covariance that the drift's error gives the data; it is part of `known` of a problem.
  const Eigen::MatrixXd& shared_known() const { return drift_; }

 private:
  FitPlaces(const Specimen& specimen, const LevelSettings& settings, const FitData& data)
      : specimen_(specimen), settings_(settings), data_(data) {}
  Eigen::Index rows() const { return cells_.size() + (with_c0() ? 1 : 0); }
  Eigen::Index elements() const;
  double answered_Pa(const FitPoint& p, const FitPlace& at) const;
  Eigen::MatrixXd creep(const FitPlace& at) const;
  void fill_errors(ScaledProblem& out) const;

  Specimen specimen_;
  LevelSettings settings_;
  FitData data_;
  FitCells cells_;
  std::size_t soft_ = 0;
  double start_mu_Pa_ = 0;
  FitPlace start_;
  Eigen::MatrixXd drift_;
};

// The weighted squares of the residuals at middling scales.
class FitObjective {
 public:
  explicit FitObjective(const ScaledProblem& problem);
  double at(const Eigen::VectorXd& residuals) const { return residuals.dot(llt_.solve(residuals)); }
  bool determines(const Eigen::MatrixXd& slopes) const;
  Eigen::VectorXd solve(const Eigen::MatrixXd& slopes, const Eigen::VectorXd& values) const;

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

}  // namespace lcrig
