// SPDX-License-Identifier: Apache-2.0
// What a protocol made from a recipe may ask of one rig: how far, how hard and how fast our own
// arithmetic says it can go.
#pragma once

#include "tests/property/own_bounds.hpp"
#include "tests/property/recipe.hpp"

namespace lcrig::property {

constexpr double kPatience_s = 25;  // for one motion
constexpr double kSlack = 0.8;  // of what our own arithmetic allows

double even(int at, double low, double high);  // `at` thousandths of the way
double scale(int at, double low, double high);  // the same by factors
double typed(double value);  // as somebody would type it, never more
double typed_mm(double travel_m);

// Recipe and rig must outlive it.
class Reach {
 public:
  Reach(const Recipe& recipe, const sim::RandomRig& rig);

  double limit_N = 0;
  bool zeroed = false;  // the cell, at the beginning
  double off_N = 0, blind_N = 0;  // what is shown may be off by so much, and before a zero
  double end_N = 0, most_N = 0, least_N = 0;  // shown: no stop ends beyond; targets from and to
  double rise_N = 0;  // of a search
  double room_m = 0;  // beyond contact
  double gap_m = 0;  // at the start
  double inside_m = 0;  // from where the specimen begins to where a search calls it contact
  double clear_m = 0, depth_m = 0, top_m = 0;  // of gaps: after the run, least, largest
  double search_m_s = 0, asked_m_s = 0;  // of a search, and what the file says
  bool slow_down = false;
  bool may_press = false;
  enum class Style { search, stated, blind };
  Style style = Style::blind;  // how the place of the specimen is known

  double likely_m(double force_N) const;  // beyond contact
  double pressure_kPa(double force_N) const;
  double air_m_s(int at) const;
  double back_m() const;  // from where a search stands
  // The fastest to a force that our arithmetic allows, after a way through air; 0: too slow for
  // anybody's patience.
  double press_m_s(double force_N, double air_m, int at) const;
  double force_of(int at) const { return typed(even(at, least_N, most_N)); }
  double ease_m_s(double force_N) const;  // from more to this; 0: too slow
  double blind_m_s() const;  // towards a specimen that may be anywhere
  double free_m() const;  // beyond contact, without danger on the stiffest one
  const ForceLoop* loop() const;  // nullptr: there is none, or nothing is known of it
  bool loop_holds(double force_N) const;
  bool loop_may_land(const ForceLoop& loop) const;  // from the air
  double ramp_N_s(double force_N) const;  // the fastest; without a loop that of an ordinary one

 private:
  int base(std::size_t i) const { return recipe_.base[i]; }
  void settle_forces();
  void settle_search();
  void settle_ways();

  const Recipe& recipe_;
  const sim::RandomRig& rig_;
  const FrameCapabilities& caps_;
  OwnContact contact_;
};

}  // namespace lcrig::property
