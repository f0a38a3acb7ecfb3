// SPDX-License-Identifier: Apache-2.0
// A simulated frame-link/1 gateway and machine (docs/frame-link.md), acting on a scene. Used by
// rehearsals, lcrig-sim, replays and tests.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "drivers/line_fault.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/transport.hpp"
#include "drivers/zwick/codec.hpp"
#include "model/plant.hpp"

namespace lcrig {

// The simulated machine's view of the world: the functions of Plant that concern a frame.
class FrameScene {
 public:
  virtual ~FrameScene() = default;
  virtual const PlantConfig& config() const = 0;
  virtual double travel_m(MonoTime t) const = 0;
  virtual double force_N(MonoTime t) const = 0;
  virtual void move_to(MonoTime t, double travel_m, double speed_m_s) = 0;
  virtual void ramp_force(MonoTime t, double force_N, double rate_N_s) = 0;
  virtual void halt(MonoTime t) = 0;  // reacts after drive_lag_s, decelerates, then holds travel
  virtual std::optional<MonoTime> arrival() const = 0;
  virtual std::optional<MonoTime> force_crossing(double force_N, MonoTime from,
                                                 MonoTime to) const = 0;
  virtual double force_at_travel_N(double travel_m) const = 0;
};

// The plant must outlive the scene.
class PlantScene : public FrameScene {
 public:
  explicit PlantScene(Plant& plant) : plant_(plant) {}
  const PlantConfig& config() const override { return plant_.config(); }
  double travel_m(MonoTime t) const override { return plant_.travel_m(t); }
  double force_N(MonoTime t) const override { return plant_.force_N(t); }
  void move_to(MonoTime t, double travel_m, double speed_m_s) override {
    plant_.move_to(t, travel_m, speed_m_s);
  }
  void ramp_force(MonoTime t, double force_N, double rate_N_s) override {
    plant_.ramp_force(t, force_N, rate_N_s);
  }
  void halt(MonoTime t) override { plant_.halt(t); }
  std::optional<MonoTime> arrival() const override { return plant_.arrival(); }
  std::optional<MonoTime> force_crossing(double force_N, MonoTime from,
                                         MonoTime to) const override {
    return plant_.force_crossing(force_N, from, to);
  }
  double force_at_travel_N(double travel_m) const override {
    return plant_.force_at_travel_N(travel_m);
  }

 private:
  Plant& plant_;
};

// One row of a recording. An absent value is also absent in the sample.
struct RecordedRow {
  double t_s = 0;  // since start_recording(), in ascending order
  std::optional<double> travel_m, force_N;
};

struct ZwickSimSettings {
  std::string serial = "simulated";
  int revision = frame_link::kRevision;  // 1: a gateway without observer sessions;
                                         // 2: one that states no steps, filter and play
  double rate_max_Hz = 500;
  bool force_hold = true;
  double speed_min_m_s = 1e-7;
  double approach_m_s = 1e-4;  // speed of RAMPF before contact
  double device_clock_start_s = 0;
  double device_clock_ppm = 0;  // the device clock runs fast by this
  std::uint64_t seed = 1;  // noise

