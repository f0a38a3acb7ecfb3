// SPDX-License-Identifier: Apache-2.0
// Turns a recorded run into results: every metric with its definition, its standard error and the
// number of readings that it used. `lcrig analyze`, the report and the budget use it.
// docs/analysis.md explains the definitions and the statistics.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/conditions.hpp"
#include "analysis/definitions.hpp"
#include "analysis/rig_errors.hpp"
#include "analysis/run_data.hpp"
#include "analysis/uncertainty.hpp"

namespace lcrig {

struct AnalysisOptions {
  std::vector<PressureRange> ranges{{0, 30}, {35, 100}};
  bool search_regions = false;  // also look for the two linear regions of the curve
  double confidence = kConfidence;
  RigAccuracy rig;
};

// A result with its type A uncertainty, from scatter alone. RunAnalysis::uncertainties has all
// parts.
struct Estimate {
  Estimate() = default;
  explicit Estimate(double v) : value(v) {}
  double value = 0;
  std::optional<double> standard_error;
  std::optional<std::array<double, 2>> interval;  // at the confidence of AnalysisOptions
  std::optional<double> degrees_of_freedom;  // of standard_error
  bool is_deviation = false;  // of a standard deviation: the interval is from chi-square
};

// How the specimen was loaded where a result was measured.
enum class LoadKind {
  held,  // the load stays: levels, plateaus
  rising,  // while the load grows
  turning,  // at a peak that the load only passes
  mixed  // some cycles hold their peak and others pass it
};
enum class Direction { up, down };
template <>
inline constexpr EnumWords<2> kWordsOf<Direction>{"up", "down"};

// The branch, the pressures and the time under load that a result refers to. Results of two runs
// can be compared only where these are the same, or after a conversion.
struct LoadState {
  struct Pressure {
    double kPa = 0;  // as asked for, else as measured
    double measured_kPa = 0;
    double weight = 0;  // in the slope; their sum is 1
  };
  LoadKind kind = LoadKind::held;
  Direction direction = Direction::up;
  std::vector<Pressure> pressures;  // of a slope through levels, in rising order
  double from_kPa = 0, to_kPa = 0;  // of a slope while the load grows: the part that it covers
  double peak_N = 0;  // of the dynamic range, above the force at rest
  std::optional<double> peak_kPa;
  double per_peak = 0;  // relative change of the result for a relative change of the peak
  // log10 of the time under load in seconds: the mean over the window after the load was reached,
  // or while the load grows the time that it takes. Absent: not known.
  std::optional<double> log10_s;
};

struct Metric {
  std::string name;  // with its unit, as in the JSON: "C0_pF"
  std::string label;  // the same for people: "C0, pF"
  std::string definition;
  std::optional<Estimate> estimate;
  std::string estimand;  // branch and time it refers to, where there is a choice
  std::string reason;  // why there is no estimate, or a caveat; may be empty
  std::int64_t rows = 0;  // readings used
  std::optional<LoadState> load;  // absent: the result does not depend on how it was loaded

