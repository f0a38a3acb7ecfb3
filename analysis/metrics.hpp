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
#include "base/online.hpp"

namespace lcrig {

// The run before anything is computed from it: which readings count, and where the force rests.
struct RunView {
  RunView(const RunData& d, const AnalysisOptions& o) : data(d), options(o) {}

  const RunData& data;
  const AnalysisOptions& options;
  // Readings under other settings of the meter are another experiment.
  MeterSetting setting;
  bool setting_known = false;
  std::size_t different_settings = 1;
  std::vector<double> changes_s;  // since when ...
  std::vector<bool> change_is_used;  // ... readings are (not) under `setting`; empty: all are
  std::int64_t flagged = 0;  // readings that are not trusted
  double rest_N = 0;  // what the cell shows while nothing touches
  double peak_N = 0;  // largest force above rest; 0: there is no loading
  double force_noise_N = 0;  // of one sample
  // Readings before it are the baseline. nullopt: the run tells no contact.
  std::optional<double> touch_s;

  bool uses(const RunReading& r) const;
  double above_rest_N(const RunReading& r) const { return r.force_N - rest_N; }
  bool is_unloaded(const RunReading& r) const;
  // Nothing touches: the reading and both its neighbours are unloaded, so that the edges of a
  // contact, where the force is within its noise already, do not count.
  bool is_at_rest(std::size_t reading) const;
  std::optional<double> kPa(double force_N) const;
};
RunView look_at(const RunData& data, const AnalysisOptions& options);

std::vector<Loading> find_loadings(const RunView& view);

// The loadings and the stretches between them.
struct Rests {
  std::vector<RestedLoading> loadings;
  // Correlation of neighbouring readings: within the levels (each may creep), and without a load.
  // In a run without levels both are the second.
  Correlation correlation, rest_correlation;
  Drift drift;  // of the unloaded capacitance
  std::vector<Outlier> outliers_of_rests;  // left out of the drift
};
// How many standard deviations off a reading is an outlier: a run without any would show one in a
// hundred runs.
double limit_of_outliers(std::size_t readings);
Outlier outlier_of(const RunReading& r, double middle_F, double sigma_F);
Rests find_rests(const RunView& view, const std::vector<Loading>& loadings);

struct MeasuredLevels {
  std::vector<MeasuredLevel> levels;
  Direction line_direction = Direction::up;
  std::int64_t without_force = 0;
  Outliers outliers;  // of rests and of loadings without levels, too
};
MeasuredLevels measure_levels(const RunView& view, const Rests& rests);

// A sine in the readings that no specimen makes: the meter's beat with the mains (hum.cpp).
// Looks in the stretches in which the load rests: the baseline, the levels, the later halves of
// rests. Of each only what differs from its mean counts, and of levels and rests only what is
// neither alike in all of them nor proportional to the capacitance of the level, so that creep and
// recovery are no sine. nullopt: there is none, or the run is too short or too long to tell.
std::optional<Hum> find_hum(const RunView& view, const Rests& rests,
                            const MeasuredLevels& measured);

// The run with the sine subtracted from every reading.
RunData without(const Hum& hum, const RunData& data);

std::string note_on(const Hum& hum);

// The run without the drift of the unloaded capacitance: what every result under load starts from.
struct Scene : RunView, Rests {
  // The levels decide what part of the rests' deviations from a line is subtracted: a capacitance
  // that steps when the specimen is touched anew moves the rests, too, but what lies between them
  // does not follow, and subtracting it would only add scatter.
  Scene(const RunView& view, const Rests& rests, const MeasuredLevels& measured);
  double fF(const RunReading& r) const { return r.capacitance_F * 1e15 - drift.at(r.t_s); }
};

HoldResults calc_holds(const Scene& scene);
BaselineResult calc_baseline(const Scene& scene, const MeasuredLevels& measured);
LevelResults calc_levels(const Scene& scene, const MeasuredLevels& measured, const Metric& c0);
CurveResult calc_curve(const LevelResults& levels, const Metric& c0, double confidence);
HighestLevelResult calc_highest_level(const Scene& scene, const LevelResults& levels,
                                      const CurveResult& curve, const Metric& c0);
CycleResults calc_cycles(const Scene& scene, const HoldResults& holds, const Metric& c0);
// Delta C at equal peak force, or force at equal peak travel since contact.
void calc_mullins(const Scene& scene, CycleResults& cycles);
void leave_out_other_loadings(const Scene& scene, CycleResults& cycles);
// Travel at which the first loading touched. nullopt: no travel, or it began under load.
std::optional<double> contact_mm(const Scene& scene);
// Slope of C against force at the peak, of one loading at least.
double slope_at_peak_fF_per_N(const Scene& scene, const std::vector<CycleResult>& cycles);
Hysteresis calc_hysteresis(const Scene& scene, const CycleResults& cycles,
                           const HoldResults& holds);

// Input of a slope against pressure and of its uncertainty.
struct SlopeBasis {
  const Scene& scene;
  const HoldResults& holds;
  const BaselineResult& baseline;
  const LevelResults& levels;
  const CurveResult& curve;
  const HighestLevelResult& highest;
  const CycleResults& cycles;
  const Hysteresis& hysteresis;
};
SensitivityResult calc_sensitivity(const SlopeBasis& basis);
RangeResult slope_of_cycles(const SlopeBasis& basis, const PressureRange& range);
Uncertainty uncertainty_of(const SlopeBasis& basis, const RangeResult& r);
std::vector<Uncertainty> calc_uncertainties(const SlopeBasis& basis,
                                            const SensitivityResult& sensitivity);
// Adds to the reasons of the metrics, and what the meter's digit adds to the uncertainties.
void add_remarks(const Scene& scene, RunAnalysis& analysis);
std::vector<std::string> calc_notes(const Scene& scene, const MeasuredLevels& measured,
                                    const HoldResults& holds);

// `unit` as people write it: "% per cycle", "fF/kPa".
Metric metric(std::string_view what, std::string_view unit, std::string definition);
// Student's t interval about a value.
Estimate estimate(double value, double standard_error, double degrees_of_freedom,
                  double confidence);

// Of a standard deviation: from the chi-square distribution.
Estimate estimate_of_deviation(double value, double degrees_of_freedom, double confidence);

// Root sum of squares of the parts; Welch and Satterthwaite's degrees of freedom, truncated. They
// promise too much where a part has one or two degrees of freedom, as two or three repeats have,
// beside one that is known better: a 95 % interval holds in 87 % then. Adding the squares of the
// parts' half-widths holds in up to 98.7 %. There the half-width of the part with few is made
// smaller by what the other parts are (scene.cpp).
Estimate estimate_of_parts(double value, const std::vector<SlopePart>& parts, double confidence);

UncertaintyPart part(std::string name, double u, std::string basis);
UncertaintyPart shared(UncertaintyPart p);  // by the runs on this rig
// "loading branch, from 1.1 to 4.6 s after the load was reached"
std::string name_estimand(const Scene& scene, const LevelResults& levels,
                          const PressureRange& range);
// Of the level at this pressure.
std::string name_estimand(const Scene& scene, const LevelResults& levels, const CurvePoint& level);
void name_estimands(const Scene& scene, CycleResults& cycles);
// Add the differences that the other branch and another time would make, as systematic parts.
void add_other_choices(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b);
void add_other_choices_of_force_sensitivity(const SlopeBasis& basis, Uncertainty& b);
void add_other_choices_of_dynamic_range(const SlopeBasis& basis, Uncertainty& b);
void add_other_choices_of_highest_level(const SlopeBasis& basis, Uncertainty& b);

// Readings of a branch: of a cycle, with a force, under the settings, not in a hold. Call with
// growing numbers.
class Moving {
 public:
  Moving(const Scene& scene, const HoldResults& holds) : scene_(scene), holds_(holds.holds) {}
  bool operator()(std::size_t reading);

 private:
  const Scene& scene_;
  const std::vector<HoldResult>& holds_;
  std::size_t next_ = 0;
};

// The force turned while the meter measured: its mean over the window lies below that in the middle
// by up to a quarter of rate times window, and the reading belongs to neither branch.
bool spans_turn(const Loading& c, const RunReading& r);

// Levels of different repeats with the same key are the same point of the curve.
struct LevelKey {
  Direction direction = Direction::up;
  std::int64_t what = 0;  // target pressure, else index within the repeat
  auto operator<=>(const LevelKey&) const = default;
};
LevelKey key_of(const MeasuredLevel& level);
// "0-30 kPa"
std::string range_text(const PressureRange& range);

}  // namespace lcrig
