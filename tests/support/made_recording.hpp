// SPDX-License-Identifier: Apache-2.0
// Recordings that a test makes up, so that it knows the truth behind them: loadings whose
// capacitance follows the force without hysteresis, written as the two files of `replay:DIR`.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace lcrig::support {

// One of the two files as rows of text cells. Times are kept as numbers, so that a test can shift
// them.
struct MadeFile {
  std::string header;
  struct Row {
    double t_s = 0;
    std::string others;  // the cells behind the time
  };
  std::vector<Row> rows;
  int decimals = 4;  // of the times

  std::string text() const {
    std::string out = header + "\n";
    for (const Row& row : rows) out += fmt::format("{:.{}f},{}\n", row.t_s, decimals, row.others);
    return out;
  }
  void shift(double by_s) {
    for (Row& row : rows) row.t_s += by_s;
  }
};

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
}

// Triangles of force with rests between them.
struct MadeRecording {
  double window_s = 0.065;  // in which the meter measures one reading; it measures all the time
  double sample_s = 0.01;
  double rest_s = 3, branch_s = 2, peak_N = 10;
  int loadings = 6;
  double noise_F = 1e-16;
  double zero_F = 3.6e-12, slope_F_per_N = 20e-15;
  std::uint64_t seed = 1;

  double period_s() const { return rest_s + 2 * branch_s; }
  double duration_s() const { return loadings * period_s() + rest_s; }
  double force_N(double t_s) const {
    if (t_s < 0 || t_s >= loadings * period_s()) return 0;
    const double x = (std::fmod(t_s, period_s()) - rest_s) / branch_s;
    return x <= 0 ? 0 : peak_N * (x < 1 ? x : 2 - x);
  }
  double capacitance_F(double t_s) const { return zero_F + slope_F_per_N * force_N(t_s); }
  // Mean over the window that ends at `end_s`.
  double reading_F(double end_s) const {
    constexpr int kPoints = 20;
    double sum = 0;
    for (int i = 0; i < kPoints; ++i) {
      sum += capacitance_F(end_s - window_s * (i + 0.5) / kPoints);
    }
    return sum / kPoints;
  }

  // Times of readings: those of arrival, or (`of_middle`) the middle of the window. No two readings
  // in a row are alike, because a meter that repeats its value measured nothing new.
  MadeFile lcr(bool of_middle = false) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, noise_F);
    MadeFile out;
    out.header = of_middle ? "t_middle_s,Cp_F,Rp_ohm" : "t_s,Cp_F,Rp_ohm";
    for (std::int64_t i = 1; static_cast<double>(i) * window_s < duration_s(); ++i) {
      const double end_s = static_cast<double>(i) * window_s;
      std::string cells;
      do {
        cells = fmt::format("{:.5e},9.1e7", reading_F(end_s) + noise(random));
      } while (!out.rows.empty() && out.rows.back().others == cells);
      out.rows.push_back({of_middle ? end_s - window_s / 2 : end_s, cells});
    }
    return out;
  }
  MadeFile frame() const {
    std::mt19937_64 random(seed + 1);
    std::normal_distribution<double> noise(0, 1e-3);
    MadeFile out;
    out.header = "t_s,travel_mm,force_N";
    for (std::int64_t i = 0; static_cast<double>(i) * sample_s < duration_s(); ++i) {
      const double t_s = static_cast<double>(i) * sample_s, force = force_N(t_s);
      out.rows.push_back({t_s, fmt::format("{:.4f},{:.4f}", force * 1e-2, force + noise(random))});
    }
    return out;
  }
};

}  // namespace lcrig::support