  explicit operator bool() const { return estimate.has_value(); }
  double value() const { return estimate->value; }  // precondition: there is an estimate
};

// One independent contribution to the standard error of a result.
struct SlopePart {
  double se = 0;  // standard error, in the unit of the result
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

// How the capacitance at the peak of a cycle was obtained: from a curve through the readings near
// the peak, from the mean of the readings that stay at the peak, or from the reading nearest to it.
enum class PeakMethod { fit, plateau, nearest };
template <>
inline constexpr EnumWords<3> kWordsOf<PeakMethod>{"fit to the force", "mean of the plateau",
                                                   "nearest reading"};

// What was measured in one `measure` step.
struct MeasuredLevel {
  std::int32_t level = 0, repeat = 0, index = 0;
  Direction direction = Direction::up;  // of the pressure, from the level before in the repeat
  double t_s = 0;  // mean time of its readings
  std::optional<double> target_kPa;
  double pressure_kPa = 0;  // mean over the readings, as measured
  double mean_pF = 0;  // of the readings, drift included
  std::optional<double> standard_error_fF;  // of the mean, from the scatter of the readings
  std::optional<double> scatter_fF;  // standard deviation of one reading
  // Standard deviation of the pressure of one reading, and its covariance with the capacitance.
  double pressure_scatter_kPa = 0, covariance_fF_kPa = 0;
  double trend_ss_fF2 = 0;  // part of their sum of squares that a line in time explains
  std::int32_t readings = 0;  // used
  std::int32_t missing = 0;  // planned readings that are missing, overloaded or without a force
  std::int32_t outliers = 0;  // among the readings used; see Outliers
  std::size_t first = 0, last = 0;  // the readings that count: [first, last) of RunData::readings
};
// A measured level with the drift of the unloaded capacitance subtracted.
struct LevelResult : MeasuredLevel {
  explicit LevelResult(const MeasuredLevel& measured) : MeasuredLevel(measured) {}
  double capacitance_pF = 0;
  double drift_fF = 0;  // the drift that was subtracted
  std::optional<double> delta_C_fF;  // capacitance - C0
};
struct LevelResults {
  std::vector<LevelResult> levels;
  // The line is fitted to the levels of one direction, the one with more levels.
  Direction line_direction = Direction::up;
};

// A change of C within levels that goes one way while the load is held: creep, relaxation.
struct DriftInLevels {
  std::int32_t levels = 0;  // number of levels that show it together
  double largest_fF = 0;  // from the first to the last reading of a level; of that with the largest
  double kPa = 0;  // of that level
  std::optional<double> percent;  // of the change that its load made
};

// A reading far from the median of its level or rest, or of its neighbours in a loading. It stays
// in all results except the robust slopes, the noise and the drift.
struct Outlier {
  double t_s = 0;
  std::int32_t level = 0, index = 0;  // level 0: the reading is from a rest or a loading
  double capacitance_pF = 0;
  double deviation_fF = 0, deviations = 0;  // `deviations`: the same in standard deviations
};
struct Outliers {
  std::vector<Outlier> outliers;  // only the 1000 with the largest deviations
  std::int64_t outlier_count = 0;
};

struct BaselineResult {
  Metric c0;  // C0_pF
  std::string c0_basis;  // where its standard error comes from
  Metric noise;  // noise_fF, of one reading
  Metric drift;  // baseline_drift_fF_per_h
  std::optional<double> drift_of_baseline_fF;  // mean of the last rest less that of the first
};

// The levels of all repeats at one pressure and one direction.
struct CurvePoint {
  Direction direction = Direction::up;
  double pressure_kPa = 0;
  double capacitance_pF = 0;
  std::optional<double> delta_C_fF;
  std::optional<double> standard_error_fF;  // type A; without that of C0, which all points share
  std::int32_t repeats = 0;
  std::int64_t readings = 0;
};
struct CurveResult {
  std::vector<CurvePoint> curve;  // sorted by direction, then by pressure
  Metric linearity;  // linearity_percent: of full scale, against the best straight line
  Metric linearity_terminal;  // linearity_terminal_percent
  Metric repeatability_range;  // repeatability_range_percent
  Metric repeatability_2sigma;  // repeatability_2sigma_percent
};

// The change of capacitance from C0 to the highest level.
struct HighestLevelResult {
  Metric delta_C;  // delta_C_at_top_fF
  double top_kPa = 0;
  std::vector<SlopePart> parts_of_delta_C;  // scatter, C0, drift, recovery after a load
};

// The slope by the same least squares through Huber's locations of the levels, not their means.
struct RobustSlope {
  double slope_fF_per_kPa = 0, standard_error = 0;
  std::int32_t down_weighted = 0;  // readings with less than half of their weight
};

// The slope over one range of pressure. Where it cannot be computed, `sensitivity.estimate` is
// absent and its `reason` says why.
struct RangeResult {
  PressureRange range;
  Metric sensitivity;  // sensitivity_fF_per_kPa
  std::optional<double> r_squared;  // absent when nothing changes
  std::optional<double> intercept_fF;  // of delta C (without a C0: of C less its mean), at 0 kPa
  std::optional<double> mean_kPa, mean_delta_C_fF;  // the fitted line passes through this point
  std::int32_t points = 0;  // levels (of all repeats together), or readings of a continuous loading
  std::int32_t pressures = 0;  // number of different pressures
  double residual_fF = 0;  // root mean square deviation of the points from the line
  std::optional<double> lack_of_fit_p;  // F test; small: the curve is not straight here
  std::optional<double> runs_p;  // runs test on the signs of the residuals
  std::string residual_pattern;  // in words
  std::optional<RobustSlope> robust;
  std::vector<double> slope_of_repeat;  // fF/kPa, of each repeat (or cycle) by itself
  std::string scatter_basis;  // where the standard error comes from
  std::vector<SlopePart> parts_of_error;  // scatter and drift; combined they are the standard error
  // Error that all repeats share, estimated from the deviations of the levels from a smooth curve.
  // Only the expanded uncertainty includes it. Absent with fewer than six levels.
  std::optional<SlopePart> shared;
  std::optional<double> between_repeats_p;  // F test; a small p means that the repeats differ
  // For a continuous loading: change of the rate of pressure with pressure, the largest standard
  // uncertainty of a reading's instant, and the change of the slope for a second of error in it.
  double rate_tilt_per_s = 0, instant_s = 0, moved_per_s = 0;
  Uncertainty uncertainty;  // without a sensitivity it has no parts
};

struct RegionSearch {
  std::string reason;  // why there is no answer; empty: there is one
  double low_to_kPa = 0, high_from_kPa = 0;
  RangeResult low, high;
  double p_one_line = 1;
};
struct SensitivityResult {
  std::vector<RangeResult> ranges;
  std::optional<RegionSearch> regions;
  Metric limit_of_detection;  // limit_of_detection_kPa
};

// One excursion of the force: a repeat of the static test, a cycle of the dynamic one, or a press.
struct Loading {
  std::int32_t number = 0;  // from 1
  double begin_s = 0, peak_s = 0, end_s = 0;
  double peak_force_N = 0;  // above the force at rest
  std::optional<double> peak_kPa;
  double peak_pF = 0;  // C at the largest force: the maximum of the cycle
  std::optional<double> peak_se_fF;
  double peak_freedom = 0;  // of its standard error, if the readings were independent
  std::optional<double> peak_travel_mm;
  std::int64_t loaded_readings = 0;
  std::size_t first = 0, last = 0;  // the loaded readings: [first, last) of RunData::readings
  PeakMethod peak_method = PeakMethod::fit;
  std::size_t plateau_first = 0, plateau_last = 0;  // its outermost readings, if there is one
};
// A loading together with the rest before it.
struct RestedLoading : Loading {
  explicit RestedLoading(const Loading& loading) : Loading(loading) {}
  double rest_pF = 0;  // mean C at rest before this cycle: its minimum
  double rest_s = 0;  // mean time of those readings
  std::optional<double> rest_se_fF;
};
struct CycleResult : RestedLoading {
  explicit CycleResult(const RestedLoading& loading) : RestedLoading(loading) {}
  double delta_C_fF = 0;  // peak - rest
  std::optional<double> delta_C_se_fF;
  double dynamic_range_percent = 0;  // delta C over C0
  std::optional<double> dynamic_range_se_percent;
  std::optional<double> slope_fF_per_N;  // of the loading branch, while the force grows
  std::optional<double> slope_se_fF_per_N;
  double slope_freedom = 0;  // of its standard error, if the readings were independent
};
struct CycleResults {
  std::vector<CycleResult> cycles;
  // Loadings that no result uses, because the run broke them off or because their peaks are lower.
  std::vector<CycleResult> left_out;
  std::string why_left_out;
  Metric dynamic_range;  // dynamic_range_percent
  Metric dynamic_range_drift;  // dynamic_range_drift_percent_per_cycle
  Metric force_sensitivity;  // force_sensitivity_fF_per_N, of the loading branches
  Metric mullins;  // mullins_index_percent
  std::vector<SlopePart> parts_of_force_sensitivity;  // scatter, drift
  std::vector<SlopePart> parts_of_dynamic_range;  // scatter, drift, recovery; percent
  // Change of the rate of force with force, and the largest standard uncertainty of an instant.
  double force_rate_tilt_per_s = 0, instant_s = 0;
};

// The mean loading and unloading curves of all cycles, at one force of a grid.
struct LoopPoint {
  double force_N = 0;  // above the force at rest
  double up_fF = 0, down_fF = 0;  // above C at rest before the cycle
  double gap_se_fF = 0;  // standard error of down_fF - up_fF
};
struct Hysteresis {
  Metric largest_gap;  // hysteresis_percent of the span
  Metric area;  // hysteresis_area_percent: of span times range of force
  // What the uncertainty of the readings' instants can make; systematic, not in the standard error.
  std::optional<double> alignment_percent;
  // The largest gap that would result if each reading had the force at its arrival instead of the
  // force in the middle of its window.
  std::optional<double> uncorrected_percent;
  bool resolved = false;  // the gap is larger than noise and alignment can explain
  bool in_readings = false;  // the gap exceeds the scatter of the readings of these cycles
  std::string basis;  // where the standard errors come from
  std::vector<LoopPoint> loop;
};

// A stretch of time in which the load is steady.
struct HoldResult {
  std::int32_t cycle = 0;  // number of the cycle it lies in; 0: none
  std::string step_id;
  double begin_s = 0, end_s = 0;
  double mean_force_N = 0;  // above rest
  double mean_fF = 0;  // mean of C
  std::optional<double> force_change_percent;  // last tenth against first tenth
  std::int64_t readings = 0;
  std::size_t first = 0, last = 0;  // of RunData::readings: [first, last)
  double change_fF = 0, change_se_fF = 0;  // of C, from a line against log time
  std::optional<double> per_decade_fF, per_decade_se_fF;  // slope of that line per decade of time
  std::optional<double> drift_fF_per_s, drift_se_fF_per_s;  // over the last half
  bool resolved = false;  // the change is larger than noise can explain
  std::optional<double> time_constant_s;  // of one fitted exponential; absent unless `resolved`
  std::optional<double> settling_s;  // time until C is within 2 % of its total change from rest
  std::string reason;  // why some results are missing
};

struct HoldResults {
  std::vector<HoldResult> holds;
  std::size_t holds_left_out = 0;  // those beyond the first thousand are not listed
  Metric creep;  // creep_percent_per_decade
  Metric settling;  // settling_time_s
};

// A sine in the readings that does not come from the specimen, such as the beat of the meter with
// the mains. It is subtracted from all readings before anything else is computed.
struct Hum {
  double frequency_Hz = 0;
  double cosine_fF = 0, sine_fF = 0;
  double period_s() const { return 1 / frequency_Hz; }
  double amplitude_fF() const { return std::hypot(cosine_fF, sine_fF); }
  double at(double t_s) const {
    const double phase = 2 * std::numbers::pi * frequency_Hz * t_s;
    return cosine_fF * std::cos(phase) + sine_fF * std::sin(phase);
  }
};

// Facts about a run that are known before its rows are read.
struct RunFacts {
  std::int64_t run = 0;
  std::string protocol, specimen, function;
  bool simulated = false;
  std::optional<ExitStatus> exit_status;
  bool proof_known = false;  // as in RunData
  std::int64_t unproven_readings = 0;
  AnalysisOptions options;
  PressureArea pressure;  // what its pressures are over
  RunConditions conditions;
};

// The results of all passes. Each pass takes the results it builds on and returns its own.
struct RunAnalysis : RunFacts,
                     Outliers,
                     BaselineResult,
                     LevelResults,
                     CurveResult,
                     HighestLevelResult,
                     CycleResults,
                     HoldResults,
                     SensitivityResult {
  Hysteresis hysteresis;
  // The uncertainties of every sensitivity (the same as in its range), C0, dynamic range, force
  // sensitivity, delta C at the highest level and hysteresis.
  std::vector<Uncertainty> uncertainties;
  std::vector<std::string> notes;  // facts that a reader must know: gaps, overloads, assumptions
  std::optional<Hum> hum;  // absent: none was found
  std::optional<DriftInLevels> drift_in_levels;  // absent: none was found

  // Every metric of this analysis, including those of the ranges, in the order of a table.
  std::vector<const Metric*> metrics() const;
  // The range whose sensitivity `metric` is. Null for a metric of the whole run.
  const RangeResult* range_of(const Metric& metric) const;
  // Its uncertainty. Null: it has none, so only its scatter is known.
  const Uncertainty* uncertainty_of(const Metric& metric) const;
  // The metrics outside the ranges that depend on the choice of a branch or of a time.
  std::vector<const Metric*> chosen() const {
    return {&dynamic_range, &force_sensitivity, &delta_C};
  }
};

// Loads and analyses a run. Errors: those of load_run_data; options that make no sense. A metric
// that the run cannot give is not an error; its reason says why.
Result<RunAnalysis> analyse(const Database& db, std::int64_t run,
                            const AnalysisOptions& options = {});
// Analyses a run that is already loaded, without changing it.
Result<RunAnalysis> analyse(const RunData& data, const AnalysisOptions& options = {});

// The JSON of `lcrig analyze --json`. docs/analysis.md lists the names.
nlohmann::json to_json(const RunAnalysis& analysis);
nlohmann::json to_json(const Uncertainty& uncertainty);

}  // namespace lcrig
