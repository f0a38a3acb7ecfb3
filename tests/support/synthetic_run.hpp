// SPDX-License-Identifier: Apache-2.0
// Builds a stored run row by row, for tests of the analysis that must know the truth behind it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "analysis/analysis.hpp"
#include "storage/database.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {

class SyntheticRun {
 public:
  static constexpr double kDiameter_m = 0.004;
  static double area_m2() { return std::numbers::pi / 4 * kDiameter_m * kDiameter_m; }

  SyntheticRun() {
    db_ = open_read_write(dir_.file("s.db")).value();
    row.protocol_name = "synthetic";
    row.specimen_name = "synthetic-1";
    row.probe_diameter_m = kDiameter_m;
    row.started = MonoTime(std::chrono::seconds(1));
    row.lcr_settings_json =
        R"({"function":"Cp-D","frequency_Hz":1000,"level_V":1,"aperture":"medium","average":1,)"
        R"("trigger":"bus","conversion_time_s":0.12})";
    // A power cut need not be survived here.
    static_cast<void>(db_.execute("PRAGMA synchronous = OFF"));
  }

  RunRow row;
  double t_s = 0;  // time of the next row
  double reading_s = 0.12;
  double frame_s = 0.02;

  void begin() {
    run_ = insert_run(db_, row).value();
    static_cast<void>(db_.execute("BEGIN"));
    reading_ = db_.prepare(
                      "INSERT INTO lcr_reading (run_id, seq, asked_mono_ns, first_byte_mono_ns,"
                      " last_byte_mono_ns, step_id, repeat, level, reading_index, fresh, flags,"
                      " function, status, capacitance_F, dissipation)"
                      " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'Cp-D', '', ?, 0.004)")
                   .value();
    sample_ = db_.prepare("INSERT INTO frame_sample VALUES (?, ?, ?, ?, NULL, ?, ?, ?)").value();
  }
  std::int64_t end(ExitStatus status = ExitStatus::success) {
    reading_ = Statement();
    sample_ = Statement();
    static_cast<void>(db_.execute("COMMIT"));
    RunEnd e;
    e.status = status;
    e.ended = row.started + from_seconds(t_s);
    EXPECT_TRUE(insert_run_end(db_, run_, e));
    return run_;
  }
  const Database& db() const { return db_; }
  std::int64_t run() const { return run_; }

  void event(const std::string& kind, const std::string& detail, const std::string& step = "s") {
    auto s = db_.prepare("INSERT INTO event VALUES (?, ?, ?, ?, ?, ?)").value();
    s.bind(0, run_);
    s.bind(1, ++events_);
    s.bind(2, ns(t_s));
    s.bind(3, kind);
    s.bind(4, step);
    s.bind(5, detail);
    EXPECT_TRUE(s.run());
  }
  void level(int repeat, int index, std::optional<double> target_kPa, int planned) {
    repeat_ = repeat;
    level_ = ++levels_;
    auto s = db_.prepare("INSERT INTO level VALUES (?, ?, ?, 'level', ?, ?, ?, ?, ?, ?)").value();
    s.bind(0, run_);
    s.bind(1, level_);
    s.bind(2, level_);
    s.bind(3, std::int64_t{repeat});
    s.bind(4, std::int64_t{index});
    if (target_kPa) {
      s.bind(5, *target_kPa * 1e3 * area_m2());
      s.bind(6, *target_kPa * 1e3);
    } else {
      s.bind_null(5);
      s.bind_null(6);
    }
    s.bind(7, std::int64_t{planned});
    s.bind(8, ns(t_s));
    EXPECT_TRUE(s.run());
    index_ = 0;
  }
  void end_level() { level_ = 0; }

  // Stores a reading that takes reading_s, and the frame samples beside it. `force_N` gives the
  // force at a time. nullopt means an overload.
  void reading(std::optional<double> capacitance_F, const std::function<double(double)>& force_N) {
    const double from = t_s;
    t_s += reading_s;
    frame_until(t_s, force_N);
    reading_.bind(0, run_);
    reading_.bind(1, ++readings_);
    reading_.bind(2, ns(from));
    reading_.bind(3, ns(t_s));
    reading_.bind(4, ns(t_s));
    reading_.bind(5, std::string_view(level_ > 0 ? "level" : "s"));
    reading_.bind(6, std::int64_t{repeat_});
    if (level_ > 0) {
      reading_.bind(7, level_);
      reading_.bind(8, ++index_);
    } else {
      reading_.bind_null(7);
      reading_.bind_null(8);
    }
    reading_.bind(9, std::int64_t{is_fresh ? 1 : 0});
    reading_.bind(10, flags | (capacitance_F ? 0 : 1));
    if (capacitance_F) {
      reading_.bind(11, *capacitance_F);
    } else {
      reading_.bind_null(11);
    }
    ASSERT_TRUE(reading_.run());
  }
  void reading(std::optional<double> capacitance_F, double force_N) {
    reading(capacitance_F, [force_N](double) { return force_N; });
  }
  // Stores the samples after the last one up to `until_s`.
  void frame_until(double until_s, const std::function<double(double)>& force_N) {
    for (; with_frame && frame_t_s_ <= until_s; frame_t_s_ += frame_s) {
      ++device_seq_;
      if (lost_frames > 0) {
        --lost_frames;
        continue;
      }
      const double force = force_N(frame_t_s_);
      sample_.bind(0, run_);
      sample_.bind(1, ++samples_);
      sample_.bind(2, ns(frame_t_s_));
      sample_.bind(3, device_seq_);
      sample_.bind(4, force);
      sample_.bind(5, travel_m(force));
      sample_.bind(6, std::int64_t{0});
      ASSERT_TRUE(sample_.run());
    }
  }
  bool with_frame = true;
  bool is_fresh = true;  // the next readings are; false: they repeat the one before
  std::int64_t flags = 0;  // flags of the next readings; storage/flags.hpp
  int lost_frames = 0;  // number of next samples that will be missing
  std::function<double(double)> travel_m = [](double force) { return 3e-3 + 1e-5 * force; };

