// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "analysis/metrics.hpp"
#include "storage/flags.hpp"

namespace lcrig {

namespace {

// A loading exceeds the noise of the cell by this many standard deviations.
constexpr double kLoading = 8;
constexpr double kForWelch = 3;  // degrees of freedom, fewest for Welch and Satterthwaite's rule
// Weights of the other parts in the reduction of a part that has one or two degrees of freedom: in
// its numerator and in its denominator. They come from our own numerical integration over the
// estimate of that part, beside a known part of 0.03 to 100 times its standard deviation. A 95 %
// interval holds in 93.3 to 96.7 % with one degree of freedom and in 94.4 to 95.5 % with two; a 99
// % interval in 97.6 to 99.6 and 98.6 to 99.4 %, a 90 % interval in 88.6 to 92.1 and 89.4 to 90.3
// %, and a 68 % interval in 67.8 to 69.3 and 67.2 to 68.0 %.
constexpr double kOthersOfTwo = 0.05, kOthers = 0.6;
constexpr double kAlmost = 1 + 1e-9;  // keeps 3 that is rounded to 2.999... at 3
// Share of the peak force below which nothing touches. With 2 % the capacitance at rest would
// include readings of a touched specimen.
constexpr double kUnloaded = 0.002;
// Flags of readings that are not trusted: beside an overload, the first after the link was lost, or
// a value that the meter cannot have measured.
constexpr std::uint32_t kNotTrusted =
    lcr_flag::kPrimaryOverload | lcr_flag::kAfterResync | lcr_flag::kOutOfRange;

auto key(const MeterSetting& s) {
  return std::tuple(s.frequency_Hz, s.level_V, s.bias_V, s.aperture, s.average);
}

// Chooses the setting with most readings, or if there are levels, with most readings in levels.
void choose_setting(const RunData& data, RunView& view) {
  if (data.settings.empty()) return;
  view.setting_known = true;
  view.setting = data.settings.front().meter;
  if (data.settings.size() == 1) return;
  const bool levels = std::any_of(data.readings.begin(), data.readings.end(),
                                  [](const RunReading& r) { return r.index > 0; });
  std::map<decltype(key(view.setting)), std::int64_t> counts;
  std::size_t at = 0;
  for (const RunReading& r : data.readings) {
    while (at + 1 < data.settings.size() && data.settings[at + 1].since_s <= r.t_s) ++at;
    if (!levels || r.index > 0) ++counts[key(data.settings[at].meter)];
  }
  if (counts.empty()) return;
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const auto& s : data.settings) {
    const bool used = key(s.meter) == most->first;
    if (used) view.setting = s.meter;
    view.changes_s.push_back(s.since_s);
    view.change_is_used.push_back(used);
  }
  view.different_settings = counts.size();
}

// The cell's noise from second differences of neighbouring forces. An even loading cancels in
// these, even where it takes half of the run.
double calc_force_noise(const RunData& data) {
  std::vector<double> differences;
  const std::size_t stride = std::max<std::size_t>(1, data.readings.size() / 20000);
  for (std::size_t i = 0; i + 2 < data.readings.size(); i += stride) {
    const RunReading &a = data.readings[i], &b = data.readings[i + 1], &c = data.readings[i + 2];
    if (!a.has_force() || !b.has_force() || !c.has_force()) continue;
    differences.push_back((c.force_N - b.force_N) - (b.force_N - a.force_N));
  }
  return robust_sigma(differences) / std::sqrt(6.0);
}

void find_rest_and_peak(const RunData& data, RunView& view) {
  std::vector<double> forces;
  forces.reserve(data.frame.size());
  for (const FramePoint& p : data.frame) {
    if (!std::isnan(p.force_N)) forces.push_back(p.force_N);
  }
  if (forces.empty()) return;
  std::sort(forces.begin(), forces.end());
  const auto quantile = [&forces](double q) {
    return forces[static_cast<std::size_t>(q * static_cast<double>(forces.size() - 1))];
  };
  view.force_noise_N = calc_force_noise(data);
  const double low = quantile(0.005), high = quantile(0.995);
  const auto end = std::upper_bound(forces.begin(), forces.end(), low + 0.1 * (high - low));
  view.rest_N = data.rest_force_N.value_or(
      median(std::vector<double>(forces.begin(), std::max(end, forces.begin() + 1))));
  const double peak = forces.back() - view.rest_N;
  if (high > low && peak > kLoading * view.force_noise_N) view.peak_N = peak;
}

// Finds the first touch. Where a slow search begins to touch, the force stays within half of the
// search's threshold for a while, so the reported contact is too late.
std::optional<double> find_touch(const RunView& view) {
  if (!view.data.contact_s || !view.data.has_frame()) return view.data.contact_s;
  const auto& all = view.data.readings;
  const auto found = std::ranges::lower_bound(all, *view.data.contact_s, {}, &RunReading::t_s);
  auto touch = static_cast<std::size_t>(found - all.begin());
  const auto last = touch;
  while (touch > 0 && all[touch - 1].has_force() && !view.is_unloaded(all[touch - 1])) --touch;
  if (touch < last && touch > 0) --touch;  // the window of this reading may reach into the contact
  if (touch == 0 || touch == all.size()) return view.data.contact_s;
  return std::min(*view.data.contact_s, all[touch].t_s);
}

}  // namespace

bool RunView::uses(const RunReading& r) const {
  if ((r.flags & kNotTrusted) != 0) return false;
  if (change_is_used.empty()) return true;
  const auto it = std::upper_bound(changes_s.begin(), changes_s.end(), r.t_s);
  return it == changes_s.begin() ||
         change_is_used[static_cast<std::size_t>(it - changes_s.begin()) - 1];
}

