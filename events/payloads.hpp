// SPDX-License-Identifier: Apache-2.0
// The payloads of the kinds of events that programs read. The detail of every other kind is words
// for people. The writer of an event fills a struct; a reader gets the struct back.
#pragma once

#include <any>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/meter_words.hpp"
#include "base/result.hpp"
#include "base/time.hpp"
#include "events/event_kind.hpp"

namespace lcrig {

// Also the `confirm` of a placed weight; the other confirmations are words.
template <EventKind kind>
struct MotionEnded {
  static constexpr EventKind kKind = kind;
  std::string reason;
  std::optional<double> force_N, travel_m;
};
using MotionEvent = MotionEnded<EventKind::motion>;
using WeightPlacedEvent = MotionEnded<EventKind::confirm>;

template <EventKind kind>
struct Touch {
  static constexpr EventKind kKind = kind;
  double travel_m = 0;
  std::optional<double> force_N, rest_force_N;
};
using ContactEvent = Touch<EventKind::contact>;
using NoContactEvent = Touch<EventKind::no_contact>;  // the force that was felt there did not last

template <EventKind kind>
struct LookAtRest {
  static constexpr EventKind kKind = kind;
  double force_N = 0, scatter_N = 0;
  std::int64_t samples = 0;
  std::optional<double> travel_m;
};
using RestEvent = LookAtRest<EventKind::rest>;
using DriftEvent = LookAtRest<EventKind::drift>;

// A motion that was to stop at a force: the force wanted, predicted and reached.
template <EventKind kind>
struct OvershootOf {
  static constexpr EventKind kKind = kind;
  double threshold_N = 0, predicted_N = 0;
  std::optional<double> expected_N;
  double observed_N = 0;
};
using OvershootEvent = OvershootOf<EventKind::overshoot>;
using OvershootExceededEvent = OvershootOf<EventKind::overshoot_exceeded>;

// A time without an instrument.
template <EventKind kind>
struct Absence {
  static constexpr EventKind kKind = kind;
  std::string instrument;
  double seconds = 0, away_s = 0;  // seconds: without data; away_s: since the loss was noticed
  std::int64_t attempts = 0;
};
using GapEvent = Absence<EventKind::gap>;
using ReconnectedEvent = Absence<EventKind::reconnected>;

struct StiffnessEvent {
  static constexpr EventKind kKind = EventKind::stiffness;
  double force_N = 0;
  std::optional<double> stiffness_N_m, at_most_N_m, at_least_N_m;
};

struct ZeroEvent {
  static constexpr EventKind kKind = EventKind::zero;
  double force_before_N = 0;
};

struct GapStatedEvent {
  static constexpr EventKind kKind = EventKind::gap_stated;
  double contact_travel_m = 0;
};

struct ClockStepEvent {
  static constexpr EventKind kKind = EventKind::clock_step;
  double seconds = 0;
};

struct LateSamplesEvent {
  static constexpr EventKind kKind = EventKind::late_samples;
  double age_s = 0;
};

struct LevelAbandonedEvent {
  static constexpr EventKind kKind = EventKind::level_abandoned;
  std::int64_t level = 0;
  std::optional<std::int64_t> readings;
};

struct ContinuesEvent {
  static constexpr EventKind kKind = EventKind::continues;
  std::int64_t run = 0;
  std::string step;
  std::int64_t steps_done = 0;
};

// Meter settings as read back; the run row has them in the same form. Readers accept missing
// fields.
struct SettingsEvent {
  static constexpr EventKind kKind = EventKind::settings;
  std::optional<std::string> function;
  std::optional<double> frequency_Hz, level_V, bias_V;  // bias_V: none when the bias is off
  std::optional<Aperture> aperture;
  std::optional<double> average;
  std::optional<LcrTrigger> trigger;
  std::optional<double> conversion_time_s;
};

// The settings were read back from the meter and compared with those of the last `settings` event.
// The time of its row is the end of the read-back.
struct ReadBackEvent {
  static constexpr EventKind kKind = EventKind::read_back;
  bool equal = true;
  std::optional<std::vector<std::string>> differs;  // their keys; absent when equal
};

// Readings asked from `asked_from_mono_ns` to `asked_to_mono_ns` (both included) were not taken
// between two equal read-backs.
struct UnprovenEvent {
  static constexpr EventKind kKind = EventKind::unproven;
  std::int64_t asked_from_mono_ns = 0, asked_to_mono_ns = 0;
  std::int64_t readings = 0;
  std::string why;
};

// The state that a new run needs to continue at the step that was interrupted. Written when a step
// begins, in the same transaction as the samples.
struct RunPoint {
  static constexpr EventKind kKind = EventKind::state;
  std::int64_t steps_done = 0;  // leaf steps completed, in the order of execution
  std::int64_t levels = 0;  // `measure` levels begun before it
  std::int64_t level_in_repeat = 0, level_repeat = -1;
  std::optional<double> contact_travel_m;  // the travel at gap zero
  std::optional<double> travel_m;  // of the frame, when the step began
  bool zeroed = false;
  std::optional<double> zeros_N;  // sum of the forces that were zeroed
  std::optional<std::string> origin;  // LoadFrame::origin
};

// What the watch over the frame begins with, so that `lcrig watch replay` can judge the run again.
// Stiffnesses are those of ForceBound's grid.
struct WatchSetupEvent {
  static constexpr EventKind kKind = EventKind::watch_setup;
  std::int64_t format = 1;
  bool commands = false;  // false: the frame was only observed
  double rate_Hz = 0;
  double force_min_N = 0, force_max_N = 0;  // the limits of the protocol
  std::optional<double> travel_min_m, travel_max_m, gap_min_m, gap_max_m, speed_max_m_s;
  double cell_class_percent = 0;  // of the load cell; the rest of the frame stands in the run's row
  // The contact: at most, as the model expects it, and if nothing held the specimen. Absent: the
  // frame cannot move, or there is no such model.
  std::optional<std::vector<double>> at_most_N_m, expected_N_m, if_free_N_m;
};

// What changes the state of the watch over the frame, besides the samples.
enum class WatchInput {
  prepared,  // `on`: its samples are judged
  stop_pending,  // `on`: a stop was requested and has not run yet, so no other one is
  order,  // a motion starts
  permit,  // what was predicted for it
  compared,  // it ended, and its force is compared with the prediction
  motion_end,  // it ended there, as the frame reported
  standstill,  // the frame stands, at `travel_m` if it reported one
  motion_unknown,  // it may move or stand
  rest_measurement,  // of the unloaded cell
  rest_measurement_near_contact,  // the probe perhaps touches
  noise,  // a rest measurement of which only the noise counts
  live_cell,  // a rest measurement that shows that the cell is alive
  zero_before_contact,  // of the cell, when nothing had been touched
  force_zeroed,
  zero_hides,  // the force that a zero under load hides from the limits
  zero_took,  // the force that a zero under load took from the cell
  zero,  // of the cell, for the limits
  force_invalid,
  pressing_locked_out,
  contact,  // its place
  least_stiffness,  // of the contact, and its place
  largest_stiffness,  // of the contact
  travel_zeroed,
  force_loop,  // it may raise the force
  age_watched,  // `on`: missing samples stop the run
  age_restarted,
  stopping,  // no sample is judged by the limits until the frame stands
  retreat,  // starts
  ended,  // after the last stop: a motion from now on is only noted
  run_start,  // the frame stands at `travel_m`
  contact_unknown,
  contact_depth,  // `travel_m`: up to there before contact the probe may touch
  contact_taken_over,  // of the run that this one continues
  zeros_taken_over,  // the same: their sum; `on`: there was one
  search,  // starts at `travel_m`; without: contact was found
  link_back,  // what the frame showed before the loss is not its state any more
  motion_locked_out
};
template <>
inline constexpr EnumWords<37> kWordsOf<WatchInput>{"prepared",
                                                    "stop_pending",
                                                    "order",
                                                    "permit",
                                                    "compared",
                                                    "motion_end",
                                                    "standstill",
                                                    "motion_unknown",
                                                    "rest_measurement",
                                                    "rest_measurement_near_contact",
                                                    "noise",
                                                    "live_cell",
                                                    "zero_before_contact",
                                                    "force_zeroed",
                                                    "zero_hides",
                                                    "zero_took",
                                                    "zero",
                                                    "force_invalid",
                                                    "pressing_locked_out",
                                                    "contact",
                                                    "least_stiffness",
                                                    "largest_stiffness",
                                                    "travel_zeroed",
                                                    "force_loop",
                                                    "age_watched",
                                                    "age_restarted",
                                                    "stopping",
                                                    "retreat",
                                                    "ended",
                                                    "run_start",
                                                    "contact_unknown",
                                                    "contact_depth",
                                                    "contact_taken_over",
                                                    "zeros_taken_over",
                                                    "search",
                                                    "link_back",
                                                    "motion_locked_out"};

struct WatchInputEvent {
  static constexpr EventKind kKind = EventKind::watch_input;
  WatchInputEvent() = default;
  explicit WatchInputEvent(WatchInput w) : what(w) {}
  WatchInput what = WatchInput::motion_unknown;
  std::int64_t samples = 0;  // that the run had stored before
  std::optional<bool> judging;  // it follows from the last of them, whose limits come after it
  std::optional<bool> on, presses, holds, force_known;
  std::optional<double> force_N, travel_m, noise_N, stiffness_N_m, direction, speed_m_s, rate_N_s,
      rest_N, free_N, against_N, drift_N_s, waver_N, target_m, worst_N, threshold_N, limit_N,
      expected_N;
  // A look at rest: its samples (from: the count before it), the drift if it was known better, and
  // by how much its mean was shifted.
  std::optional<std::int64_t> from_sample, to_sample;
  std::optional<double> drift_error_N_s, shift_N;
  std::optional<std::string> reason;
};

// The user who asked something of the run, as the kernel reports him (docs/control.md).
struct RequestEvent {
  static constexpr EventKind kKind = EventKind::request;
  std::string request, user;
  std::int64_t uid = 0, pid = 0;
  std::optional<std::string> why;
};

// A stop or a pause that will happen at the end of the current step, level or cycle.
template <EventKind kind>
struct AtAPlace {
  static constexpr EventKind kKind = kind;
  std::string place, step;  // step: the last one before it
  std::int64_t steps_done = 0;  // leaf steps that will be done then
  std::string why;
};
using StopAfterEvent = AtAPlace<EventKind::stop_after>;
using PauseAtEvent = AtAPlace<EventKind::pause_at>;

// A person's answer to an `ask` step.
struct AnswerEvent {
  static constexpr EventKind kKind = EventKind::answer;
  std::string question, type;  // type: confirmation, choice, number, line
  std::optional<double> number;  // in `unit`, the suffix of a key; without a unit: a pure number
  std::optional<std::string> unit, text;  // text: the answer to a choice or a line
  std::string source;  // person, default, file, made_up
  std::optional<std::string> by;  // the person
  std::int64_t repeat = 0;  // count of the outermost loop around the step, from 1; 0: no loop
  std::optional<std::int64_t> from_run;  // the run in which it was answered, which this one
                                         // continues
};

// How a step ended: stored as `done`, or as the word of what stopped it.
struct StepEndEvent {
  static constexpr EventKind kKind = EventKind::step_end;
  std::optional<EventName> stopped_by;
};

template <class P>
concept EventPayload = requires {
  { P::kKind } -> std::convertible_to<EventKind>;
};

// Defined for the structs above.
template <EventPayload P>
std::string to_json(const P& payload);
// Errors: garbled, when `detail` is not a JSON object or lacks a field that the payload requires.
template <EventPayload P>
Result<P> from_json(std::string_view detail);

// An event of a run on its way to the database and to the clients that watch. Every part of a run
// makes events; the recorder stores them.
struct RunEvent {
  RunEvent() = default;
  RunEvent(MonoTime at, EventName what, std::string step, std::string text)
      : t(at), kind(std::move(what)), step_id(std::move(step)), detail(std::move(text)) {}
  template <EventPayload P>
  RunEvent(MonoTime at, std::string step, const P& what)
      : t(at), kind(P::kKind), step_id(std::move(step)), detail(to_json(what)), payload_(what) {}
  // The payload that it was made from; nullptr: it has another payload, or words only.
  template <EventPayload P>
  const P* as() const {
    return std::any_cast<P>(&payload_);
  }

  MonoTime t;
  EventName kind = EventKind::other;
  std::string step_id;
  std::string detail;  // the payload as JSON, or words for people

 private:
  std::any payload_;
};

}  // namespace lcrig
