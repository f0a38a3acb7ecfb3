// SPDX-License-Identifier: Apache-2.0
// The passes of an analysis, in the order in which they build on each other. Private to analysis/.
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

// The run before anything is computed from it: which readings count, and what the force at rest is.
struct RunView {
  RunView(const RunData& d, const AnalysisOptions& o) : data(d), options(o) {}

  const RunData& data;
  const AnalysisOptions& options;
  // The setting whose readings count. Readings under another setting are another experiment.
  MeterSetting setting;
  bool setting_known = false;
  std::size_t different_settings = 1;
  std::vector<double> changes_s;  // times at which the setting changed ...
  std::vector<bool> change_is_used;  // ... and whether it is `setting` from then on; empty: always
  std::int64_t flagged = 0;  // readings that are not trusted because of their flags
  double rest_N = 0;  // force that the cell shows while nothing touches
  double peak_N = 0;  // largest force above rest; 0: there is no loading
  double force_noise_N = 0;  // of one sample
  // Readings before this time are the baseline. nullopt: the run records no contact.
  std::optional<double> touch_s;

  bool uses(const RunReading& r) const;
  double above_rest_N(const RunReading& r) const { return r.force_N - rest_N; }
  bool is_unloaded(const RunReading& r) const;
  // True if nothing touches: the reading and both its neighbours are unloaded. At the edges of a
  // contact the force is already within its noise, so the neighbours are checked, too.
  bool is_at_rest(std::size_t reading) const;
  std::optional<double> kPa(double force_N) const;
};
RunView look_at(const RunData& data, const AnalysisOptions& options);

std::vector<Loading> find_loadings(const RunView& view);

// The loadings and the stretches between them.
struct Rests {
  std::vector<RestedLoading> loadings;
  // Correlation of neighbouring readings: within the levels (where the specimen may creep), and
  // without a load. In a run without levels both are the one without a load.
  Correlation correlation, rest_correlation;
  Drift drift;  // of the unloaded capacitance
  std::vector<Outlier> outliers_of_rests;  // they do not count for the drift
};
// Number of standard deviations beyond which a reading is an outlier. A run without outliers would
// show one in a hundred runs.
double limit_of_outliers(std::size_t readings);
Outlier outlier_of(const RunReading& r, double middle_F, double sigma_F);
Rests find_rests(const RunView& view, const std::vector<Loading>& loadings);

struct MeasuredLevels {
  std::vector<MeasuredLevel> levels;
  Direction line_direction = Direction::up;
  std::int64_t without_force = 0;
  Outliers outliers;  // includes those of the rests and of loadings without levels
  std::optional<DriftInLevels> drift_in_levels;  // absent: none is more than chance
};
MeasuredLevels measure_levels(const RunView& view, const Rests& rests);

// Finds a sine in the readings that does not come from the specimen: the meter's beat with the
// mains (hum.cpp). It searches the stretches in which the load is steady: the baseline, the levels
// and the later halves of rests. From each stretch its mean is taken out. From levels and rests
// everything is taken out that all of them have in common or that is proportional to the
// capacitance of the level, so that creep and recovery are not taken for a sine. nullopt: there is
// no sine, or the run is too short or too long to tell.
std::optional<Hum> find_hum(const RunView& view, const Rests& rests,
                            const MeasuredLevels& measured);

// The run with the sine subtracted from every reading.
RunData without(const Hum& hum, const RunData& data);

std::string note_on(const Hum& hum);

