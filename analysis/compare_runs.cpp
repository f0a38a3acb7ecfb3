// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

struct Quantity {
  std::string name;
  double value = 0;
  std::vector<SlopePart> relative;  // parts that runs do not share; empty: not known
};

Quantity quantity(const RunAnalysis& a, const std::string& name, double value) {
  Quantity q;
  q.name = name;
  q.value = value;
  const auto known = std::ranges::find(a.uncertainties, name, &Uncertainty::quantity);
  if (known == a.uncertainties.end() || value == 0) return q;
  std::vector<UncertaintyPart> own = known->parts;
  std::erase_if(own, [](const UncertaintyPart& p) { return p.shared_by_runs; });
  if (own.empty() || own.front().kind != UncertaintyKind::a) return q;
  for (const UncertaintyPart& p : own) {
    q.relative.push_back({p.standard_uncertainty / std::abs(value), p.degrees_of_freedom});
  }
  return q;
}

std::vector<Quantity> quantities(const RunAnalysis& a) {
  std::vector<Quantity> out;
  const auto add = [&](const std::string& name, const Metric& m) {
    if (m) out.push_back(quantity(a, name, m.value()));
  };
  for (const RangeResult& r : a.ranges) {
    add(fmt::format("sensitivity {}", range_text(r.range)), r.sensitivity);
  }
  add("C0", a.c0);
  add("dynamic range", a.dynamic_range);
  return out;
}

// The ratio in logarithms: its interval never crosses zero, and what both share is gone.
void add_interval(const Quantity& from, const Quantity& to, double confidence, Comparison& c) {
  if (from.relative.empty() || to.relative.empty()) return;
  std::vector<SlopePart> parts = from.relative;
  parts.insert(parts.end(), to.relative.begin(), to.relative.end());
  const Estimate e = estimate_of_parts(0, parts, confidence);
  const double ratio = to.value / from.value;
  c.standard_error_percent = std::abs(ratio) * *e.standard_error * 100;
  if (ratio <= 0) return;
  const auto [low, high] = *e.interval;
  c.interval_percent = {(ratio * std::exp(low) - 1) * 100, (ratio * std::exp(high) - 1) * 100};
}

void compare_two(const RunAnalysis& from, const RunAnalysis& to, std::vector<Comparison>& out) {
  const auto of_to = quantities(to);
  for (const Quantity& a : quantities(from)) {
    for (const Quantity& b : of_to) {
      if (a.name != b.name || a.value == 0) continue;
      Comparison c;
      c.from_run = from.run;
      c.to_run = to.run;
      c.from_specimen = from.specimen;
      c.to_specimen = to.specimen;
      c.quantity = a.name;
      c.from_value = a.value;
      c.to_value = b.value;
      c.increase_percent = (b.value / a.value - 1) * 100;
      add_interval(a, b, from.options.confidence, c);
      out.push_back(std::move(c));
    }
  }
}

}  // namespace

std::vector<Comparison> compare(std::span<const RunAnalysis> runs) {
  std::vector<Comparison> out;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    compare_two(runs[i - 1], runs[i], out);
    if (i > 1) compare_two(runs[0], runs[i], out);
  }
  return out;
}

}  // namespace lcrig
