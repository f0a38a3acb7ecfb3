// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/recording.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <span>
#include <string_view>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const auto comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// Reads the named columns of a CSV file without quotes, one callback per row.
class ColumnReader {
 public:
  ColumnReader(std::string path, std::vector<std::string> names)
      : path_(std::move(path)), names_(std::move(names)) {}

  Result<> read(const std::function<void(std::span<const double>)>& row) {
    std::ifstream file(path_);
    std::string line;
    if (!file || !std::getline(file, line)) {
      return fail(Errc::io, "{}: cannot be read; a replay bench needs lcr.csv and frame.csv",
                  path_);
    }
    if (auto ok = find_columns(line); !ok) return ok;
    double last_t = -INFINITY;
    for (int number = 2; std::getline(file, line); ++number) {
      if (trimmed(line).empty()) continue;
      if (auto ok = parse_row(line, number); !ok) return ok;
      if (values_[0] < last_t) {
        return fail(Errc::invalid_request, "{}:{}: time runs backwards", path_, number);
      }
      last_t = values_[0];
      row(values_);
    }
    return {};
  }

 private:
  Result<> find_columns(std::string_view header) {
    const auto cells = split(header);
    for (const std::string& name : names_) {
      const auto it = std::ranges::find(cells, name, trimmed);
      if (it == cells.end()) {
        return fail(Errc::invalid_request, "{}:1: no column `{}`", path_, name);
      }
      columns_.push_back(static_cast<std::size_t>(it - cells.begin()));
    }
    values_.resize(names_.size());
    return {};
  }

  Result<> parse_row(std::string_view line, int number) {
    const auto cells = split(line);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto text = columns_[i] < cells.size() ? trimmed(cells[columns_[i]]) : "";
      const auto value = number_from<double>(text);
      if (!value) {
        return fail(Errc::invalid_request, "{}:{}: column `{}` holds `{}`, expected a number",
                    path_, number, names_[i], text);
      }
      values_[i] = *value;
    }
    return {};
  }

  std::string path_;
  std::vector<std::string> names_;
  std::vector<std::size_t> columns_;
  std::vector<double> values_;
};

}  // namespace

double Recording::duration_s() const {
  const double lcr = readings.empty() ? 0 : readings.back().t_s;
  return std::max(lcr, samples.empty() ? 0 : samples.back().t_s);
}

Result<Recording> load_recording(const std::string& directory) {
  Recording recording;
  ColumnReader lcr(directory + "/lcr.csv", {"t_s", "Cp_F", "Rp_ohm"});
  auto read = lcr.read([&](std::span<const double> v) {
    recording.readings.push_back(RecordedReading(v[0], v[1], v[2]));
  });
  if (!read) return fail(read.error());
  ColumnReader frame(directory + "/frame.csv", {"t_s", "travel_mm", "force_N"});
  read = frame.read([&](std::span<const double> v) {
    recording.samples.push_back(RecordedSample(v[0], shift_decimal(v[1], -3), v[2]));
  });
  if (!read) return fail(read.error());
  if (recording.readings.empty()) {
    return fail(Errc::invalid_request, "{}/lcr.csv: no rows", directory);
  }
  return recording;
}

}  // namespace lcrig
