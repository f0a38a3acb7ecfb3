// SPDX-License-Identifier: Apache-2.0
// Finds a part of the daemon that hangs. Each part that must move counts its beats; one whose count
// stands still for too long is named. App asks, and feeds systemd's watchdog only while none is.
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
  // `beats` grows whenever the part moves; nullopt: it has nothing to do now. `patience` is longer
  // than any honest wait of the part.
  using Beats = std::function<std::optional<std::uint64_t>()>;
  void watch(std::string name, Duration patience, Beats beats);

  // The parts that stand still for longer than their patience, with the time; empty: all is well.
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
};

// How late the event loop serves a periodic task: its own work, or a machine that was suspended.
class LoopLag {
 public:
  explicit LoopLag(Duration tolerated) : tolerated_(tolerated) {}
  // Called when a wait until `due` returned at `now`; the lag when it is worth an event.
  std::optional<Duration> note(MonoTime due, MonoTime now);
  Duration worst() const { return worst_; }

 private:
  Duration tolerated_;
  Duration worst_{};
};

}  // namespace lcrig
