// SPDX-License-Identifier: Apache-2.0
// A run of any length whose every value is known in integers. One SQL statement for each table
// stores it. For tests/scale.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>

#include "base/decimal.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace lcrig {

// There are nineteen samples of the frame for each reading. Cycles take 40 s: 20 s of rest, then a
// triangle to 1 N. The specimen has a knee at 0.4 N: 800 fF/N below, 380 fF/N above.
struct LongRun {
  static constexpr std::int64_t kRatio = 19;
  static constexpr std::int64_t kSample_ms = 20, kReading_ms = kRatio * kSample_ms;
  static constexpr std::int64_t kDelay_ms = 3;  // shortest delay; every third sample has it
  static constexpr std::int64_t kMiddle_ms = 5;  // middle of a reading's window
  static constexpr std::int64_t kContact_ms = 19'000, kContact_pm = 3'200'000'000;
  static constexpr double kDiameter_m = 0.004;
  static constexpr double kArea_m2 = std::numbers::pi / 4 * kDiameter_m * kDiameter_m;
  static constexpr double kLow_fF_N = 800, kHigh_fF_N = 380, kC0_pF = 3.65;
  static constexpr double kPeak_fF = 0.4 * kLow_fF_N + 0.6 * kHigh_fF_N;

  explicit LongRun(std::int64_t rows)
      : readings(rows / (kRatio + 1)), samples(rows - rows / (kRatio + 1)) {}

  std::int64_t readings, samples;

