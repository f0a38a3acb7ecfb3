// SPDX-License-Identifier: Apache-2.0
// What is known about the two instruments, from which source, and since when, as `lcrig status`
// shows it. Code that opens, asks or uses an instrument reports the result here. Owned by App.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "daemon/control/messages.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/stated_frame.hpp"

namespace lcrig {

// How something was learned, and by which run.
struct Learned {
  Learned() = default;
  explicit Learned(LearnedBy b, std::optional<std::int64_t> r = std::nullopt) : by(b), run(r) {}
  LearnedBy by = LearnedBy::look;
  std::optional<std::int64_t> run;
};

class KnownRig {
 public:
  explicit KnownRig(const Clock& clock) : clock_(clock) {}

  // Declares an instrument that nobody has asked yet. Undeclared ones are not shown.
  void declare(Instrument which, std::string port, std::string why_unasked, bool simulated);

  // It reported its identity; empty: a simulated bench was found to be in order.
  void answered(Instrument which, const Identity& identity, const Learned& from);
  // Calls `answered` or `failed`.
  void learned(Instrument which, const Result<Identity>& answer, const Learned& from);
  // The last question failed. The earlier identity stays known. `unsupported` is not a fault: this
  // instrument cannot be asked.
  void failed(Instrument which, const Error& error, const Learned& from);
  // The frame's capabilities are known, with what a person states.
  void stated(const FrameCapabilities& counted);
  // The frame cannot be asked without taking command. What it stated before stays known.
  void cannot_state(const StatedFrame& by_person);
  // The same instrument is back, or a run takes over what is known about it.
  void confirmed(Instrument which, const Learned& from);
  // It sent data, which confirms what is known.
  void heard(Instrument which);
  // Whether the device node of its port exists. True: that has changed.
  bool set_port_there(Instrument which, bool there);

  bool is_ready(Instrument which) const;
  // False: its port came back, and nobody has asked for its identity.
  bool is_known(Instrument which) const;
  const std::string& port(Instrument which) const { return of(which).state.port; }
  // `run`: the current run.
  std::vector<InstrumentState> states(std::optional<std::int64_t> run) const;

 private:
  struct Known {
    InstrumentState state;  // without its ages, which states() calculates
    bool declared = false, port_there = true;
    bool on_simulated_rig = false;
    std::optional<MonoTime> asked, since, gone;
  };
  Known& of(Instrument which) { return known_[static_cast<std::size_t>(which)]; }
  const Known& of(Instrument which) const { return known_[static_cast<std::size_t>(which)]; }
  void learn(Instrument which, InstrumentCondition condition, std::string why, const Learned& from);
  InstrumentState state_of(const Known& known, std::optional<std::int64_t> run) const;

  const Clock& clock_;
  std::array<Known, 2> known_;
};

}  // namespace lcrig
