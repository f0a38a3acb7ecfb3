// SPDX-License-Identifier: Apache-2.0
// The steps of an analysis, in the order in which they build on each other; private to analysis/.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"
#include "analysis/correlation.hpp"
#include "analysis/drift.hpp"
#include "analysis/line_fit.hpp"
#include "analysis/online.hpp"

namespace lcrig {

// Facts that several metrics need.
struct Scene {
  Scene(const RunData& d, const AnalysisOptions& o) : data(d), options(o) {}

  const RunData& data;
  const AnalysisOptions& options;
  // Readings under other settings of the meter are another experiment.
  MeterSetting setting;
  bool setting_known = false;
  std::vector<double> changes_s;  // since when ...
  std::vector<bool> change_is_used;  // ... readings are (not) under `setting`; empty: all are
  double rest_N = 0;  // what the cell shows while nothing touches
  double peak_N = 0;  // largest force above rest; 0: there is no loading
  double force_noise_N = 0;  // of one sample
  // Of neighbouring readings: of the levels (each may creep), and without a load. A run without
  // levels: both the second.
  Correlation correlation, rest_correlation;
  Drift drift;  // of the unloaded capacitance

  bool uses(const RunReading& r) const;
  double above_rest_N(const RunReading& r) const { return r.force_N - rest_N; }
  bool is_unloaded(const RunReading& r) const;
  // Nothing touches: the reading and both its neighbours are unloaded, so that the edges of a
  // contact, where the force is within its noise already, do not count.
  bool rests(std::size_t reading) const;
  // Without the drift of the unloaded capacitance; the baseline is left as it is.
  double fF(const RunReading& r) const { return r.capacitance_F * 1e15 - drift.at(r.t_s); }
  std::optional<double> kPa(double force_N) const;
};
Scene look_at(const RunData& data, const AnalysisOptions& options, RunAnalysis& out);

Metric metric(std::string name, std::string definition);
Metric missing(std::string name, std::string definition, std::string reason);
// Student's t interval about a value.
Estimate estimate(double value, double standard_error, double degrees_of_freedom,
                  double confidence);

// Root sum of squares of the parts; Welch and Satterthwaite's degrees of freedom, truncated.
Estimate estimate_of_parts(double value, const std::vector<SlopePart>& parts, double confidence);
void add_remark(std::string& reason, std::string_view more);  // after a semicolon

void find_cycles(Scene& scene, RunAnalysis& out);  // without the metrics that need C0
void find_drift(Scene& scene, RunAnalysis& out);  // rests, correlation; needs the cycles
void calc_holds(const Scene& scene, RunAnalysis& out);
// Levels and outliers, without C0; the drift is subtracted, and decides here what of it is.
void calc_levels(Scene& scene, RunAnalysis& out);
void calc_baseline(const Scene& scene, RunAnalysis& out);
void calc_curve(const Scene& scene, RunAnalysis& out);  // delta C, linearity, repeatability
void calc_cycles(const Scene& scene, RunAnalysis& out);  // dynamic range, Mullins, pF/N
void calc_sensitivity(const Scene& scene, RunAnalysis& out);
RangeResult slope_in(const Scene& scene, const RunAnalysis& out, const PressureRange& range);
void calc_hysteresis(const Scene& scene, RunAnalysis& out);
void calc_limit_of_detection(const Scene& scene, RunAnalysis& out);
void calc_uncertainties(const Scene& scene, RunAnalysis& out);

// "loading branch, from 1.1 to 4.6 s after the load was reached"
std::string name_estimand(const Scene& scene, const RunAnalysis& out, const PressureRange& range);
// What the other branch and another time would give instead, as systematic parts.
void add_other_choices(const Scene& scene, const RunAnalysis& out, const RangeResult& r,
                       Uncertainty& b);

// Readings of a branch: of a cycle, with a force, under the settings, not in a hold. Call with
// growing numbers.
class Moving {
 public:
  Moving(const Scene& scene, const RunAnalysis& out) : scene_(scene), holds_(out.holds) {}
  bool operator()(std::size_t reading);

 private:
  const Scene& scene_;
  const std::vector<HoldResult>& holds_;
  std::size_t next_ = 0;
};

// The force turned while the meter measured: its mean over the window lies below that in the middle
// by up to a quarter of rate times window, and the reading belongs to neither branch.
bool spans_turn(const CycleResult& c, const RunReading& r);

// The levels that a straight line goes through: of one direction, the one with more levels.
Direction direction_of_line(const RunAnalysis& out);
// Levels of different repeats with the same key are the same point of the curve.
struct LevelKey {
  Direction direction = Direction::up;
  std::int64_t what = 0;  // target pressure, else index within the repeat
  auto operator<=>(const LevelKey&) const = default;
};
LevelKey key_of(const LevelResult& level);
// "0-30 kPa"
std::string range_text(const PressureRange& range);

}  // namespace lcrig
