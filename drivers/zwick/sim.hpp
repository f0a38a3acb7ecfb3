// SPDX-License-Identifier: Apache-2.0
// The reference frame-link/1 gateway: answers the grammar of docs/frame-link.md from a scene.
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

#include "drivers/line_fault.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/transport.hpp"
#include "drivers/zwick/codec.hpp"
#include "model/plant.hpp"

namespace lcrig {

// What the simulated machine asks of the world: exactly the calls of Plant that a frame needs.
class FrameScene {
 public:
  virtual ~FrameScene() = default;
  virtual const PlantConfig& config() const = 0;
  virtual double travel_m(MonoTime t) const = 0;
  virtual double force_N(MonoTime t) const = 0;
  virtual void move_to(MonoTime t, double travel_m, double speed_m_s) = 0;
  virtual void ramp_force(MonoTime t, double force_N, double rate_N_s) = 0;
  virtual void halt(MonoTime t) = 0;  // reacts after drive_lag_s, then decelerates; holds travel
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

// One row of a recording; an absent value stays absent.
struct RecordedRow {
  RecordedRow() = default;
  double t_s = 0;  // ascending
  std::optional<double> travel_m, force_N;
};

struct ZwickSimSettings {
  ZwickSimSettings() = default;
  std::string serial = "simulated";
  int revision = frame_link::kRevision;  // 1: as a gateway of before observer sessions
  double rate_max_Hz = 500;
  bool force_hold = true;
  double speed_min_m_s = 1e-7;
  double approach_m_s = 1e-4;  // of RAMPF before contact
  double device_clock_start_s = 0;
  double device_clock_ppm = 0;  // fast by this
  std::uint64_t seed = 1;  // noise

  // What CAPS say where it is not the truth; travel as at the first reference run.
  std::optional<FrameCapabilities> declared;
  // The gateway looks at the force so often; 0: the device watches it all the time.
  double watch_period_s = 0;
  // Of the force loop: it passes the target of a ramp by its rate times `lag`, holds a force
  // within the ripple, and lands with the stop that every motion has. By default it is exact.
  double loop_lag_s = 0, loop_ripple_N = 0, loop_rate_max_N_s = 1e3;
  bool loop_lands = false;
  // Of the link. Each transmission is late by the delay and a random part of the jitter, each
  // answer by a random part of its own; STOP is never answered late.
  double line_delay_s = 0, line_jitter_s = 0, answer_delay_s = 0;
  // Each value of a sample is missing with this probability.
  double missing_time = 0, missing_force = 0, missing_travel = 0;
};

// What is not true of a machine behind an honest gateway, or of what the gateway says of it.
// docs/faults.md. Each may begin and end at any instant.
struct ZwickSimLies {
  ZwickSimLies() = default;
  // The cell.
  bool force_frozen = false;  // its last value, again and again
  bool force_held = false;  // its mean, while it scatters
  double force_gain = 1;  // times what it shows of the force, from now on
  bool force_reversed = false;
  double force_drift_N_s = 0;  // from then on
  double force_scatter = 1;  // times its noise
  // The drive.
  bool drive_reversed = false;  // away from where it is told
  double creep_m_s = 0;  // goes on after every motion, and from now on; STOP ends it
  bool estop = false;  // held
  // What the gateway does with orders, and says of them.
  double order_late_s = 0;  // carried out so much later, even after a STOP
  bool done_early = false;  // half-way, and in a motion at once, with the target's own values
  bool done_unmoved = false;  // after half a second, and nothing has moved
  double done_late_s = 0;
  bool stop_ignored = false;  // neither obeyed nor answered
  bool stop_unconfirmed = false;  // obeyed, not answered
  double stop_late_s = 0;  // answered so much later
  double clock_rate = 1;  // of the device clock; 0: frozen
  bool other_caps = false;  // half the deceleration
  bool operator==(const ZwickSimLies&) const = default;
};

// Not reachable over the grammar. Every fault is off until set; counters count down.
struct ZwickSimFaults {
  ZwickSimFaults() = default;
  bool silent = false;  // sends nothing any more, HB included
  bool deaf = false;  // hears nothing any more, the line stays open
  std::int64_t lose_samples = 0;  // the next n samples are lost; their numbers are not
  double clock_jump_s = 0;  // added to the device clock
  std::string refuse_next;  // error code for the next command
  bool never_complete = false;  // motions end, but the gateway thinks that they go on
  int lose_done = 0;  // the next n DONE lines are lost
  int lose_answers = 0;  // the next n OK or ERR lines are lost
  int lose_stopped = 0;  // the next n STOPPED lines are lost
  std::string say;  // sent verbatim at once, then cleared
  bool not_ready = false;  // E-stop, shield or drive: whatever moves is refused
  bool no_heartbeats = false;  // HB is lost in both directions, everything else goes through
  double byte_noise = 0;  // each byte that is sent is hit with this probability
  double spike_N = 0;  // added to what the cell shows ...
  std::int64_t spike_samples = 0;  // ... in the next n samples
  double late_stop_s = 0;  // the device's own stop (goal, force limit) comes so much later
  bool lose_tare = false;  // of force, once ...
  bool tell_origin = false;  // ... and a new origin is told
  ZwickSimLies lies;
};

// Asked at every occasion, so that a script can decide (drivers/faults). May be empty.
struct ZwickSimHooks {
  ZwickSimHooks() = default;
  std::function<LineFault()> sends;  // what happens to this transmission, of one line or more
  std::function<std::string()> refuses;  // error code for this command; empty: none
  std::function<bool()> loses_done;  // this DONE is lost
};

namespace frame_link {
class SimClerk;
class SimMachine;
}  // namespace frame_link

// One session over one transport. `run` serves until the transport closes, then stops the machine.
// Clock, scene and this object must outlive `run`.
class ZwickSim {
 public:
  ZwickSim(std::unique_ptr<Transport> transport, Clock& clock, FrameScene& scene,
           ZwickSimSettings settings = ZwickSimSettings());
  // Plays `rows` as samples, verbatim, from start_recording() on; has no motion and takes any RATE.
  ZwickSim(std::unique_ptr<Transport> transport, Clock& clock, std::vector<RecordedRow> rows,
           ZwickSimSettings settings = ZwickSimSettings());
  ~ZwickSim();

