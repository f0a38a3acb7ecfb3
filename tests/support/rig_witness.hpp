// SPDX-License-Identifier: Apache-2.0
// Records for each sample of a simulated frame what it showed, what was true then and when it
// reached the daemon, and every line in both directions. The property tests use it to judge frames
// that lie.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

class RigWitness {
 public:
  struct Seen {
    MonoTime taken;
    std::optional<MonoTime> arrived;  // empty if lost on the way
    FrameSample shown;
    double true_N = 0, true_m = 0;
  };
  struct Word {
    MonoTime at;
    bool is_sent = false;  // by the daemon
    std::string line;
  };

  std::vector<Seen> seen;
  std::vector<Word> words;  // without samples and heartbeats

  void take(MonoTime t, const FrameSample& shown, double true_N, double true_m) {
    Seen& s = seen.emplace_back();
    s.taken = t;
    s.shown = shown;
    s.true_N = true_N;
    s.true_m = true_m;
  }
  void hear(MonoTime at, std::string_view line, bool is_sent) {
    if (line.starts_with("HB")) return;
    if (!is_sent && line.starts_with("S ")) return arrive(at, line);
    words.push_back({at, is_sent, std::string(line)});
  }

 private:
  static std::int64_t field(std::string_view line, std::string_view key) {
    const auto at = line.find(key);
    std::int64_t value = 0;
    if (at == line.npos) return value;
    const char* from = line.data() + at + key.size();
    std::from_chars(from, line.data() + line.size(), value);
    return value;
  }
  // Sequence numbers start again with each session, so the latest sample with this number is meant.
  void arrive(MonoTime at, std::string_view line) {
    const std::int64_t first = field(line, " seq="), last = first + field(line, " n=") - 1;
    for (auto s = seen.rbegin(); s != seen.rend(); ++s) {
      if (s->shown.device_seq > last) continue;
      if (s->shown.device_seq < first || s->arrived) return;
      s->arrived = at;
    }
  }
};

}  // namespace lcrig