bool RunView::is_unloaded(const RunReading& r) const {
  return r.has_force() &&
         std::abs(above_rest_N(r)) <= std::max(kUnloaded * peak_N, 4 * force_noise_N);
}

bool RunView::is_at_rest(std::size_t reading) const {
  const auto& all = data.readings;
  return is_unloaded(all[reading]) && (reading == 0 || is_unloaded(all[reading - 1])) &&
         (reading + 1 == all.size() || is_unloaded(all[reading + 1]));
}

std::optional<double> RunView::kPa(double force_N) const {
  if (!data.area_m2) return std::nullopt;
  return force_N / *data.area_m2 * 1e-3;
}

RunView look_at(const RunData& data, const AnalysisOptions& options) {
  RunView view(data, options);
  choose_setting(data, view);
  find_rest_and_peak(data, view);
  view.touch_s = find_touch(view);
  view.flagged = std::count_if(data.readings.begin(), data.readings.end(),
                               [](const RunReading& r) { return r.flags & kNotTrusted; });
  return view;
}

bool Moving::operator()(std::size_t reading) {
  while (next_ < holds_.size() && holds_[next_].last <= reading) ++next_;
  if (next_ < holds_.size() && holds_[next_].first <= reading) return false;
  const RunReading& r = scene_.data.readings[reading];
  return r.has_force() && scene_.uses(r);
}

bool spans_turn(const Loading& c, const RunReading& r) {
  return std::abs(r.t_s - c.peak_s) < r.half_window_s();
}

Metric metric(std::string_view what, std::string_view unit, std::string definition) {
  std::string label = fmt::format("{}, {}", what, unit), name = fmt::format("{}_", what);
  std::ranges::replace(label, '_', ' ');
  for (const char c : unit) {
    const std::string other(1, c == ' ' ? '_' : c);
    name += c == '%' ? "percent" : c == '/' ? "_per_" : other;
  }
  return {std::move(name), std::move(label), std::move(definition), {}, {}, {}, 0, {}};
}

Estimate estimate(double value, double standard_error, double degrees_of_freedom,
                  double confidence) {
  const double half = coverage_factor(confidence, degrees_of_freedom) * standard_error;
  Estimate e(value);
  e.standard_error = standard_error;
  e.interval = {value - half, value + half};
  e.degrees_of_freedom = degrees_of_freedom;
  return e;
}

Estimate estimate_of_deviation(double value, double degrees_of_freedom, double confidence) {
  const auto end = [&](double probability) {
    return value *
           std::sqrt(degrees_of_freedom / chi_square_quantile(probability, degrees_of_freedom));
  };
  Estimate e(value);
  e.standard_error = value / std::sqrt(2 * degrees_of_freedom);
  e.interval = {end((1 + confidence) / 2), end((1 - confidence) / 2)};
  e.degrees_of_freedom = degrees_of_freedom;
  e.is_deviation = true;
  return e;
}

namespace {

// The parts with one and the same small number of degrees of freedom, combined.
struct FewFreedom {
  double variance = 0, denominator = 0;
  double freedom() const { return variance * variance / denominator; }  // Welch, Satterthwaite
};

double square_half_width(const std::vector<SlopePart>& parts, double confidence) {
  std::map<int, FewFreedom> few;
  double variance = 0, half2 = 0;
  for (const SlopePart& p : parts) {
    const double u2 = p.se * p.se;
    variance += u2;
    if (p.degrees_of_freedom < kForWelch) {
      FewFreedom& f = few[p.degrees_of_freedom < 2 ? 1 : 2];
      f.variance += u2;
      f.denominator += u2 * u2 / p.degrees_of_freedom;
    } else {
      const double t = coverage_factor(confidence, p.degrees_of_freedom);
      half2 += t * t * u2;
    }
  }
  for (const auto& [freedom, f] : few) {
    if (f.variance <= 0) continue;
    const double t = coverage_factor(confidence, f.freedom());
    const double others = std::max(0.0, variance - f.variance);
    half2 += t * t * f.variance * (f.variance + (freedom < 2 ? 0 : kOthersOfTwo) * others) /
             (f.variance + kOthers * others);
  }
  const double least = coverage_factor(confidence, std::numeric_limits<double>::infinity());
  return std::max(half2, least * least * variance);
}

}  // namespace

Estimate estimate_of_parts(double value, const std::vector<SlopePart>& parts, double confidence) {
  double variance = 0, denominator = 0;
  bool few = false;
  for (const SlopePart& p : parts) {
    const double u2 = p.se * p.se;
    variance += u2;
    denominator += u2 * u2 / p.degrees_of_freedom;
    few = few || (u2 > 0 && p.degrees_of_freedom < kForWelch);
  }
  if (few && variance > 0) {
    const double t = std::sqrt(square_half_width(parts, confidence) / variance);
    return estimate(value, std::sqrt(variance), freedom_of_factor(t, confidence), confidence);
  }
  const double freedom = denominator > 0 ? std::floor(variance * variance / denominator * kAlmost)
                         : parts.empty() ? std::numeric_limits<double>::infinity()
                                         : parts.front().degrees_of_freedom;
  return estimate(value, std::sqrt(variance), std::max(1.0, freedom), confidence);
}

std::string range_text(const PressureRange& range) {
  return fmt::format("{:g}-{:g} kPa", range.from_kPa, range.to_kPa);
}

}  // namespace lcrig
