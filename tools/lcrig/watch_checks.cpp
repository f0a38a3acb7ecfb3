// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/watch_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "protocols/checks/check.hpp"
#include "protocols/rig/constants.hpp"

namespace lcrig::cli {

namespace {

using Row = std::vector<std::string>;

std::string markdown(const std::vector<Row>& rows) {
  Row::size_type columns = rows.front().size();
  std::vector<std::size_t> width(columns, 3);
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < columns; ++i) width[i] = std::max(width[i], row[i].size());
  }
  std::string out;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t i = 0; i < columns; ++i) out += fmt::format("| {:<{}} ", rows[r][i], width[i]);
    out += "|\n";
    if (r > 0) continue;
    for (std::size_t i = 0; i < columns; ++i) out += fmt::format("| {:-<{}} ", "", width[i]);
    out += "|\n";
  }
  return out;
}

std::string words(Response response) {
  std::string out(to_string(response));
  std::ranges::replace(out, '_', ' ');
  return out;
}

}  // namespace

std::string checks_text() {
  std::vector<Row> rows{{"check", "applies while", "looks at", "then in doubt", "response"}};
  for (const Check& c : all_checks()) {
    rows.push_back({std::string(c.name), std::string(c.when.words), std::string(c.looks_at),
                    std::string(to_string(c.doubt)), words(c.response)});
  }
  std::vector<Row> constants{{"constant", "value", "unit", "origin"}};
  for (const Constant* c : kConstants) {
    constants.push_back({std::string(c->name), fmt::format("{:.6g}", c->value),
                         std::string(c->unit), std::string(c->origin)});
  }
  return markdown(rows) + "\n" + markdown(constants);
}

nlohmann::json checks_json() {
  nlohmann::json checks = nlohmann::json::array(), constants = nlohmann::json::array();
  for (const Check& c : all_checks()) {
    checks.push_back({{"check", c.name},
                      {"applies", c.when.words},
                      {"looks_at", c.looks_at},
                      {"doubt", to_string(c.doubt)},
                      {"response", to_string(c.response)},
                      {"event", to_string(c.event)}});
  }
  for (const Constant* c : kConstants) {
    constants.push_back(
        {{"constant", c->name}, {"value", c->value}, {"unit", c->unit}, {"origin", c->origin}});
  }
  return {{"checks", checks}, {"constants", constants}};
}

}  // namespace lcrig::cli
