// SPDX-License-Identifier: Apache-2.0
// Writes comparisons as text for the terminal and as JSON.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/comparison.hpp"
#include "base/text.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

json value_json(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? json(*value) : json(nullptr);
}

json ends_json(const std::optional<std::array<double, 2>>& v) {
  return v ? json::array({value_json((*v)[0]), value_json((*v)[1])}) : json(nullptr);
}

std::string value_text(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "-";
}

void append_line(std::string& out, const char* what, const std::string& words) {
  if (!words.empty()) out += fmt::format("    {}{}\n", what, printable(words, 1000));
}

}  // namespace

json to_json(const Comparison& c) {
  return {{"from_run", c.from_run},
          {"to_run", c.to_run},
          {"from_specimen", c.from_specimen},
          {"to_specimen", c.to_specimen},
          {"quantity", c.quantity},
          {"from_value", value_json(c.from_value)},
          {"to_value", value_json(c.to_value)},
          {"increase_percent", value_json(c.increase_percent)},
          {"standard_error_percent", value_json(c.standard_error_percent)},
          {"interval_percent", ends_json(c.interval_percent)},
          {"ratio", ends_json(c.ratio)},
          {"refused", c.refused.empty() ? json(nullptr) : json(c.refused)},
          {"remedy", c.remedy},
          {"converted", c.converted},
          {"differences", c.differences},
          {"not_included", c.not_included},
          {"shared", c.shared},
          {"not_shared", c.not_shared},
          {"verdict", c.verdict},
          {"remark", c.remark()}};
}

std::string to_text(const std::vector<Comparison>& comparisons) {
  std::string out =
      "Comparison (each run with the one before it and with the first; an error cancels only "
      "where\n"
      "both runs prove that they share its source)\n";
  for (const Comparison& c : comparisons) {
    out += fmt::format("  run {} -> {}  {:<24} {} -> {}", c.from_run, c.to_run, c.quantity,
                       value_text(c.from_value), value_text(c.to_value));
    if (c.increase_percent) out += fmt::format("  {:+.2f} %", *c.increase_percent);
    if (c.interval_percent) {
      out +=
          fmt::format("  [{:+.2f}, {:+.2f}]", (*c.interval_percent)[0], (*c.interval_percent)[1]);
    }
    out += c.refused.empty() ? "\n" : "  not compared\n";
    append_line(out, "", c.refused);
    append_line(out, "to compare them: ", c.remedy);
    append_line(out, "", c.converted);
    for (const std::string& d : c.differences) append_line(out, "", d);
    append_line(out, "", c.not_included_text());
    append_line(out, "same: ", fmt::format("{}", fmt::join(c.shared, ", ")));
    append_line(out, "not proven the same: ", fmt::format("{}", fmt::join(c.not_shared, ", ")));
  }
  return out;
}

std::string verdicts_text(const std::vector<Comparison>& comparisons) {
  std::string out;
  for (const Comparison& c : comparisons) out += printable(c.verdict, 1000) + "\n";
  return out;
}

}  // namespace lcrig