  Task<> run();
  void close();  // ends `run`; idempotent
  // A new connection after `run` has ended; the machine keeps position, tare and clock. run() anew.
  void attach(std::unique_ptr<Transport> transport);

  void start_recording();
  bool is_recording_over() const { return recording_ && next_row_ >= recording_->size(); }

  // Changes take effect after poke().
  ZwickSimFaults faults;
  ZwickSimHooks hooks;  // stay when the connection ends
  // For tests: told each sample as it is taken, lost or not.
  std::function<void(MonoTime, const FrameSample&)> watch;
  void poke() { wakeup_.notify(); }
  void stall();  // the drive stops moving, nobody notices
  // The machine stops by itself; `kind`: a word of docs/frame-link.md, section 6, or none.
  void trip(std::string_view kind, std::string_view text);
  ZwickSimSettings& settings() {
    return settings_;
  }  // of the gateway; they act with the next HELLO
  // As after switching off and on: tare and limits are forgotten, the clock starts anew.
  void forget();
  // The gateway's program was restarted on an open line: motion stops, the session is over.
  void restart();
  bool is_moving() const;
  bool is_armed() const;
  double travel_zero_m() const;  // the machine's own travel where the samples show 0

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
  std::unique_ptr<frame_link::SimMachine> machine_;  // none while a recording is played
  std::unique_ptr<frame_link::SimClerk> clerk_;  // with it
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
  std::deque<Sent> line_;  // on the way; nothing overtakes on a line
  std::deque<Sent> answers_;  // not given yet
  LineNoise noise_;
  std::mt19937_64 random_;  // of what is late or missing
  std::array<char, 8192> buffer_{};
  frame_link::LineSplitter splitter_;
  MonoTime power_on_, heard_, said_;
  std::int64_t stops_ = 0;  // received in this session
  std::int64_t last_number_ = -1;  // of a command in it
  bool stop_owed_ = false;
  std::optional<MonoTime> stop_due_;  // its answer, of a gateway that is late
  ZwickSimLies lies_;  // as of the latest catch_up
  double clock_gain_s_ = 0;  // by a wrong rate, until and since
  MonoTime clock_since_;

  double rate_Hz_ = 0;
  MonoTime rate_start_;
  std::int64_t rate_index_ = 0;  // of the next sample on the grid
  std::int64_t seq_ = 1;  // of the next sample
  std::vector<FrameSample> batch_;
};

}  // namespace lcrig
