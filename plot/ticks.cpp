// SPDX-License-Identifier: Apache-2.0
#include "plot/ticks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace lcrig::plot {

namespace {

std::string with_minus(std::string text) {
  if (text.starts_with('-')) text.replace(0, 1, "−");
  return text;
}

double round_step(double smallest) {
  const double power = std::pow(10, std::floor(std::log10(smallest)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
    if (factor * power >= smallest * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::string label_of(double value, double step, double largest) {
  if (std::abs(value) < step / 2) return "0";
  if (largest >= 1e7 || step < 1e-6) {
    const int digits = static_cast<int>(std::ceil(std::log10(largest / step))) + 1;
    return with_minus(fmt::format("{:.{}g}", value, std::clamp(digits, 1, 17)));
  }
  int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const double units = step * std::pow(10, decimals);
  if (std::abs(units - std::round(units)) > 1e-6) ++decimals;  // 2.5
  return with_minus(fmt::format("{:.{}f}", value, decimals));
}

std::string superscript(int n) {
  constexpr std::string_view kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = n < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(n))) out += kDigits[c - '0'];
  return out;
}

std::string power_label(int exponent) {
  if (exponent < -4 || exponent > 5) return "10" + superscript(exponent);
  return fmt::format("{:.{}f}", std::pow(10, exponent), std::max(0, -exponent));
}

}  // namespace

Ticks linear_ticks(double low, double high, int most) {
  Ticks out;
  double step = round_step((high - low) / std::max(most, 2));
  double first = 0, last = 0;
  for (int i = 0; i < 3; ++i) {  // if the ends add one tick too many, try the next step
    first = std::ceil(low / step - 1e-9);
    last = std::floor(high / step + 1e-9);
    if (last - first + 1 <= most) break;
    step = round_step(step * 1.5);
  }
  const double largest = std::max(std::abs(low), std::abs(high));
  for (double k = first; k <= last && out.at.size() < 100; ++k) {
    out.at.push_back(k * step);
    out.labels.push_back(label_of(k * step, step, largest));
  }
  return out;
}

Ticks log_ticks(double low, double high, int most) {
  const int first = static_cast<int>(std::ceil(std::log10(low) - 1e-9));
  const int last = static_cast<int>(std::floor(std::log10(high) + 1e-9));
  Ticks out;
  const auto inside = [&](double v) { return v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9); };
  const bool few = std::log10(high / low) < 2;
  const int stride = few ? 1 : std::max(1, (last - first + most) / std::max(most, 1));
  for (int k = first - 1; k <= last; ++k) {
    for (int m = 1; m <= 9; ++m) {
      const double v = m * std::pow(10, k);
      if (!inside(v)) continue;
      if ((m == 1 && (k - first) % stride == 0) || (few && (m == 2 || m == 5))) {
        out.at.push_back(v);
        const int decimals = std::max(0, -k);
        out.labels.push_back(m == 1 ? power_label(k) : fmt::format("{:.{}f}", v, decimals));
      } else if (last - first <= 6 || m == 1) {
        out.minor.push_back(v);
      }
    }
  }
  return out.at.size() < 2 ? linear_ticks(low, high, most) : out;
}

}  // namespace lcrig::plot
