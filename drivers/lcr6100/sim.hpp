// SPDX-License-Identifier: Apache-2.0
// A simulated LCR-6100. It answers the bytes that the real one would, from a source of electrical
// values or from recorded readings. Used by rehearsals, lcrig-sim, replays and tests.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/line_fault.hpp"
#include "drivers/panel_key.hpp"
#include "drivers/transport.hpp"
#include "model/plant.hpp"

namespace lcrig::lcr6100 {

struct SimConfig {
  std::string identity = "LCR-6100,REV E8.13,SIM000001,Good Will Instrument Co., Ltd.";
  // Time of one conversion by aperture (fast, medium, slow), without averaging.
  std::array<double, 3> conversion_s{0.065, 0.120, 0.380};
  // Standard deviation of one conversion at 1 kHz and 1 V. It scales with 1/(f V sqrt(average)).
  std::array<double, 3> capacitance_noise_F{60e-15, 44e-15, 25e-15};
  // This meter's errors, as fractions from -1 to 1 of what its manual allows at each setting.
  double gain_error = 0, offset_error = 0;
  std::uint64_t seed = 1;
  // Open and short correction are on, even after a power cut, because a person made them. The stray
  // capacitance of a bench is what remains after them.
  bool corrected = false;
};

// Faults to inject. They cannot be reached with the instrument's own commands.
struct SimFaults {
  using Kind = LineFault::Kind;
  using Reply = LineFault;
  std::deque<Reply> replies;  // faults of the next answers, one entry each
  int lose_sets = 0;  // the next n set commands are lost
  std::string first_line;  // bytes sent before the first answer
  bool silent = false;
  bool streaming = false;  // sends every reading unasked, until SYST:RES FETCH
  bool stuck = false;  // always repeats its last reading
  bool overload = false;
  double slow_factor = 1;  // multiplies the conversion time until the aperture is set again
  double byte_noise = 0;  // probability that a byte of an answer is spoiled
  bool correction_fails = false;
  bool off = false;  // hears nothing and says nothing, as while it restarts
  double late_settings_s =
      0;  // a setting is answered at once, but measured at only this much later
};

// What a conversion depends on. The record of the truth: what the meter was, whatever it answers.
struct SimSettings {
  std::string function, range;
  double frequency_Hz = 0, level_V = 0;
  std::optional<double> bias_V;
  std::size_t aperture = 0;
  int average = 1;
  bool open_correction = false, short_correction = false;
  bool operator==(const SimSettings&) const = default;
};

// Called at every occasion, so that a fault script can decide (drivers/faults). May be empty. The
// hooks stay when the meter is unplugged.
struct SimHooks {
  std::function<LineFault()> answer;  // the fault of this answer
  std::function<bool()> loses_set;  // true: this set command is lost
};

class Lcr6100Sim {
 public:
  // The value at a time. No requested time is more than one conversion before an earlier one.
  using Source = std::function<Electrical(MonoTime)>;
  // For replays: the newest recorded answer this long after the first FETC? or *TRG. Settings and
  // noise are not simulated then. `conversion` is the time that the meter would need as it is set.
  struct Recorded {
    std::size_t number = 0;  // answers so far; 0: none, and no text
    std::string text;  // "primary,secondary" as the meter sent it
  };
  using Recording = std::function<Recorded(Duration since, Duration conversion)>;

  Lcr6100Sim(std::unique_ptr<Transport> transport, Clock& clock, SimConfig config, Source source);
  Lcr6100Sim(std::unique_ptr<Transport> transport, Clock& clock, SimConfig config,
             Recording recording);

