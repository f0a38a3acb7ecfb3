// SPDX-License-Identifier: Apache-2.0
// Counts the readings of a run while it is recorded, by the rule of storage/proof.hpp. A reading
// counts until an event says that it is not proven, or the run ends without a read-back after it.
#pragma once

#include <cstdint>
#include <deque>
#include <map>

#include "daemon/record/recorder.hpp"

namespace lcrig {

class ReadingCounts {
 public:
  void add(const Committed& committed);
  // The run has ended: no read-back follows.
  void close();

  std::int64_t readings() const { return readings_; }  // without the unproven ones
  std::int64_t of_levels() const {
    return of_levels_;
  }  // of them, those that `measure` steps count
  std::int64_t unproven() const { return unproven_; }

 private:
  void add(const RunEvent& event);
  void prove_until(MonoTime t);
  void take_back(std::int64_t from_mono_ns, std::int64_t to_mono_ns);
  void abandon(const LevelAbandonedEvent& lost);

  std::deque<CommittedReading> open_;  // asked since the last equal read-back
  bool is_read_back_ = false;  // the run reads its settings back
  // Of each level: readings that were taken back because they are unproven; nullopt: abandoned.
  std::map<std::int64_t, std::optional<std::int64_t>> levels_;
  std::int64_t readings_ = 0, of_levels_ = 0, unproven_ = 0;
};

}  // namespace lcrig