  static std::int64_t force_uN(std::int64_t device_ms) {
    const std::int64_t t = device_ms % 40'000;
    return t < 20'000 ? 0 : 100 * (t < 30'000 ? t - 20'000 : 40'000 - t);
  }
  static std::int64_t travel_nm(std::int64_t device_ms) {
    return 3'200'000 + force_uN(device_ms) / 100;
  }
  static std::int64_t received_ms(std::int64_t i) {
    return kSample_ms * i + kDelay_ms + 7 * (i % 3);
  }
  // Force in the middle of the window of reading j.
  static std::int64_t force_at_uN(std::int64_t j) {
    return force_uN(kReading_ms * j + kMiddle_ms - kDelay_ms);
  }
  // Capacitance of reading j, with up to 10 fF of scatter to either side.
  static std::int64_t capacitance_aF(std::int64_t j) {
    const std::int64_t force = force_at_uN(j);
    const std::int64_t curve =
        force < 400'000 ? force / 10 * 8 : 320'000 + (force - 400'000) / 50 * 19;
    const std::int64_t scatter = j * 2654435761 % 4294967296 * (j % 65521 + 1) % 1048573 % 20001;
    return 3'650'000 + curve + scatter - 10'000;
  }

  // Line i of the exported frame, from 0.
  static std::string frame_line(std::int64_t i) {
    const std::int64_t device_ms = kSample_ms * i, travel = travel_nm(device_ms);
    // Forces are 1 mN apart, which is 80 Pa. One digit behind that is 1 Pa.
    const double pressure_Pa =
        std::round(static_cast<double>(force_uN(device_ms)) / 1e6 / kArea_m2);
    const bool touched = received_ms(i) >= kContact_ms;
    const std::string gap = touched ? shifted(kContact_pm - 1000 * travel, -9) : "";
    return fmt::format("{},{},{},{},{},{},{},{},", i + 1, shifted(device_ms + received_ms(0), -3),
                       shifted(received_ms(i), -3), shifted(device_ms, -3),
                       shifted(force_uN(device_ms), -6), shifted(travel, -6), gap,
                       pressure_Pa / 1000);
  }

  // Returns the run's number.
  std::int64_t store(const Database& db) const {
    must(db.execute("PRAGMA foreign_keys = OFF; PRAGMA synchronous = OFF"));
    must(db.execute("PRAGMA journal_mode = OFF"));
    RunRow row;
    row.protocol_name = "long";
    row.probe_diameter_m = kDiameter_m;
    row.started = MonoTime(std::chrono::seconds(1));
    row.lcr_settings_json =
        R"({"frequency_Hz":20000,"level_V":1,"aperture":"fast","average":1,"trigger":"bus"})";
    const std::int64_t run = insert_run(db, row).value();
    must(db.execute(shape_sql()));
    must(db.execute(frame_sql(run)));
    must(db.execute(reading_sql(run)));
    must(db.execute(
        fmt::format("INSERT INTO event VALUES ({}, 1, 1000000000 + {} * 1000000, 'contact', 's',"
                    " '{{\"travel_m\":0.0032,\"force_N\":0.02,\"rest_force_N\":0}}')",
                    run, kContact_ms)));
    RunEnd end;
    end.ended = row.started + std::chrono::milliseconds(kSample_ms * samples);
    must(insert_run_end(db, run, end));
    must(db.execute("PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON"));
    return run;
  }

 private:
  static std::string shifted(std::int64_t value, int power) {
    std::string out;
    append_decimal_shift(out, value, power);
    return out;
  }
  static void must(const Result<>& r) {
    if (!r) throw std::runtime_error(r.error().what);
  }
  // The same integers as above, in SQL. `t` is in ms on the frame's clock.
  static constexpr const char* kForceSql =
      "CASE WHEN t % 40000 < 20000 THEN 0 WHEN t % 40000 < 30000 THEN 100 * (t % 40000 - 20000)"
      " ELSE 100 * (40000 - t % 40000) END";
  // One cycle, which is then repeated. This is a third faster than counting the rows.
  static std::string shape_sql() {
    return fmt::format(
        "DROP TABLE IF EXISTS temp.shape; CREATE TEMP TABLE shape AS WITH RECURSIVE n(k) AS (SELECT"
        " 0 UNION ALL SELECT k + 1 FROM n WHERE k + 1 < 40000 / {1}), f AS (SELECT k, {1} * k AS t"
        " FROM n), g AS (SELECT k, {0} AS force FROM f) SELECT k, force / 1000000.0 AS force,"
        " (3200000 + force / 100) / 1000000000.0 AS travel FROM g",
        kForceSql, kSample_ms);
  }
  std::string frame_sql(std::int64_t run) const {
    return fmt::format(
        "INSERT INTO frame_sample WITH RECURSIVE c(first) AS (SELECT 0 UNION ALL SELECT first +"
        " 40000 / {2} FROM c WHERE first + 40000 / {2} < {1}) SELECT {0}, first + k + 1, 1000000000"
        " + ({2} * (first + k) + {3} + 7 * ((first + k) % 3)) * 1000000, first + k + 1,"
        " {2} * (first + k) / 1000.0, force, travel, 0 FROM c CROSS JOIN shape"
        " WHERE first + k < {1}",
        run, samples, kSample_ms, kDelay_ms);
  }
  std::string reading_sql(std::int64_t run) const {
    return fmt::format(
        "INSERT INTO lcr_reading (run_id, seq, asked_mono_ns, first_byte_mono_ns,"
        " last_byte_mono_ns, step_id, repeat, fresh, flags, function, status, capacitance_F,"
        " dissipation) WITH RECURSIVE n(j) AS (SELECT 0 UNION ALL SELECT j + 1 FROM n"
        " WHERE j + 1 < {1}), f AS (SELECT j, {3} * j AS asked, {3} * j + {4} - {5} AS t FROM n),"
        " g AS (SELECT j, asked, {2} AS force FROM f), h AS (SELECT j, asked, 1000000000 + asked *"
        " 1000000 AS ns, CASE WHEN force < 400000 THEN force / 10 * 8 ELSE 320000 + (force -"
        " 400000) / 50 * 19 END AS curve, j * 2654435761 % 4294967296 * (j % 65521 + 1) % 1048573"
        " % 20001 AS scatter FROM g) SELECT {0}, j + 1, ns, ns + 2000000 * {4}, ns + 2000000 * {4},"
        " 's', 0, 1, 0, 'Cp-D', 'OK', (3650000 + curve + scatter - 10000) / 1000000000000000000.0,"
        " 0.004 FROM h",
        run, readings, kForceSql, kReading_ms, kMiddle_ms, kDelay_ms);
  }
};

}  // namespace lcrig
