// SPDX-License-Identifier: Apache-2.0
// Finds parts of the daemon that hang. Each part counts its beats; a part whose count stays the
// same for too long is reported. App asks it, and feeds systemd's watchdog only while no part
// hangs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/time.hpp"

namespace lcrig {

class Liveness {
 public:
  // `beats` returns a number that grows while the part moves; nullopt: it has nothing to do.
  // `patience` must exceed any legitimate wait of the part.
  using Beats = std::function<std::optional<std::uint64_t>()>;
  void watch(std::string name, Duration patience, Beats beats);

  // The parts that have hung for longer than their patience, with the time; empty: none. Ask it
  // several times a second: where it was not asked for longer, this process stood still, and no
  // part can have moved.
  std::vector<std::string> check(MonoTime now);

 private:
  struct Part {
    std::string name;
    Duration patience;
    Beats beats;
    std::optional<std::uint64_t> last;
    MonoTime moved;
  };
  std::vector<Part> parts_;
  std::optional<MonoTime> checked_;
};

// Measures how late the event loop runs a periodic task, because of its own work or a suspended
// machine.
class LoopLag {
 public:
  explicit LoopLag(Duration tolerated) : tolerated_(tolerated) {}
  // Call when a wait until `due` returned at `now`. Returns a lag that deserves an event.
  std::optional<Duration> note(MonoTime due, MonoTime now);
  Duration worst() const { return worst_; }

 private:
  Duration tolerated_;
  Duration worst_{};
};

}  // namespace lcrig
