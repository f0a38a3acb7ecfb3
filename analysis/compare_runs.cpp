// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "analysis/comparison.hpp"
#include "analysis/likeness.hpp"
#include "analysis/metrics.hpp"
#include "analysis/verdict.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

// A difference is named if its part is at least this share of the standard error of the ratio.
constexpr double kNamed = 0.1;

constexpr const char* kOpen = "open correction";  // a part of the uncertainty of C0

enum class Kind { sensitivity, c0, dynamic_range };

// A result of one run.
struct Compared {
  std::string name;
  Kind kind = Kind::sensitivity;
  const Metric* metric = nullptr;
  Uncertainty uncertainty;
  PressureRange range;
};

std::string sensitivity_name(const PressureRange& range) {
  return fmt::format("sensitivity {}", range_text(range));
}

Uncertainty uncertainty_named(const RunAnalysis& a, const std::string& name) {
  const auto found = std::ranges::find(a.uncertainties, name, &Uncertainty::quantity);
  return found == a.uncertainties.end() ? Uncertainty() : *found;
}

std::vector<Compared> results_of(const RunAnalysis& a) {
  std::vector<Compared> out;
  for (const RangeResult& r : a.ranges) {
    const std::string name = sensitivity_name(r.range);
    out.push_back({name, Kind::sensitivity, &r.sensitivity, uncertainty_named(a, name), r.range});
  }
  out.push_back({"C0", Kind::c0, &a.c0, uncertainty_named(a, "C0"), {}});
  out.push_back({"dynamic range",
                 Kind::dynamic_range,
                 &a.dynamic_range,
                 uncertainty_named(a, "dynamic range"),
                 {}});
  return out;
}

bool has_gap(const Compared& result, std::string_view part) {
  return std::ranges::any_of(result.uncertainty.parts, [part](const UncertaintyPart& p) {
    return p.is_gap && p.name == part;
  });
}

// The parts of either result of which no size is known.
std::vector<std::string> name_gaps(const Compared& a, const Compared& b) {
  std::set<std::string> names;
  for (const Compared* result : {&a, &b}) {
    for (const UncertaintyPart& p : result->uncertainty.parts) {
      if (p.is_gap) names.insert(p.name);
    }
  }
  return {names.begin(), names.end()};
}

bool same_pressures(const LoadState& a, const LoadState& b) {
  return std::ranges::equal(a.pressures, b.pressures, [](const auto& p, const auto& q) {
    return is_near(p.kPa, q.kPa) && is_near(p.weight, q.weight);
  });
}

std::vector<double> common_pressures(const LoadState& a, const LoadState& b) {
  std::vector<double> out;
  for (const LoadState::Pressure& p : a.pressures) {
    const bool in_both = std::ranges::any_of(
        b.pressures, [&p](const LoadState::Pressure& q) { return is_near(q.kPa, p.kPa); });
    if (in_both) out.push_back(p.kPa);
  }
  return out;
}

std::string list_of(const std::vector<double>& kPa) {
  std::vector<std::string> words;
  words.reserve(kPa.size());
  for (const double p : kPa) words.push_back(fmt::format("{:.4g}", p));
  return fmt::format("{}", fmt::join(words, ", "));
}

// "force over the disc of 8 mm in run 1 and of 4 mm in run 2"
std::string over_discs_text(const RunAnalysis& from, const RunAnalysis& to) {
  return fmt::format(
      "pressure on the disc: force over the disc of {:g} mm in run {} and of {:g} mm "
      "in run {}",
      *from.pressure.disc_diameter_m * 1e3, from.run, *to.pressure.disc_diameter_m * 1e3, to.run);
}

// One quantity of two runs, from the judgement of what is unlike to the interval of the ratio.
class Pair {
 public:
  // `over_discs`: how both were converted to pressures on the disc; empty: they were not.
  Pair(const RunAnalysis& from, const RunAnalysis& to, const AnalyseAgain& again,
       std::string over_discs)
      : from_(from),
        to_(to),
        again_(again),
        over_discs_(std::move(over_discs)),
        sources_(compare_sources(from, to)) {}