  // Replaces the true capabilities in CAPS. Its travel refers to the first reference run.
  std::optional<FrameCapabilities> declared;
  // How often the gateway checks the force; 0: the device watches it continuously.
  double watch_period_s = 0;
  // The force loop. It overshoots the target of a ramp by its rate times the lag and holds a force
  // within the ripple. With `loop_lands` it first stops at contact, as every motion does. The
  // default loop is exact.
  double loop_lag_s = 0, loop_ripple_N = 0, loop_rate_max_N_s = 1e3;
  bool loop_lands = false;
  // The link. Each transmission is late by the delay and a random part of the jitter, each answer
  // by a random part of the answer delay. STOP is never answered late.
  double line_delay_s = 0, line_jitter_s = 0, answer_delay_s = 0;
  // The probability that a value is missing in a sample.
  double missing_time = 0, missing_force = 0, missing_travel = 0;
};

// Wrong behaviour of the machine, or wrong reports of the gateway (docs/faults.md). Each may begin
// and end at any time.
struct ZwickSimLies {
  // Lies of the load cell.
  bool force_frozen = false;  // always repeats its last value
  bool force_held = false;  // shows a constant mean with scatter
  double force_gain = 1;  // factor on the force that it shows
  bool force_reversed = false;
  double force_drift_N_s = 0;  // starts when it is set
  double force_scatter = 1;  // factor on its noise
  // Wrong behaviour of the drive.
  bool drive_reversed = false;  // moves away from its target
  bool drive_mirrored = false;  // the same, and it shows the travel as if it obeyed
  double creep_m_s = 0;  // moves on after every motion, and right away; STOP ends it
  bool estop = false;  // pressed
  // Lies of the gateway: how it handles orders and reports on them.
  double order_late_s = 0;  // orders are carried out this late, even after a STOP
  bool done_early = false;  // DONE comes half-way (in a motion: at once), with the target's values
  bool done_unmoved = false;  // DONE after 0.5 s without any motion
  double done_late_s = 0;
  bool stop_ignored = false;  // STOP is neither obeyed nor answered
  bool stop_unconfirmed = false;  // STOP is obeyed but not answered
  double stop_late_s = 0;  // STOP is answered this late
  bool stop_pretended = false;  // STOP is answered at once and not obeyed; samples hide the motion
  bool stop_silences = false;  // STOP is not obeyed, and from then on the gateway sends nothing
  double clock_rate = 1;  // rate of the device clock; 0: frozen
  bool other_caps = false;  // CAPS state half the deceleration
  bool operator==(const ZwickSimLies&) const = default;
};

// Faults to inject; the frame link cannot reach them. All are off until set. Counters count down.
struct ZwickSimFaults {
  bool silent = false;  // sends nothing at all
  bool deaf = false;  // receives nothing, but the line stays open
  std::int64_t lose_samples = 0;  // the next n samples are lost, but counted in seq
  double clock_jump_s = 0;  // added to the device clock
  std::string refuse_next;  // error code for the next command
  bool never_complete = false;  // the gateway does not notice that motions end
  int lose_done = 0;  // the next n DONE lines are lost
  int lose_answers = 0;  // the next n OK or ERR lines are lost
  int lose_stopped = 0;  // the next n STOPPED lines are lost
  std::string say;  // sent verbatim at once, then cleared
  bool not_ready = false;  // E-stop, shield or drive: all motions are refused
  bool no_heartbeats = false;  // only HB is lost, in both directions
  double byte_noise = 0;  // probability that a sent byte is spoiled
  double spike_N = 0;  // added to the shown force
  std::int64_t spike_samples = 0;  // in the next n samples
  double late_stop_s = 0;  // delay of the device's own stop (goal, force limit)
  bool lose_tare = false;  // the tare of force, once
  bool tell_origin = false;  // lose_tare also reports a new origin
  ZwickSimLies lies;
};

// Called at every occasion, so that a fault script can decide (drivers/faults). May be empty.
struct ZwickSimHooks {
  std::function<LineFault()> sends;  // the fault of this transmission, which is one line or more
  std::function<std::string()> refuses;  // error code for this command; empty: none
  std::function<bool()> loses_done;  // true: this DONE is lost
};

namespace frame_link {
class SimClerk;
class SimMachine;
}  // namespace frame_link

// One session over one transport. `run` serves until the transport closes and then stops the
// machine. Clock, scene and this object must outlive `run`.
class ZwickSim {
 public:
  ZwickSim(std::unique_ptr<Transport> transport, Clock& clock, FrameScene& scene,
           ZwickSimSettings settings = ZwickSimSettings());
  // Plays `rows` verbatim as samples from start_recording() on. Such a machine cannot move and
  // accepts any RATE.
  ZwickSim(std::unique_ptr<Transport> transport, Clock& clock, std::vector<RecordedRow> rows,
           ZwickSimSettings settings = ZwickSimSettings());
  ~ZwickSim();

  Task<> run();
  void close();  // ends `run`; idempotent
  // Sets a new connection after `run` has ended. The machine keeps position, tare and clock. Call
  // run() again.
  void attach(std::unique_ptr<Transport> transport);