// The run together with its drift. Every result under load starts from it.
struct Scene : RunView, Rests {
  // The scatter of the levels decides what part of the rests' deviations from a line is subtracted.
  // A capacitance that jumps at each new contact moves the rests, too, but between rests it does
  // not follow them. Subtracting the deviations would then only add scatter.
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
// Parts of calc_cycles in files of their own. They change its result, because the later one works
// on the loadings that the first has left. calc_mullins compares delta C at equal peak force, or
// the force at equal peak travel since contact.
void leave_out_other_loadings(const Scene& scene, CycleResults& cycles);
void calc_mullins(const Scene& scene, CycleResults& cycles);
// Travel at which the first loading touched. nullopt: no travel, or the run began under load.
std::optional<double> contact_mm(const Scene& scene);
// Slope of C against force at the peak. Precondition: at least one loading.
double slope_at_peak_fF_per_N(const Scene& scene, const std::vector<CycleResult>& cycles);
Hysteresis calc_hysteresis(const Scene& scene, const CycleResults& cycles,
                           const HoldResults& holds);

// The results from which a slope against pressure and its uncertainty are computed.
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
// The last pass. It changes what the others made: it adds caveats to the reasons of the metrics and
// the meter's digit to the uncertainties, and removes what is no finite number.
void add_remarks(const Scene& scene, RunAnalysis& analysis);
std::vector<std::string> calc_notes(const Scene& scene, const MeasuredLevels& measured,
                                    const HoldResults& holds);

// `unit` is written as for people: "% per cycle", "fF/kPa".
Metric metric(std::string_view what, std::string_view unit, std::string definition);
// An estimate with a Student's t interval about its value.
Estimate estimate(double value, double standard_error, double degrees_of_freedom,
                  double confidence);

// An estimate of a standard deviation. Its interval comes from the chi-square distribution.
Estimate estimate_of_deviation(double value, double degrees_of_freedom, double confidence);

// Root sum of squares of the parts, with Welch and Satterthwaite's degrees of freedom, truncated.
// These promise too much where a part with one or two degrees of freedom (from two or three
// repeats) stands beside one that is known better: a 95 % interval then holds in 87 %. Adding the
// squares of the parts' half-widths instead holds in up to 98.7 %. In this case the half-width of
// the part with few degrees of freedom is reduced according to the size of the other parts
// (scene.cpp).
Estimate estimate_of_parts(double value, const std::vector<SlopePart>& parts, double confidence);

// The errors of the run's rig for a specimen of this capacitance.
RigErrors rig_errors_of(const RunView& view, double capacitance_pF);
UncertaintyPart part(std::string name, double u, std::string basis);
UncertaintyPart of(ErrorSource source, UncertaintyPart p);
// Sets estimand and load of a slope: "loading branch, from 1.1 to 4.6 s after the load was
// reached". The pressures are left to the caller.
void name_estimand(const Scene& scene, const LevelResults& levels, const PressureRange& range,
                   Metric& slope);
// The estimand of the level at this pressure.
std::string name_estimand(const Scene& scene, const LevelResults& levels, const CurvePoint& level);
void name_estimands(const Scene& scene, CycleResults& cycles);
// Each adds, as systematic parts, how much the result differs with the other branch or time.
void add_other_choices(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b);
void add_other_choices_of_force_sensitivity(const SlopeBasis& basis, Uncertainty& b);
void add_other_choices_of_dynamic_range(const SlopeBasis& basis, Uncertainty& b);
void add_other_choices_of_highest_level(const SlopeBasis& basis, Uncertainty& b);

// Tells whether a reading belongs to a moving branch: it lies in a cycle, has a force, was taken
// under the setting, and is not in a hold. Call with increasing numbers.
class Moving {
 public:
  Moving(const Scene& scene, const HoldResults& holds) : scene_(scene), holds_(holds.holds) {}
  bool operator()(std::size_t reading);

 private:
  const Scene& scene_;
  const std::vector<HoldResult>& holds_;
  std::size_t next_ = 0;
};

// True if the force turned while the meter measured. Its mean over the window then lies below that
// in the middle by up to a quarter of rate times window, and the reading belongs to no branch.
bool spans_turn(const Loading& c, const RunReading& r);

// Identifies a point of the curve: levels of several repeats with the same key are one point.
struct LevelKey {
  Direction direction = Direction::up;
  std::int64_t what = 0;  // target pressure, or without one the index in the repeat
  auto operator<=>(const LevelKey&) const = default;
};
LevelKey key_of(const MeasuredLevel& level);
// "0-30 kPa"
std::string range_text(const PressureRange& range);

}  // namespace lcrig
