// SPDX-License-Identifier: Apache-2.0
// The physical world of a bench: the drive of the frame, the specimen, and the force and
// capacitance that result. The simulated meter and the simulated frame share one Plant.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "base/force_class.hpp"
#include "base/time.hpp"

namespace lcrig {

// The specimen as the bench sees it: some level of the model, tabulated once.
class SpecimenResponse {
 public:
  virtual ~SpecimenResponse() = default;
  // Both are quasi-static answers to a compressive force >= 0, N (dead load over the disc area).
  virtual double shortening_m(double force_N) const = 0;  // of the whole stack; grows with force
  virtual double capacitance_F(double force_N) const = 0;
  virtual double c0_F() const = 0;
};

// Everything that a bench file may say about instruments and mounting. SI.
struct PlantConfig {
  double contact_travel_m = 0;  // machine travel at which the probe touches
  double start_travel_m = 0;  // initial position of the drive
  double frame_stiffness_N_m = 1e6;  // frame, cell and fixture in series with the specimen
  double drive_lag_s = 0.001;  // delay until the device's own stop begins to brake
  double deceleration_m_s2 = 0.05;
  double force_approach_speed_m_s = 0.001;  // speed of force control until contact
  double force_noise_N = 0.0005;  // standard deviation of a sample
  double force_resolution_N = 0.0001;
  double force_offset_N = 0;  // of the cell before its zero was set
  double force_drift_N_s = 0;  // of the cell's zero
  double force_tare_error_N = 0;  // shown without a load after the zero was set
  double force_gain = 1;  // shown force over true force; within the class of the cell
  std::optional<ForceClass> force_class;  // of the cell, as its gateway states it; absent: it does
                                          // not state one
  double travel_resolution_m = 1e-7;
  double force_nominal_N = 20;
  double travel_min_m = -0.1, travel_max_m = 0.1;
  double speed_max_m_s = 0.01;
  // The meter, by aperture: conversion time without averaging, and standard deviation of one
  // conversion at 1 kHz and 1 V. The latter scales with 1/(f V) and 1/sqrt(average) (LCR reference
  // 4.4 and 7).
  std::array<double, 3> conversion_s{0.065, 0.120, 0.380};
  std::array<double, 3> capacitance_noise_F{60e-15, 44e-15, 25e-15};
  // Errors of this meter, as shares from -1 to 1 of what its manual allows at each setting.
  double meter_gain_error = 0, meter_offset_error = 0;
  double dissipation = 0.004;
  double stray_capacitance_F = 0;  // left after the open correction
  double thermal_drift_F_per_s = 0;
  // One Prony term, off by default. Under a held force the specimen finally yields as if the force
  // were (1 + fraction) times as large. Under held travel the force relaxes.
  double creep_fraction = 0;
  double creep_time_s = 10;
  std::uint64_t seed = 1;
};

struct Electrical {
  double capacitance_F = 0;  // parallel
  double dissipation = 0;
};

// Calls that change the drive must come in the order of time. Queries may ask for any later time,
// and for up to two minutes back, because the window of a meter's answer may lie before the last
// change. All values are free of noise; the simulated instruments add theirs.
class Plant {
 public:
  Plant(const SpecimenResponse& specimen, PlantConfig config);

  const PlantConfig& config() const { return config_; }

  // of the drive; under force it includes the compliance of the frame
  double travel_m(MonoTime t) const;
  double force_N(MonoTime t) const;  // on the specimen, >= 0
  // The largest force to which the specimen has responded so far. With creep it responds to more
  // than acts on it. t: now.
  double peak_answered_N(MonoTime t) const;
  void forget_peak() { peak_before_N_ = 0; }  // of drives before the present one
  Electrical electrical(MonoTime t) const;

  // Changes of the drive from time t on.
  void move_to(MonoTime t, double travel_m, double speed_m_s);  // at constant speed
  void ramp_force(MonoTime t, double force_N, double rate_N_s);  // force control; then held
  void halt(MonoTime t);  // decelerates; the travel is then held
  void put_load(MonoTime t, double force_N);  // a dead weight on a rod
  // Time at which the present motion ends by itself; nullopt while the drive stands.
  std::optional<MonoTime> arrival() const;
  // First time in [from, to] at which the force passes `force_N`. Between two changes the drive is
  // monotonic.
  std::optional<MonoTime> force_crossing(double force_N, MonoTime from, MonoTime to) const;
  // Static equilibrium of specimen and frame in series.
  double force_at_travel_N(double travel_m) const;
  double travel_at_force_m(double force_N) const;

 private:
  enum class Control { travel, force };
  // Travel or force over time: a straight part, then an optional braking parabola, then rest.
  struct Profile {
    MonoTime start{};
    double value = 0;  // at start; m or N
    double rate = 0;  // per s, signed
    double straight_s = 0;
    double brake = 0;  // m/s2, against the rate, after the straight part; 0: no parabola
    double end = 0;  // exact final value

    double at(MonoTime t) const;
    double braking_s() const;
    MonoTime finish() const;
    MonoTime time_of(double v) const;  // v: between the first and the last value
  };
  struct Memory {
    MonoTime t{};
    double q_N = 0;
  };
  // The drive between two of its changes.
  struct Drive {
    Control control = Control::travel;
    Profile motion;  // in the unit of control
    std::optional<Profile> approach;  // travel, m, of force control before contact
    Memory changed;  // state at the beginning
    mutable Memory latest;  // state some whole steps later; kept because queries mostly go forward

    bool approaching(MonoTime t) const;  // true while the approach precedes the force ramp
  };
  static Profile straight(MonoTime t, double from, double to, double speed);
  double shortening_m(double force_N) const;  // of specimen and frame
  double solve_force(double shortening_m) const;
  // With creep the specimen answers to force + fraction * q, where q' = (force - q)/time.
  struct Load {
    double force_N, elastic_N;  // applied; responded to
  };
  Load load_at(const Drive& drive, MonoTime t, double q_N) const;
  double creep_step(const Drive& drive, MonoTime from, Duration step, double q_N) const;
  double creep_N(const Drive& drive, MonoTime t) const;  // q
  Load load(MonoTime t) const;
  const Drive& drive_at(MonoTime t) const;
  double speed_m_s(MonoTime t) const;  // precondition: t is not before the last change
  void change_at(MonoTime t, Drive next);
  double peak_of_drive_N(MonoTime t) const;
  std::optional<MonoTime> creeping_crossing(double force_N, MonoTime from, MonoTime to) const;

  const SpecimenResponse& specimen_;
  PlantConfig config_;
  Drive drive_;
  double peak_before_N_ = 0;  // of the drives before this one
  std::deque<Drive> earlier_;  // those that queries may still ask for
  double compliance_m_N_ = 0;  // of the frame; 0: rigid
  double grid_N_ = 1;  // force step of grid_m_
  std::vector<double> grid_m_;  // shortening at multiples of grid_N_, for initial guesses
};

}  // namespace lcrig