  Comparison compare(Compared a, Compared b) {
    Comparison c;
    c.from_run = from_.run;
    c.to_run = to_.run;
    c.from_specimen = from_.specimen;
    c.to_specimen = to_.specimen;
    c.quantity = a.name;
    parts_.clear();
    known_.clear();
    obstacles_.clear();
    judge(a, b, c);
    if (*a.metric) c.from_value = a.metric->value();
    if (*b.metric) c.to_value = b.metric->value();
    if (obstacles_.empty()) add_interval(a, b, c);
    refuse(c);
    c.verdict = verdict_on(c, verdict_scope(a, b));
    return c;
  }

 private:
  // Converts where that is possible, and finds everything that forbids the comparison.
  void judge(Compared& a, Compared& b, Comparison& c) {
    if (from_.run == to_.run) {
      add(Unlike{fmt::format("both are run {}: its ratio to itself is 1 by definition", from_.run),
                 "name another run"});
      return;
    }
    for (const auto& [result, run] : {std::pair(&a, &from_), {&b, &to_}}) {
      if (*result->metric) continue;
      add(Unlike{fmt::format("run {} has none{}{}", run->run,
                             result->metric->reason.empty() ? "" : ": ", result->metric->reason),
                 "measure it in both"});
    }
    c.differences = name_differences(from_, to_);
    add(unlike_settings(from_, to_));
    if (a.kind != Kind::sensitivity && (has_gap(a, kOpen) || has_gap(b, kOpen))) {
      add(unlike_corrections(from_, to_));
    }
    if (a.kind == Kind::c0) return;
    c.converted = over_discs_;
    add(unlike_contact(from_, to_));
    if (!*a.metric || !*b.metric) return;
    if (!a.metric->load || !b.metric->load) {
      return add(
          Unlike{"how the specimen was loaded is not known", "measure both with one protocol"});
    }
    judge_load(a, b, c);
  }

  void judge_load(Compared& a, Compared& b, Comparison& c) {
    const LoadState &p = *a.metric->load, &q = *b.metric->load;
    const auto unlike = unlike_loading(p, q, from_, to_);
    add(unlike);
    if (a.kind == Kind::dynamic_range) add(align_peaks(a, b));
    if (!unlike.empty()) return;  // then pressures and times have other meanings
    if (a.kind == Kind::sensitivity) add(align_ranges(a, b, c));
    add(align_times(a, b));
  }

  void add(std::optional<Unlike> unlike) {
    if (unlike) obstacles_.push_back(std::move(*unlike));
  }
  void add(const Obstacles& all) { obstacles_.insert(obstacles_.end(), all.begin(), all.end()); }

  void refuse(Comparison& c) const {
    if (obstacles_.empty()) return;
    c.converted.clear();
    c.not_included.clear();
    std::set<std::string> remedies;
    for (const Unlike& unlike : obstacles_) {
      add_remark(c.refused, unlike.reason);
      if (remedies.insert(unlike.remedy).second) add_remark(c.remedy, unlike.remedy);
    }
  }

  std::optional<Unlike> align_peaks(const Compared& a, const Compared& b) {
    const LoadState &p = *a.metric->load, &q = *b.metric->load;
    if (auto unlike = unlike_peak(p, q, from_, to_)) return unlike;
    const bool known = p.peak_kPa && q.peak_kPa;
    const double ratio = known ? *q.peak_kPa / *p.peak_kPa : q.peak_N / p.peak_N;
    add_part(std::log(ratio) * std::max(std::abs(p.per_peak), std::abs(q.per_peak)),
             fmt::format("the peaks differ by {:.2g} %", std::abs(ratio - 1) * 100));
    return std::nullopt;
  }