  void start_recording();
  bool is_recording_over() const { return recording_ && next_row_ >= recording_->size(); }

  // Changes take effect after poke().
  ZwickSimFaults faults;
  ZwickSimHooks hooks;  // kept when the connection ends
  // For tests: called with each sample as it is taken, even if it is then lost.
  std::function<void(MonoTime, const FrameSample&)> watch;
  void poke() { wakeup_.notify(); }
  void stall();  // the drive stops moving, and nothing reports it
  // The machine stops by itself. `kind` is a word of docs/frame-link.md, section 6, or empty.
  void trip(std::string_view kind, std::string_view text);
  ZwickSimSettings& settings() { return settings_; }  // changes take effect at the next HELLO
  // As after switching off and on: tare and limits are lost, and the clock restarts.
  void forget();
  // The gateway's program restarts on an open line: motion stops and the session ends.
  void restart();
  bool is_moving() const;
  bool is_armed() const;
  std::int64_t stops() const { return stops_; }  // received in this session
  double travel_zero_m() const;  // the machine's own travel where samples show 0

 private:
  Task<> read();
  Task<> serve();
  void catch_up(MonoTime now);
  void play_until(MonoTime now);
  void lie(MonoTime now);
  void owe_stops(MonoTime now);
  void take_sample(MonoTime t);
  void take_row(MonoTime t);
  void flush();
  void finish_batch();
  void finish_motions();
  void supervise(MonoTime now);
  void open_session();
  void on_line(std::string_view text);
  void on_command(const frame_link::Line& line, std::string_view text);
  void on_stop();
  void answer_stops();
  void say_stopped();
  void set_rate(const frame_link::Line& line);
  void start_samples(double rate_Hz);
  void say(std::string_view line);
  void answer(std::string line);
  void release_answers(MonoTime until);
  double chance();
  std::string hello() const;
  std::string caps() const;
  void begin_session(bool observer);
  void greet(const frame_link::Line& line);
  void observe(const frame_link::Line& line);
  void end_command(std::string_view why);
  void transmit(std::string bytes, MonoTime now);
  double device_time_s(MonoTime t) const;
  MonoTime sample_time(std::int64_t k) const;
  std::optional<MonoTime> next_sample() const;
  MonoTime next_due() const;

  std::unique_ptr<Transport> transport_;
  Clock& clock_;
  ZwickSimSettings settings_;
  std::unique_ptr<frame_link::SimMachine> machine_;  // null while a recording is played
  std::unique_ptr<frame_link::SimClerk> clerk_;  // null without machine_
  std::optional<std::vector<RecordedRow>> recording_;
  std::optional<MonoTime> recording_start_;
  std::size_t next_row_ = 0;

  Wakeup wakeup_;
  bool closed_ = false;
  bool session_ = false;
  bool observer_ = false;  // the session may not command
  bool watchdog_tripped_ = false;
  std::string out_;
  struct Sent {
    Sent(MonoTime t, std::string b) : due(t), bytes(std::move(b)) {}
    MonoTime due;
    std::string bytes;
  };
  std::deque<Sent> line_;  // bytes on the line, which keeps their order
  std::deque<Sent> answers_;  // not yet sent
  LineNoise noise_;
  std::mt19937_64 random_;  // decides what is late or missing
  std::array<char, 8192> buffer_{};
  frame_link::LineSplitter splitter_;
  MonoTime power_on_, heard_, said_;
  std::int64_t stops_ = 0;  // received in this session
  std::int64_t last_number_ = -1;  // of a command in this session
  bool stop_owed_ = false;
  bool silenced_ = false;  // by a STOP
  std::optional<MonoTime> stop_due_;  // when a slow gateway will answer it
  ZwickSimLies lies_;  // as of the latest catch_up
  double clock_gain_s_ = 0;  // error of a wrong rate until clock_since_
  MonoTime clock_since_;

  double rate_Hz_ = 0;
  MonoTime rate_start_;
  std::int64_t rate_index_ = 0;  // of the next sample on the grid
  std::int64_t seq_ = 1;  // of the next sample
  std::vector<FrameSample> batch_;
};

}  // namespace lcrig
