// SPDX-License-Identifier: Apache-2.0
// Facts about a run that every exported table needs. Private to the export.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/align.hpp"
#include "analysis/csv.hpp"
#include "analysis/export.hpp"
#include "storage/proof.hpp"
#include "storage/runs.hpp"

namespace lcrig {

struct Column {
  std::string_view name, type, unit, description;  // type: as Frictionless calls it
};

// A value that is valid from an instant on.
struct Since {
  std::int64_t mono_ns = 0;
  double value = 0;
};

// The places to which computed values are rounded, as powers of ten in SI: one behind the last
// digit of any sample of the run, so that rounding adds nothing to the resolution of a reading.
struct DigitEnds {
  int force_N = -9, travel_m = -12, pressure_Pa = -6;
};

struct ExportContext {
  std::int64_t id = 0;
  RunRow run;
  std::int64_t start_ns = 0;  // monotonic
  std::optional<double> area_m2;  // of the probe
  bool hold_force = false;  // dead weights: a sample is valid until the next one
  DigitEnds ends;
  DeviceClock clock;
  Proof proof;  // of the readings
  WindowBefore before;  // how long before its request a reading began
  std::vector<Since> contacts;  // travel, m
  std::vector<Since> frequencies;  // Hz
  std::vector<Column> value_columns;  // columns for the functions that the run used, in lab units
  std::vector<int> value_powers;  // decimal shift of each
  std::string value_sql;  // the matching SQL, as ", capacitance_F, dissipation"
};
Result<ExportContext> load_context(const Database& db, std::int64_t run);

std::vector<Column> columns_of(const ExportContext& context, Layout layout);
Result<> write_layout(const Database& db, const ExportContext& context, Layout layout,
                      CsvWriter& out);
// Makes datapackage.json. `chain`: nullptr while the chain has not been checked.
std::string data_package(const ExportContext& context, const RunListing& listing,
                         const std::string& license, const ChainReport* chain);

}  // namespace lcrig
