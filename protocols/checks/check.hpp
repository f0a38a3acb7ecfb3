// SPDX-License-Identifier: Apache-2.0
// The checks of the watch over the frame: a table. Each row looks at one sample (or at the clock),
// says what is in doubt and how the run responds. No check knows another, and none acts:
// run/response responds. `lcrig watch checks` prints the table.
//
// A new check is a file with its function, and a row in table.cpp.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "events/event_kind.hpp"
#include "protocols/rig/rig_state.hpp"

namespace lcrig {

// What is no longer valid once a check finds something.
enum class Doubt {
  nothing,  // the rig works, and a limit was reached
  prediction,  // specimen or frame are not what they were said to be
  standstill,  // the frame moved without a command
  force,  // the cell: only a retreat is certain to unload it
  drive,  // the frame does not do what it was ordered
  link  // nothing is known
};
template <>
inline constexpr EnumWords<6> kWordsOf<Doubt>{"nothing", "prediction", "standstill",
                                              "force",   "drive",      "link"};

// By severity: the most severe one of a sample counts.
enum class Response {
  note,  // an event
  no_pressing,  // an event, and nothing is pressed any more
  stop,  // stop, then `finally`
  stop_and_retreat,  // stop, then `finally` without the force: it may only retreat
  lose,  // stop, and wait for the frame
  lock_out  // stop, and nothing moves until a person has looked
};
template <>
inline constexpr EnumWords<6> kWordsOf<Response>{"note", "no_pressing", "stop", "stop_and_retreat",
                                                 "lose", "lock_out"};

// When a check applies, and the same in words.
struct When {
  std::string_view words;
  bool (*holds)(const RigState& rig);
};

// What a check looks at, besides the state of the rig, which has taken the sample already.
struct Sight {
  const FrameSample& sample;
  const std::optional<ForceComparison>& compared;  // late, of the last motion that pressed
};

struct Check {
  std::string_view name;
  When when;
  std::string_view looks_at;
  Doubt doubt;
  Response response;
  EventKind event;
  // Returns words for people, or a payload of the event. nullptr: it looks at the clock.
  std::optional<std::string> (*find)(const RigState& rig, const Sight& sight);
  std::optional<std::string> (*find_by_clock)(const RigState& rig, MonoTime now) = nullptr;
};

struct Finding {
  Finding(const Check& c, std::string w) : check(&c), why(std::move(w)) {}
  const Check* check;
  std::string why;
};

std::span<const Check> all_checks();

// What the checks find in a sample that `rig` has taken, in the order of the table.
std::vector<Finding> find(const RigState& rig, const Sight& sight);
// What is found without a sample: none comes.
std::optional<Finding> find_silence(const RigState& rig, MonoTime now);
// The most severe one; the first of several. nullptr: there is none that does more than note.
const Finding* most_severe(std::span<const Finding> findings);

}  // namespace lcrig
