// SPDX-License-Identifier: Apache-2.0
#include "analysis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace lcrig {

namespace {

// A specimen, with its run where both are of one specimen.
std::string subject(const Comparison& c, bool from, const std::string& origin) {
  const std::string& specimen = from ? c.from_specimen : c.to_specimen;
  const std::int64_t run = from ? c.from_run : c.to_run;
  std::string out = specimen.empty() ? fmt::format("run {}", run) : specimen;
  if (!specimen.empty() && c.from_specimen == c.to_specimen) out += fmt::format(" in run {}", run);
  return origin.empty() ? out : fmt::format("{} ({})", out, origin);
}

// ", same probe, load cell not proven the same"
std::string sources(const Comparison& c) {
  std::string out;
  for (const ErrorSource source : {ErrorSource::probe, ErrorSource::cell, ErrorSource::meter}) {
    const auto word = to_string(source);
    const auto is_named = [word](const std::string& s) { return s.starts_with(word); };
    if (std::ranges::any_of(c.shared, is_named)) out += fmt::format(", same {}", word);
    if (std::ranges::any_of(c.not_shared, is_named)) {
      out += fmt::format(", {} not proven the same", word);
    }
  }
  return out;
}

std::string scope_text(const Comparison& c, const VerdictScope& scope) {
  std::string out = sources(c);
  if (scope.direction) {
    out += *scope.direction == Direction::up ? ", loading branch" : ", unloading branch";
  }
  if (!c.converted.empty()) out += ", " + c.converted;
  return out + fmt::format(" ({:g} %)", scope.confidence * 100);
}

}  // namespace

std::string ratio_text(double low, double high) {
  const double width = (high - low) / 2;
  const int digits = width > 0 && std::isfinite(width)
                         ? std::clamp(1 - static_cast<int>(std::floor(std::log10(width))), 0, 9)
                         : 6;
  const double step = std::pow(10.0, digits);
  return fmt::format("{:.{}f} to {:.{}f}", std::floor(low * step) / step, digits,
                     std::ceil(high * step) / step, digits);
}

std::string verdict_on(const Comparison& c, const VerdictScope& scope) {
  const std::string from = subject(c, true, scope.from_origin);
  const std::string to = subject(c, false, scope.to_origin);
  if (!c.ratio) {
    return fmt::format("no verdict on the {} of {} and {}: {}; to compare them: {}", c.quantity,
                       from, to, c.refused, c.remedy);
  }
  const std::string times = ratio_text((*c.ratio)[0], (*c.ratio)[1]);
  std::string out;
  if (scope.quantity == "sensitivity") {
    out = fmt::format("{} is {} times as sensitive as {} in {}", to, times, from, scope.where);
  } else {
    out = fmt::format("the {} of {}{} is {} times that of {}", scope.quantity, to,
                      scope.where.empty() ? "" : " at " + scope.where, times, from);
  }
  out += scope_text(c, scope);
  const bool resolved = (*c.ratio)[0] > 1 || (*c.ratio)[1] < 1;
  if (!resolved) out += ": no difference is resolved";
  add_remark(out, c.not_included_text());
  return out;
}

}  // namespace lcrig