  std::optional<Unlike> align_ranges(Compared& a, Compared& b, Comparison& c) {
    const LoadState &p = *a.metric->load, &q = *b.metric->load;
    PressureRange common = a.range;
    std::string how;
    if (p.kind == LoadKind::rising) {
      if (is_near(p.from_kPa, q.from_kPa) && is_near(p.to_kPa, q.to_kPa)) {
        add_pressures(std::log((q.from_kPa + q.to_kPa) / (p.from_kPa + p.to_kPa)));
        return std::nullopt;
      }
      common = {std::max(p.from_kPa, q.from_kPa), std::min(p.to_kPa, q.to_kPa)};
      how = fmt::format("both slopes over {:.3g}-{:.3g} kPa, which both loadings cover",
                        common.from_kPa, common.to_kPa);
    } else if (!same_pressures(p, q)) {
      common.only_kPa = common_pressures(p, q);
      how = fmt::format("both slopes over the pressures in both runs, {} kPa, with equal weights",
                        list_of(common.only_kPa));
    }
    if (!how.empty()) {
      if (auto unlike = convert(common, a, b)) return unlike;
      add_remark(c.converted, how);
    }
    add_pressures(largest_difference(*a.metric->load, *b.metric->load));
    return std::nullopt;
  }

  std::optional<Unlike> convert(const PressureRange& common, Compared& a, Compared& b) {
    const bool levels = a.metric->load->kind == LoadKind::held;
    Unlike none{
        levels ? fmt::format("fewer than two pressures are in both runs in {}", range_text(a.range))
               : fmt::format("the loadings have too little in common in {}", range_text(a.range)),
        "measure both at the same pressures"};
    const bool possible = levels ? common.only_kPa.size() >= 2 : common.from_kPa < common.to_kPa;
    if (!possible) return none;
    if (!obstacles_.empty()) return std::nullopt;  // no comparison, so no slopes either
    if (!take(slope_in(from_, common), a, from_slope_) ||
        !take(slope_in(to_, common), b, to_slope_)) {
      return none;
    }
    return std::nullopt;
  }

  std::optional<RangeResult> slope_in(const RunAnalysis& run, const PressureRange& range) const {
    AnalysisOptions options = run.options;
    options.ranges = {range};
    options.search_regions = false;
    auto again = again_ ? again_(run, run.pressure.on, options) : std::nullopt;
    return again ? std::optional(std::move(again->ranges.front())) : std::nullopt;
  }

  static bool take(std::optional<RangeResult> slope, Compared& into,
                   std::optional<RangeResult>& kept) {
    if (!slope || !slope->sensitivity || !slope->sensitivity.load) return false;
    kept = std::move(slope);
    into.metric = &kept->sensitivity;
    into.uncertainty = kept->uncertainty;
    return true;
  }

  // The slope of a bent curve moves with its pressures, at most in proportion to them.
  void add_pressures(double relative) {
    add_part(relative,
             fmt::format("the pressures differ by up to {:.2g} %", std::abs(relative) * 100));
  }

  static double largest_difference(const LoadState& p, const LoadState& q) {
    double largest = 0;
    for (std::size_t i = 0; i < std::min(p.pressures.size(), q.pressures.size()); ++i) {
      const double a = p.pressures[i].measured_kPa, b = q.pressures[i].measured_kPa;
      if (a > 0 && b > 0) largest = std::max(largest, std::abs(std::log(b / a)));
    }
    return largest;
  }

  std::optional<Unlike> align_times(const Compared& a, const Compared& b) {
    const LoadState &p = *a.metric->load, &q = *b.metric->load;
    TimeLikeness times = compare_times(p, q, from_, to_);
    if (times.unlike) return times.unlike;
    add_part(
        times.relative,
        fmt::format("the times under load differ by {:.2g} decades, in which {} may change the "
                    "ratio by {:.2g} %",
                    times.decades, times.assumed ? "a creep that is not known" : "the creep",
                    times.relative * 100));
    return std::nullopt;
  }

