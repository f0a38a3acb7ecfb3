// SPDX-License-Identifier: Apache-2.0
// The newest knowledge about the two instruments, from whom it comes, and since when: `lcrig
// status` shows it. Code that opens, asks or uses an instrument reports the result here; App owns
// it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "daemon/control/messages.hpp"
#include "drivers/lcr_meter.hpp"

namespace lcrig {

// The one who asked.
struct Learned {
  Learned() = default;
  explicit Learned(LearnedBy b, std::optional<std::int64_t> r = std::nullopt) : by(b), run(r) {}
  LearnedBy by = LearnedBy::look;
  std::optional<std::int64_t> run;
};

class KnownRig {
 public:
  explicit KnownRig(const Clock& clock) : clock_(clock) {}

  // An instrument that nobody asked yet. One that is not declared is not shown.
  void declare(Instrument which, std::string port, std::string why_unasked, bool simulated);

  // It said who it is; empty: a simulated bench was found to be in order.
  void answered(Instrument which, const Identity& identity, const Learned& from);
  // One of the two.
  void learned(Instrument which, const Result<Identity>& answer, const Learned& from);
  // The last question failed. What it said before stays known. `unsupported` is no fault: it cannot
  // be asked.
  void failed(Instrument which, const Error& error, const Learned& from);
  // The same instrument is back, or what was learned of it belongs to a run now.
  void confirmed(Instrument which, const Learned& from);
  // It sent data: what is known of it is as old as they are.
  void heard(Instrument which);
  // Whether the node of its port is there. True: that is news.
  bool set_port_there(Instrument which, bool there);

  bool is_ready(Instrument which) const;
  // False: its port came back, and nobody asked who is there.
  bool is_known(Instrument which) const;
  const std::string& port(Instrument which) const { return of(which).state.port; }
  // `run`: the one that goes on.
  std::vector<InstrumentState> states(std::optional<std::int64_t> run) const;

 private:
  struct Known {
    InstrumentState state;  // its ages are reckoned when somebody asks
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
