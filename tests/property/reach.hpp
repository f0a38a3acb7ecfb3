// SPDX-License-Identifier: Apache-2.0
// How far, how hard and how fast one rig can go for a protocol, by our own arithmetic. Used when a
// recipe is written as a protocol.
#pragma once

#include "tests/property/own_bounds.hpp"
#include "tests/property/recipe.hpp"

namespace lcrig::property {

constexpr double kPatience_s = 25;  // longest time for one motion
constexpr double kSlack = 0.8;  // share of what our own arithmetic allows

double even(int at, double low, double high);  // `at`: thousandths of the range
double scale(int at, double low, double high);  // the same on a logarithmic scale
double typed(double value);  // rounded down as a person would type it
double typed_mm(double travel_m);

// Recipe and rig must outlive it.
class Reach {
 public:
  Reach(const Recipe& recipe, const sim::RandomRig& rig);

  double limit_N = 0;
  bool zeroed = false;  // the cell is zeroed at the beginning
  double off_N = 0, blind_N = 0;  // error of the force shown: usually, and before a zero
  // shown forces: end of any stop; highest and lowest target
  double end_N = 0, most_N = 0, least_N = 0;
  double rise_N = 0;  // threshold of a search
  double room_m = 0;  // travel beyond contact
  double gap_m = 0;  // at the start of the run
  double inside_m = 0;  // from the surface to where a search reports contact
  // gap after the run; depth and largest gap of the limits
  double clear_m = 0, depth_m = 0, top_m = 0;
  double search_m_s = 0, asked_m_s = 0;  // speed of a search; speed in the protocol
  bool slow_down = false;
  bool may_press = false;
  enum class Style { search, stated, blind };
  Style style = Style::blind;  // how the run learns where the specimen is

  double likely_m(double force_N) const;  // beyond contact
  double pressure_kPa(double force_N) const;
  double air_m_s(int at) const;
  double back_m() const;  // distance to go back from where a search stands
  // The highest speed to a force that our arithmetic allows, after a distance through air. 0: it
  // would take too long.
  double press_m_s(double force_N, double air_m, int at) const;
  double force_of(int at) const { return typed(even(at, least_N, most_N)); }
  // speed from a higher force down to this one; 0: it would take too long
  double ease_m_s(double force_N) const;
  double blind_m_s() const;  // towards a specimen whose position is not known
  double free_m() const;  // safe depth beyond contact if the contact is the stiffest possible
  const ForceLoop* loop() const;  // nullptr: there is none, or nothing is known about it
  bool loop_holds(double force_N) const;
  bool loop_may_land(const ForceLoop& loop) const;  // it may begin without contact
  double ramp_N_s(double force_N) const;  // highest rate; without a loop, that of an ordinary one

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