  // A known difference that is not corrected counts in full, not as the limit of a rectangle.
  void add_part(double relative, std::string words) {
    if (relative == 0) return;
    parts_.push_back({std::abs(relative)});
    known_.push_back(std::move(words));
  }

  // Works with the logarithm of the ratio, whose interval never crosses 0.
  void add_interval(const Compared& a, const Compared& b, Comparison& c) {
    const double ratio = b.metric->value() / a.metric->value();
    if (!(ratio > 0)) add(Unlike{"one of the two is not positive", "look at the single runs"});
    std::vector<SlopePart> parts = parts_;
    for (const auto& [result, run] : {std::pair(&a, &from_), {&b, &to_}}) {
      const auto scatter =
          std::ranges::find(result->uncertainty.parts, UncertaintyKind::a, &UncertaintyPart::kind);
      if (scatter == result->uncertainty.parts.end()) {
        add(Unlike{fmt::format("the scatter of run {} is not known", run->run),
                   "measure more repeats or readings"});
      }
      add_own(*result, parts);
    }
    if (!obstacles_.empty()) return;
    c.not_included = name_gaps(a, b);
    if (a.kind != Kind::c0) {
      if (auto disc = unknown_disc(from_, to_); !disc.empty()) c.not_included.push_back(disc);
    }
    for (const SourceLikeness& s : sources_) add_source(s, a, b, parts, c);
    const Estimate e = estimate_of_parts(0, parts, from_.options.confidence);
    c.increase_percent = (ratio - 1) * 100;
    c.standard_error_percent = ratio * *e.standard_error * 100;
    const auto [low, high] = *e.interval;
    c.ratio = {ratio * std::exp(low), ratio * std::exp(high)};
    c.interval_percent = {((*c.ratio)[0] - 1) * 100, ((*c.ratio)[1] - 1) * 100};
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (parts_[i].se >= kNamed * *e.standard_error) c.differences.push_back(known_[i]);
    }
  }

  static double relative(const Compared& r, const UncertaintyPart& p) {
    return p.standard_uncertainty / std::abs(r.metric->value());
  }

  static void add_own(const Compared& r, std::vector<SlopePart>& parts) {
    for (const UncertaintyPart& p : r.uncertainty.parts) {
      if (p.source == ErrorSource::run) {
        parts.push_back({relative(r, p), p.degrees_of_freedom});
      }
    }
  }

  // One and the same error moves both results. Of that, only the difference of its effects on them
  // is left in the ratio.
  static void add_source(const SourceLikeness& s, const Compared& a, const Compared& b,
                         std::vector<SlopePart>& parts, Comparison& c) {
    std::map<std::string, std::array<double, 2>> sizes;
    for (const auto& p : a.uncertainty.parts) {
      if (p.source == s.source) sizes[p.name][0] = relative(a, p);
    }
    for (const auto& p : b.uncertainty.parts) {
      if (p.source == s.source) sizes[p.name][1] = relative(b, p);
    }
    bool any = false;
    for (const auto& [name, size] : sizes) {
      const auto [from, to] = size;
      any = any || from > 0 || to > 0;
      if (s.why_not.empty()) {
        parts.push_back({std::abs(from - to)});
      } else {
        parts.push_back({from});
        parts.push_back({to});
      }
    }
    if (!any) return;
    if (s.why_not.empty()) {
      c.shared.push_back(s.what);
    } else {
      c.not_shared.push_back(fmt::format("{} ({})", to_string(s.source), s.why_not));
    }
  }

  static std::string where(const Compared& a) {
    if (a.kind == Kind::c0) return "";
    if (!a.metric->load) return a.kind == Kind::sensitivity ? range_text(a.range) : "";
    const LoadState& load = *a.metric->load;
    if (a.kind == Kind::dynamic_range) {
      return load.peak_kPa ? fmt::format("{:.3g} kPa", *load.peak_kPa)
                           : fmt::format("{:.3g} N", load.peak_N);
    }
    if (load.kind == LoadKind::rising) {
      return fmt::format("{:.3g}-{:.3g} kPa", load.from_kPa, load.to_kPa);
    }
    return range_text(a.range);
  }

  VerdictScope verdict_scope(const Compared& a, const Compared& b) const {
    VerdictScope out;
    out.quantity = a.kind == Kind::sensitivity ? "sensitivity" : a.name;
    out.where = where(a);
    if (a.kind == Kind::sensitivity && a.metric->load && b.metric->load) {
      out.direction = b.metric->load->direction;
    }
    out.confidence = from_.options.confidence;
    out.from_origin = origin_of(from_.conditions);
    out.to_origin = origin_of(to_.conditions);
    return out;
  }

  const RunAnalysis &from_, &to_;
  const AnalyseAgain& again_;
  std::string over_discs_;
  std::vector<SourceLikeness> sources_;
  Obstacles obstacles_;
  std::vector<SlopePart> parts_;  // of known differences, relative
  std::vector<std::string> known_;  // the same in words
  std::optional<RangeResult> from_slope_, to_slope_;  // converted
};

