// SPDX-License-Identifier: Apache-2.0
#include "analysis/report/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/analysis_text.hpp"
#include "base/program_version.hpp"
#include "plot/text.hpp"

namespace lcrig::report {

namespace {

// The page loads nothing from elsewhere. A4 with margins is 680 px wide.
constexpr std::string_view kStyle = R"(
@page { size: A4; margin: 15mm; }
* { box-sizing: border-box; }
body { font: 14.5px/1.45 Helvetica, Arial, sans-serif; color: #1c1c1c; background: #fff;
  max-width: 900px; margin: 0 auto; padding: 20px 24px 60px; }
h1 { font-size: 24px; line-height: 1.25; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 18px; margin: 34px 0 8px; padding-bottom: 3px; border-bottom: 2px solid #333;
  break-after: avoid; }
h3 { font-size: 15px; margin: 20px 0 6px; break-after: avoid; overflow-wrap: anywhere; }
p { margin: 6px 0; }
p.lead { color: #444; overflow-wrap: anywhere; }
p.small, ul.small { font-size: 12.5px; color: #444; }
.mark { border: 3px double #1c1c1c; padding: 8px 12px; margin: 12px 0; font-weight: bold;
  background: #f2f2f2; break-inside: avoid; }
.mark span { font-weight: normal; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 8px 0 12px; font-size: 13px; }
th, td { padding: 3px 9px 3px 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid #d5d5d5; overflow-wrap: break-word; }
table.facts td { overflow-wrap: anywhere; }
h4 { font-size: 13.5px; margin: 16px 0 4px; break-after: avoid; overflow-wrap: anywhere; }
thead th { border-bottom: 1.5px solid #333; vertical-align: bottom; overflow-wrap: normal; }
tbody th { font-weight: normal; }
td.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
tr, figure { break-inside: avoid; }
figure { margin: 12px 0; }
svg { display: block; max-width: 100%; height: auto; }
pre { font: 11.5px/1.4 "DejaVu Sans Mono", Menlo, Consolas, monospace; white-space: pre-wrap;
  overflow-wrap: anywhere; background: #f6f6f6; border: 1px solid #ddd; padding: 8px; margin: 4px 0; }
td.hash, .hash { font: 11.5px/1.4 "DejaVu Sans Mono", Menlo, Consolas, monospace;
  overflow-wrap: anywhere; }
nav { font-size: 13px; margin: 10px 0 0; } nav a { margin-right: 14px; color: #0b3d91;
  white-space: nowrap; }
@media print { nav { display: none; } body { padding: 0; max-width: none; font-size: 12px; }
  table { font-size: 10.5px; } .wide { overflow: visible; } p.small, ul.small { font-size: 10.5px; }
  pre, .hash { font-size: 9.5px; } }
)";

int decimals_for(double step) {
  return std::clamp(-static_cast<int>(std::floor(std::log10(step) + 1e-12)), 0, 12);
}

std::string unsigned_zero(std::string digits) {
  const bool zero = digits.find_first_of("123456789") == std::string::npos;
  if (digits.starts_with('-')) digits.replace(0, 1, zero ? "" : "−");
  return digits;
}

Cell number_cell(std::string markup) {
  return {std::move(markup), Cell::Kind::number};
}

}  // namespace

std::string text(std::string_view words) {
  return plot::escape(words);
}

std::string plain_number(double value, std::optional<double> se) {
  if (!std::isfinite(value)) return value > 0 ? "∞" : value < 0 ? "−∞" : "–";
  const double size = std::abs(value);
  if (size >= 1e7 || (size > 0 && size < 1e-5)) return unsigned_zero(fmt::format("{:.3g}", value));
  if (se && std::isfinite(*se) && *se > 0) {
    return unsigned_zero(fmt::format("{:.{}f}", value, decimals_for(*se / 10)));
  }
  const int decimals = size > 0 ? decimals_for(size / 1000) : 0;
  return unsigned_zero(fmt::format("{:.{}f}", value, std::min(decimals, 8)));
}

Cell no_number() {
  return number_cell("–");
}

Cell number(double value, std::optional<double> se) {
  return number_cell(fmt::format("<data value='{}'>{}</data>", value, plain_number(value, se)));
}

Cell number(const std::optional<double>& value) {
  return value ? number(*value, std::optional<double>()) : no_number();
}

Cell number(std::int64_t value) {
  return number_cell(fmt::format("<data value='{0}'>{0}</data>", value));
}

Cell measured(double value, std::optional<double> se) {
  const Cell shown = number(value, se);
  return se && *se > 0 ? number_cell(shown + " ± " + number(*se, se)) : shown;
}

Cell measured(const Metric& metric) {
  if (!metric) return text(metric.reason.empty() ? "not measured" : metric.reason);
  return measured(metric.value(), metric.estimate->standard_error);
}

Cell interval(const std::optional<std::array<double, 2>>& ends, std::optional<double> se) {
  if (!ends) return no_number();
  return number_cell(number((*ends)[0], se) + " to " + number((*ends)[1], se));
}

std::string interval_head(double confidence) {
  return fmt::format("{:g} % interval<br/><small>for what this rig would show</small>",
                     confidence * 100);
}

std::string estimand_line(const std::string& estimand) {
  return estimand.empty() ? std::string() : "<br/><small>" + text(estimand) + "</small>";
}

std::string two_truths() {
  return paragraph(fmt::format("Interval: {}. Expanded uncertainty: {}.", kOfScatter, kOfAll),
                   "small");
}

Cell percent(double value) {
  return number_cell(fmt::format("<data value='{}'>{}{} %</data>", value, value >= 0 ? "+" : "",
                                 unsigned_zero(fmt::format("{:.1f}", value))));
}

std::string range_numbers(const PressureRange& range) {
  return fmt::format("{:g}–{:g}", range.from_kPa, range.to_kPa);
}

std::string range_name(const PressureRange& range) {
  return range_numbers(range) + " kPa";
}

Table::Table(std::initializer_list<std::string> heads) : Table(std::vector<std::string>(heads)) {}

Table::Table(const std::vector<std::string>& heads) {
  head_ = "<div class='wide'><table><thead><tr>";
  for (const auto& head : heads) head_ += "<th>" + head + "</th>";
  head_ += "</tr></thead><tbody>\n";
}

Table Table::of_facts() {
  Table table(std::vector<std::string>{});
  table.head_ = "<div class='wide'><table class='facts'><tbody>\n";
  return table;
}

Table& Table::row(const std::vector<Cell>& cells) {
  body_ += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0) {
      body_ += "<th>" + cells[i] + "</th>";
    } else {
      body_ += (cells[i].is_number() ? "<td class='n'>" : "<td>") + cells[i] + "</td>";
    }
  }
  body_ += "</tr>\n";
  ++rows_;
  return *this;
}

std::string Table::html() const {
  return head_ + body_ + "</tbody></table></div>\n";
}

std::string section(std::string_view id, std::string_view title, std::string_view body) {
  return fmt::format("<section id='{}'>\n<h2>{}</h2>\n{}</section>\n", id, title, body);
}

std::string paragraph(std::string_view markup, std::string_view kind) {
  return fmt::format("<p{}>{}</p>\n", kind.empty() ? "" : fmt::format(" class='{}'", kind), markup);
}

std::string page(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'/>\n"
      "<meta name='viewport' content='width=device-width, initial-scale=1'/>\n"
      "<meta name='generator' content='lcrig {}'/>\n<title>{}</title>\n<style>{}</style>\n</head>\n"
      "<body>\n{}</body>\n</html>\n",
      program_version(), text(title), kStyle, body);
}

}  // namespace lcrig::report
