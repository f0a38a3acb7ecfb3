// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/decimal.hpp"
#include "daemon/rig/recorded_table.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kArrival = "t_s", kMiddle = "t_middle_s";
// One file may start or end this much outside of the other and is played all the same: less than
// the second after which the driver calls a silent meter lost.
constexpr double kAlone_s = 0.5;

Result<> load_readings(const std::string& path, Recording& out) {
  RecordedTable table(path, "t_s (or t_middle_s), Cp_F, Rp_ohm");
  if (auto r = table.open(); !r) return r;
  auto middle = table.has(kMiddle);
  if (!middle) return fail(middle.error());
  auto arrival = table.has(kArrival);
  if (!arrival) return fail(arrival.error());
  if (*middle && *arrival) {
    return fail(Errc::invalid_request,
                "{}:1: both `{}` and `{}`, so it is not clear which times are meant: keep one of "
                "the columns",
                path, kArrival, kMiddle);
  }
  out.of_middle = *middle;
  const std::array names{*middle ? kMiddle : kArrival, std::string_view("Cp_F"),
                         std::string_view("Rp_ohm")};
  return table.read(names, [&out](std::span<const double> v) {
    out.readings.push_back(RecordedReading(v[0], v[1], v[2]));
  });
}

Result<> load_samples(const std::string& path, Recording& out) {
  constexpr std::array<std::string_view, 3> kNames{"t_s", "travel_mm", "force_N"};
  RecordedTable table(path, "t_s, travel_mm, force_N");
  if (auto r = table.open(); !r) return r;
  return table.read(kNames, [&out](std::span<const double> v) {
    out.samples.push_back(RecordedSample(v[0], shift_decimal(v[1], -3), v[2]));
  });
}

struct FileSpan {
  double from_s = 0, to_s = 0;
};

template <class Row>
FileSpan span_of(const std::vector<Row>& rows) {
  return {rows.front().t_s, rows.back().t_s};
}

// Removes the rows that lie outside of the other file. Returns their number.
template <class Row>
std::size_t keep_within(std::vector<Row>& rows, const FileSpan& other) {
  return std::erase_if(rows, [&other](const Row& row) {
    return row.t_s < other.from_s - kAlone_s || row.t_s > other.to_s + kAlone_s;
  });
}

// To a microsecond, so that an epoch time, which has no finer digits, gives the same instants as
// one that counts from 0.
template <class Row>
void shift(std::vector<Row>& rows, double zero_s) {
  for (Row& row : rows) row.t_s = std::round((row.t_s - zero_s) * 1e6) / 1e6;
}

Result<> require_rows(const std::string& directory, const Recording& r) {
  if (!r.readings.empty() && !r.samples.empty()) return {};
  return fail(Errc::invalid_request, "{}/{}: no rows below the header; nothing can be played",
              directory, r.readings.empty() ? "lcr.csv" : "frame.csv");
}

// Puts both on one axis, which starts where both have rows.
Result<> join(const std::string& directory, Recording& r) {
  const FileSpan lcr = span_of(r.readings), frame = span_of(r.samples);
  if (lcr.from_s > frame.to_s || frame.from_s > lcr.to_s) {
    return fail(Errc::invalid_request,
                "{}: lcr.csv has times from {} to {} s and frame.csv from {} to {} s: they do not "
                "overlap; both must count from the same zero, so add the difference to the times "
                "of one of them",
                directory, lcr.from_s, lcr.to_s, frame.from_s, frame.to_s);
  }
  const std::size_t readings = keep_within(r.readings, frame);
  const std::size_t samples = keep_within(r.samples, lcr);
  if (auto good = require_rows(directory, r); !good) return good;
  r.zero_s = std::min(r.readings.front().t_s, r.samples.front().t_s);
  const double end_s = std::max(r.readings.back().t_s, r.samples.back().t_s);
  r.words = fmt::format(
      "played from {} to {} s of the recording's clock; the time of a reading is {}", r.zero_s,
      end_s, r.of_middle ? "the middle of its window" : "its arrival, the end of its window");
  r.not_played = readings + samples;
  if (r.not_played > 0) {
    r.words += fmt::format(
        "; not played, because the other file has nothing at that time: {} readings, {} samples of "
        "the frame",
        readings, samples);
  }
  shift(r.readings, r.zero_s);
  shift(r.samples, r.zero_s);
  return {};
}

}  // namespace

double Recording::duration_s() const {
  const double lcr = readings.empty() ? 0 : readings.back().t_s;
  return std::max(lcr, samples.empty() ? 0 : samples.back().t_s);
}

Result<Recording> load_recording(const std::string& directory) {
  Recording out;
  if (auto r = load_readings(directory + "/lcr.csv", out); !r) return fail(r.error());
  if (auto r = load_samples(directory + "/frame.csv", out); !r) return fail(r.error());
  if (auto r = require_rows(directory, out); !r) return fail(r.error());
  if (auto r = join(directory, out); !r) return fail(r.error());
  return out;
}

}  // namespace lcrig
