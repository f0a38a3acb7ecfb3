// SPDX-License-Identifier: Apache-2.0
// Enumerations of the queue and of batches, each with its words (docs/queue.md). The daemon decides
// by the enums. Their words are part of the formats of the database, the control socket, batch
// files and the command line.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

// State of an entry. The first four occur in the queue; `running`, `interrupted` and `failed` only
// at its head.
enum class EntryState { waiting, running, interrupted, failed, done, skipped, removed };
template <>
inline constexpr EnumWords<7> kWordsOf<EntryState>{"waiting", "running", "interrupted", "failed",
                                                   "done",    "skipped", "removed"};

// Why the queue does not start the next entry.
enum class HoldCause {
  not_started,
  person,  // a person held it
  restart,  // lcrigd was restarted
  empty,  // no entry is left
  // A Hazard (daemon/queue/hazard.hpp), the worst one first.
  not_standing,  // the frame did not confirm standstill
  left_loaded,  // the specimen is still loaded, or may be
  frame_fault,  // E-stop, drive, shield, not_ready; or the frame is not believed
  limit,  // of the protocol or the machine was reached
  other_instrument,  // another identity answered at a port
  // No hazards.
  aborted,  // a person or a signal stopped the run
  failure,  // an entry failed: its terms say to hold, or no terms may decide about this failure
  look,  // an entry failed: it gets one more attempt once a person has looked
  too_many_failures,
  clock_step,  // somebody set the clock while an entry waited for a time of day
  bug
};
template <>
inline constexpr EnumWords<15> kWordsOf<HoldCause>{
    "not_started",       "person",      "restart",     "empty",
    "not_standing",      "left_loaded", "frame_fault", "limit",
    "other_instrument",  "aborted",     "failure",     "look",
    "too_many_failures", "clock_step",  "bug"};

// What the first entry waits for while the queue runs.
enum class QueueGate {
  specimen,  // a person mounts it and types its name
  probe,
  fixture,
  stranger,  // the capacitance is not that of the specimen: a person looks, and types the name to
             // go on
  person,  // a person is present while the frame moves, and types "yes"
  time  // nobody has to act
};
template <>
inline constexpr EnumWords<6> kWordsOf<QueueGate>{"specimen", "probe",  "fixture",
                                                  "stranger", "person", "time"};

// What a person chose for a head that was interrupted or failed.
enum class HeadChoice { none, resume, repeat, skip };
template <>
inline constexpr EnumWords<4> kWordsOf<HeadChoice>{"none", "resume", "repeat", "skip"};

// What the queue does after an entry failed.
enum class OnFailure {
  hold,  // holds until a person decides
  skip,
  look,  // holds; once a person has looked, `queue start` repeats the entry, once
  repeat  // repeats it at once, but only if the failure did not touch the specimen
};
template <>
inline constexpr EnumWords<4> kWordsOf<OnFailure>{"hold", "skip", "look", "repeat"};

// The order in which the runs of a batch are queued.
enum class BatchOrder {
  given,  // row by row, with the repeats of a row one after another
  blocks,  // all runs of a specimen together, specimens as in the table, in random order within a
           // specimen
  random
};
template <>
inline constexpr EnumWords<3> kWordsOf<BatchOrder>{"given", "blocks", "random"};

}  // namespace lcrig