// Both with their pressures over the disc, where only that makes them alike.
std::optional<std::array<RunAnalysis, 2>> over_discs(const RunAnalysis& from, const RunAnalysis& to,
                                                     const AnalyseAgain& again) {
  if (!again || unlike_contact(from, to).empty() || !are_alike_over_disc(from, to)) return {};
  auto a = again(from, PressureOn::disc, from.options), b = again(to, PressureOn::disc, to.options);
  if (!a || !b) return {};
  return std::array{std::move(*a), std::move(*b)};
}

void compare_two(const RunAnalysis& from, const RunAnalysis& to, const AnalyseAgain& again,
                 std::vector<Comparison>& out) {
  const auto discs = from.run == to.run ? std::nullopt : over_discs(from, to, again);
  const RunAnalysis &one = discs ? (*discs)[0] : from, &two = discs ? (*discs)[1] : to;
  Pair pair(one, two, again, discs ? over_discs_text(one, two) : "");
  const auto of_two = results_of(two);
  for (Compared& a : results_of(one)) {
    for (const Compared& b : of_two) {
      if (a.name != b.name || (!*a.metric && !*b.metric)) continue;
      out.push_back(pair.compare(a, b));
    }
  }
}

// The force over the disc instead of the probe.
RunData over_disc(RunData data) {
  const double factor = *data.pressure.on_disc();
  data.pressure.on = PressureOn::disc;
  data.area_m2 = data.pressure.area_m2();
  for (LevelRow& l : data.levels) {
    if (l.target_pressure_Pa) *l.target_pressure_Pa *= factor;
  }
  return data;
}

}  // namespace

std::string Comparison::remark() const {
  std::string out = refused;
  add_remark(out, converted);
  for (const std::string& d : differences) add_remark(out, d);
  add_remark(out, not_included_text());
  return out;
}

std::string Comparison::not_included_text() const {
  return not_included.empty()
             ? ""
             : fmt::format("not in the interval: {}", fmt::join(not_included, ", "));
}

std::vector<Comparison> compare(std::span<const RunAnalysis> runs, const AnalyseAgain& again) {
  std::vector<Comparison> out;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    compare_two(runs[i - 1], runs[i], again, out);
    if (i > 1) compare_two(runs[0], runs[i], again, out);
  }
  return out;
}

AnalyseAgain analyses_of(std::vector<const RunData*> runs) {
  return [runs = std::move(runs)](const RunAnalysis& run, PressureOn on,
                                  const AnalysisOptions& options) -> std::optional<RunAnalysis> {
    const auto data = std::ranges::find(runs, run.run, &RunData::run);
    if (data == runs.end()) return std::nullopt;
    const bool converts = on == PressureOn::disc && (*data)->pressure.on == PressureOn::probe;
    auto again = converts ? analyse(over_disc(**data), options) : analyse(**data, options);
    return again ? std::optional(std::move(*again)) : std::nullopt;
  };
}

}  // namespace lcrig
