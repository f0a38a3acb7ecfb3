// SPDX-License-Identifier: Apache-2.0
// Facts about a run that every exported table needs. Private to export.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/align.hpp"
#include "analysis/csv.hpp"
#include "analysis/export.hpp"
#include "storage/runs.hpp"

namespace lcrig {

struct Column {
  std::string_view name, type, unit, description;  // type: Frictionless
};

// A value that holds from an instant on.
struct Since {
  std::int64_t mono_ns = 0;
  double value = 0;
};

// Where the digits of computed values end, as powers of ten in SI: one behind the last digit that
// any sample of the run has, so that rounding adds nothing to what the reading itself leaves open.
struct DigitEnds {
  int force_N = -9, travel_m = -12, pressure_Pa = -6;
};

struct ExportContext {
  std::int64_t id = 0;
  RunRow run;
  std::int64_t start_ns = 0;  // monotonic
  std::optional<double> area_m2;  // of the probe
  bool hold_force = false;  // dead weights: a sample is valid until the next
  DigitEnds ends;
  DeviceClock clock;
  WindowBefore before;  // of readings
  std::vector<Since> contacts;  // travel, m
  std::vector<Since> frequencies;  // Hz
  std::vector<Column> value_columns;  // of the functions that the run used, as lab units
  std::vector<int> value_powers;  // decimal shift of each
  std::string value_sql;  // ", capacitance_F, dissipation"
};
Result<ExportContext> load_context(const Database& db, std::int64_t run);

std::vector<Column> columns_of(const ExportContext& context, Layout layout);
Result<> write_layout(const Database& db, const ExportContext& context, Layout layout,
                      CsvWriter& out);
// `chain`: nullptr while it is not known.
std::string data_package(const ExportContext& context, const RunListing& listing,
                         const std::string& license, const ChainReport* chain);

}  // namespace lcrig