  // Answers until the transport closes. This object must outlive the task.
  Task<> run();
  void close() { transport_->close(); }
  // Plugs the cable in again after `run` has ended. The settings are kept. Call run() again.
  void attach(std::unique_ptr<Transport> transport);
  // Takes over the settings of an earlier object for the same meter, whose cable was unplugged.
  void keep_settings_of(const Lcr6100Sim& before);
  // As after a power cut: factory settings and no measurement. Another identity makes it another
  // meter.
  void power_on(std::string identity = "");
  SimFaults& faults() { return faults_; }
  void set_hooks(SimHooks hooks) { hooks_ = std::move(hooks); }
  // Sends a line that nobody asked for. An empty text repeats the latest reading.
  Task<> speak(std::string text);
  const std::string& identity() const { return config_.identity; }
  // Sets what a hand at the panel sets; an empty text sets what it was before. False: the meter has
  // no such value.
  bool turn(PanelKey key, std::string_view to);
  static bool accepts(PanelKey key, std::string_view to);
  static std::string accepted_words(PanelKey key);  // "AUTO, HOLD, NOM", "10 to 100000"
  // For tests: the settings of the newest answered conversion; nullopt: they changed within it.
  const std::optional<SimSettings>& measured_at() const { return measured_at_; }
  // For tests: `told` gets each reading when it is answered, before any line fault.
  void watch(std::function<void(MonoTime, const std::string&)> told) { told_ = std::move(told); }
  // For tests: the number of FETC? in all forms.
  std::int64_t fetches() const { return fetches_; }

 private:
  // sim.cpp: bytes, answers, conversions
  Task<> take(std::string_view bytes);
  Task<> answer(std::string text);
  Task<> line(std::string_view text);
  Task<> stream();
  Task<> fetch(std::string_view what);
  Task<> trigger(bool answered);
  Task<> correct();
  MonoTime next_edge() const { return grid_start_ + (finished() + 1) * conversion(); }
  Duration conversion() const;
  double sigma(const SimSettings& s) const;
  bool internal() const { return value("TRIG:SOUR").word == "INT"; }
  std::int64_t finished() const { return (clock_.now() - grid_start_) / conversion(); }
  void restart_grid();
  void tell() const {
    if (told_) told_(clock_.now(), reading_);
  }
  void compute(MonoTime middle, std::int64_t index);
  SimSettings settings_now() const;
  void note_settings(double late_s = 0);
  const SimSettings& in_force(MonoTime t) const;
  Task<> await_recorded(std::size_t after);
  std::size_t compute_recorded();
  // sim_commands.cpp: grammar
  struct Parameter;
  struct Value {
    std::string word;
    double number = 0;
  };
  static const std::vector<Parameter>& parameters();
  static const Parameter& parameter_of(PanelKey key);
  std::string resolve(std::string_view header);
  Task<> command(std::string_view text);
  Task<> ask(std::string header);
  void assign(const Parameter& p, Value& value, std::string_view argument);
  void assign_aperture(std::string_view argument);
  bool set(const std::string& header, std::string_view argument);
  std::optional<std::string> read(std::string_view header) const;
  const Value& value(std::string_view header) const;
  void reset();
  void fail_with(std::string_view code) { error_ = code; }

  std::unique_ptr<Transport> transport_;
  Clock& clock_;
  SimConfig config_;
  Source source_;
  Recording recording_;
  SimFaults faults_;
  SimHooks hooks_;
  LineNoise noise_;
  std::function<void(MonoTime, const std::string&)> told_;

  std::vector<Value> values_;  // in the order of parameters()
  int aperture_ = 2, average_ = 1;
  std::deque<std::pair<MonoTime, SimSettings>> in_force_;  // since when; never empty
  std::optional<SimSettings> measured_at_;
  std::map<PanelKey, std::string> before_;  // what a hand at the panel has changed
  int starts_ = 0;  // how often it was switched on
  std::string error_ = "*E00";
  std::string path_;  // header path of the current message
  std::string in_, out_;
  bool garbage_sent_ = false;

  MonoTime grid_start_{};
  std::uint64_t epoch_ = 0;  // counts restarts of the grid
  std::int64_t computed_ = 0;  // index in this epoch of the conversion in `reading_`
  std::int64_t streamed_ = 0;
  std::string reading_;  // numbers of the latest computed conversion; may be empty
  std::string monitors_;
  std::optional<MonoTime> play_start_;
  std::int64_t fetches_ = 0;
};

}  // namespace lcrig::lcr6100
