// SPDX-License-Identifier: Apache-2.0
// Writes one long run, to measure `lcrig analyze` and `lcrig export` at scale:
//
//   big_run_bench FILE FRAME_SAMPLES LCR_READINGS
//   /usr/bin/time -v lcrig analyze last --db FILE --json > /dev/null
//   /usr/bin/time -v lcrig export last --db FILE -o - --layout frame > a.csv
//   /usr/bin/time -v sqlite3 -csv FILE "SELECT ... FROM frame_sample ..." > b.csv
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string_view>

#include "storage/database.hpp"
#include "storage/runs.hpp"

namespace {

using namespace lcrig;

void must(const Result<>& r) {
  if (!r) throw std::runtime_error(r.error().what);
}

constexpr double kSample_s = 0.02;
constexpr double kCycle_s = 40, kPeak_N = 1;

// A triangle of force, then rest for the other half of the cycle.
double force_at(double t_s) {
  const double x = std::fmod(t_s, kCycle_s) / kCycle_s;
  return x < 0.25 ? 4 * x * kPeak_N : x < 0.5 ? (2 - 4 * x) * kPeak_N : 0;
}

// Instruments send few digits, so values are rounded.
double rounded(double value, double per_unit) {
  return std::round(value * per_unit) / per_unit;
}

std::int64_t ns(double t_s) {
  return 1'000'000'000 + std::llround(t_s * 1e9);
}

void write_samples(const Database& db, std::int64_t run, std::int64_t count) {
  auto s = db.prepare("INSERT INTO frame_sample VALUES (?, ?, ?, ?, ?, ?, ?, 0)").value();
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0, 5e-4);
  for (std::int64_t i = 0; i < count; ++i) {
    const double t = kSample_s * static_cast<double>(i);
    const double force = rounded(force_at(t) + noise(random), 1e4);
    s.bind(0, run);
    s.bind(1, i + 1);
    s.bind(2, ns(t + 0.003));
    s.bind(3, i + 1);
    s.bind(4, rounded(t, 1e3));
    s.bind(5, force);
    s.bind(6, rounded(3.2e-3 + 1e-5 * force, 1e7));
    must(s.run());
  }
}

void write_readings(const Database& db, std::int64_t run, std::int64_t count, double end_s) {
  auto s = db.prepare(
                 "INSERT INTO lcr_reading (run_id, seq, asked_mono_ns, first_byte_mono_ns,"
                 " last_byte_mono_ns, step_id, repeat, fresh, flags, function, status,"
                 " capacitance_F, dissipation) VALUES (?, ?, ?, ?, ?, 'load', ?, 1, 0, 'Cp-D',"
                 " 'OUT ,AUX-NG,NG', ?, 0.00413)")
               .value();
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise(0, 3e-15);
  for (std::int64_t i = 0; i < count; ++i) {
    const double t = end_s * static_cast<double>(i) / static_cast<double>(count);
    s.bind(0, run);
    s.bind(1, i + 1);
    s.bind(2, ns(t));
    s.bind(3, ns(t + 0.01));
    s.bind(4, ns(t + 0.011));
    s.bind(5, static_cast<std::int64_t>(t / kCycle_s) + 1);
    s.bind(6, rounded(3.65e-12 + 4.2e-13 * force_at(t + 0.005) + noise(random), 1e17));
    must(s.run());
  }
}

std::int64_t count_of(std::string_view text) {
  std::int64_t out = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), out);
  if (r.ec != std::errc() || out < 0) throw std::invalid_argument(std::string(text));
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "big_run_bench FILE FRAME_SAMPLES LCR_READINGS\n");
    return 2;
  }
  const std::int64_t samples = count_of(argv[2]), readings = count_of(argv[3]);
  const auto db = lcrig::open_read_write(argv[1]).value();
  must(db.execute("PRAGMA synchronous = OFF"));
  lcrig::RunRow row;
  row.protocol_name = "big";
  row.probe_diameter_m = 0.004;
  row.started = lcrig::MonoTime(std::chrono::seconds(1));
  row.lcr_settings_json =
      R"({"frequency_Hz":20000,"level_V":1,"aperture":"fast","average":1,"trigger":"bus"})";
  const auto run = lcrig::insert_run(db, row).value();
  const double end_s = kSample_s * static_cast<double>(samples);
  must(db.execute("BEGIN"));
  write_samples(db, run, samples);
  write_readings(db, run, readings, end_s);
  must(db.execute("COMMIT"));
  lcrig::RunEnd end;
  end.ended = row.started + lcrig::from_seconds(end_s);
  must(lcrig::insert_run_end(db, run, end));
  fmt::print("run {}: {} samples, {} readings\n", run, samples, readings);
}
