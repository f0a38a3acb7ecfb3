// SPDX-License-Identifier: Apache-2.0
// Whether the frame stands, as far as anybody may claim it: it confirmed STOP after the last order,
// and its samples do not contradict. Pure logic: the run passes it orders, answers and samples, and
// shows a state in which it waits only while `holds()`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/enum_words.hpp"
#include "base/time.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

enum class Standstill {
  cannot_move,  // weights, or a frame that is only observed: this run moves nothing
  not_asked,  // no STOP was sent since the last order
  awaited,  // STOP was sent, and the time for its answer is not over
  confirmed,  // the frame confirmed STOP after the last order, and its samples agree
  not_confirmed,  // no confirmation in time, or samples that show a motion
  unknown  // the link to the frame is lost
};
template <>
inline constexpr EnumWords<6> kWordsOf<Standstill>{"cannot_move", "not_asked",     "awaited",
                                                   "confirmed",   "not_confirmed", "unknown"};
// Words for a person who has to act; empty: nobody has to.
std::string_view alarm_words(Standstill standstill);
// The same after the end of a run, and once it is over.
std::string alarm_words_after(std::int64_t run);
std::string stood_words(double after_s);  // after the end of the run

class StandstillWatch {
 public:
  // How long the answer to STOP may take, in addition to the time of braking. Longer is an alarm.
  static constexpr Duration kPatience = std::chrono::seconds(1);
  // How long the samples have to show the same travel, by how slow the last motion was. A motion so
  // slow that it stays within the tolerance for the longer time is seen later, by the corridor.
  static constexpr Duration kShortLook = std::chrono::milliseconds(200);
  static constexpr Duration kLongLook = std::chrono::milliseconds(800);

  explicit StandstillWatch(bool can_move) : can_move_(can_move) {}

  // An order is being sent; from now on the frame may move at this speed (0: not known).
  void order(double speed_m_s);
  // STOP is being sent. `brakes`: how long the machine may take to stand.
  void ask(MonoTime now, Duration brakes);
  // From now until the next order the samples have to agree for the longer time: nobody looks after
  // this STOP, or a motion was seen.
  void look_longer() { looks_longer_ = true; }
  // The frame confirmed STOP. `period`: of the samples; nullopt: none are coming, so its word is
  // all that can be had.
  void confirm(MonoTime now, std::optional<Duration> period);
  // This program was late by this much: what the samples of that time show arrives at one instant,
  // so the look takes as much longer.
  void allow_lag(Duration late);
  // `tolerance_m`: what the travel of a standing frame may differ by.
  void take(const FrameSample& sample, double tolerance_m);
  void contradict(MonoTime now);  // samples show that the frame moves without an order
  void lose();  // the link
  void rejoin();  // the link is back; nothing is known until STOP was confirmed again

  bool holds() const { return !can_move_ || confirmed_; }
  bool is_lost() const { return lost_; }
  bool is_asked() const { return asked_; }  // STOP was sent since the last order
  // Samples showed a motion after the frame confirmed STOP.
  bool has_moved() const { return said_ && !confirmed_ && moved_; }
  // The frame confirmed STOP, and its samples neither agree yet nor contradict.
  bool is_being_looked_at() const { return said_ && !confirmed_ && !moved_; }
  Standstill at(MonoTime now) const;
  // When the wait for the samples of the last confirmation is over.
  MonoTime look_ends() const { return look_ends_; }

 private:
  Duration look_time(double tolerance_m) const;

  const bool can_move_;
  bool asked_ = false, said_ = false, confirmed_ = false, lost_ = false;
  bool moved_ = false;  // after the frame said that it stands
  bool looks_longer_ = false;
  bool extended_ = false;  // the deadline, for the samples after the first confirmation
  double speed_m_s_ = 0;
  MonoTime deadline_{}, said_at_{}, look_ends_{};
  std::optional<FrameSample> anchor_;  // since this sample the frame has not moved
};

}  // namespace lcrig