  // The static experiment: a baseline, then repeats over the levels.
  struct Static {
    std::vector<double> kPa{10, 20, 30, 40, 50, 60, 70, 80, 90, 100};
    int repeats = 4, readings = 30;
    double noise_F = 44e-15;
    std::function<double(double)> capacitance_F = [](double pressure_kPa) {
      return 3.65e-12 + 6e-15 * pressure_kPa;
    };
    std::uint64_t seed = 1;
    int baseline = 100;
    // May change a reading. Arguments: level (from 1), reading (from 1), value.
    std::function<std::optional<double>(int, int, double)> spoil = [](int, int, double v) {
      return std::optional<double>(v);
    };
    bool targets = true;
    int touches = 0;  // touches of a search that slows down, before it reports the contact
  };
  void play(const Static& s) {
    std::mt19937_64 random(s.seed);
    std::normal_distribution<double> normal;
    const auto noisy = [&](double kPa) {
      return s.capacitance_F(kPa) + s.noise_F * normal(random);
    };
    for (int i = 0; i < s.baseline; ++i) reading(noisy(0), 0);
    for (int k = 0; k < s.touches; ++k) {
      const double touch_N = 0.02;
      for (int i = 0; i < 3; ++i) reading(noisy(touch_N / area_m2() * 1e-3), touch_N);
      for (int i = 0; i < 10; ++i) reading(noisy(0), 0);
    }
    t_s += 1;
    frame_until(t_s, [](double) { return 0.0; });
    event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
    for (int repeat = 1; repeat <= s.repeats; ++repeat) {
      int index = 0;
      for (const double kPa : s.kPa) {
        const double force = kPa * 1e3 * area_m2();
        t_s += 0.5;
        frame_until(t_s, [force](double) { return force; });
        level(repeat, ++index, s.targets ? std::optional(kPa) : std::nullopt, s.readings);
        for (int i = 1; i <= s.readings; ++i) {
          reading(s.spoil(static_cast<int>(level_), i, noisy(kPa)), force);
        }
        end_level();
      }
      for (int i = 0; i < 20; ++i) reading(noisy(0), 0);
    }
  }

  // The dynamic experiment: triangles of force with rests between them.
  struct Dynamic {
    int cycles = 5;
    double peak_N = 1, branch_s = 2, rest_s = 5;
    double noise_F = 10e-15;
    std::function<double(double kPa, bool up)> capacitance_F = [](double kPa, bool) {
      return 3.65e-12 + 2.15e-15 * kPa;
    };
    std::uint64_t seed = 1;
    double baseline_s = 20;
    bool anywhere = false;  // loading begins within a reading, at another place in each cycle
    int window_points = 1;  // a reading is the mean over this many instants of its window
  };
  void play(const Dynamic& d) {
    std::mt19937_64 random(d.seed);
    std::normal_distribution<double> normal;
    const auto rest = [&](double seconds) {
      for (const double until = t_s + seconds; t_s < until;) {
        reading(d.capacitance_F(0, true) + d.noise_F * normal(random), 0);
      }
    };
    rest(d.baseline_s);
    t_s += 1;
    frame_until(t_s, [](double) { return 0.0; });
    event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
    for (int k = 0; k < d.cycles; ++k) {
      const double begin = t_s + (d.anywhere ? reading_s * std::fmod(0.618 * k, 1) : 0);
      const auto force = [&](double t) {
        const double x = (t - begin) / d.branch_s;
        return std::max(0.0, d.peak_N * (x < 1 ? x : 2 - x));
      };
      while (t_s < begin + 2 * d.branch_s) {
        double mean_F = 0;
        for (int i = 0; i < d.window_points; ++i) {
          const double t = t_s + reading_s * (i + 0.5) / d.window_points;
          const double kPa = force(t) / area_m2() * 1e-3;
          mean_F += d.capacitance_F(kPa, t < begin + d.branch_s) / d.window_points;
        }
        reading(mean_F + d.noise_F * normal(random), force);
      }
      rest(d.rest_s);
    }
  }

 private:
  std::int64_t ns(double seconds) const {
    return row.started.time_since_epoch().count() + std::llround(seconds * 1e9);
  }
  TempDir dir_;
  Database db_;
  std::int64_t run_ = 0;
  Statement reading_, sample_;
  std::int64_t readings_ = 0, samples_ = 0, events_ = 0, levels_ = 0, level_ = 0, index_ = 0;
  std::int64_t device_seq_ = 0;
  double frame_t_s_ = 0;
  int repeat_ = 0;
};

}  // namespace lcrig
