// SPDX-License-Identifier: Apache-2.0
// Enumerations of the queue and of batches, each with its words (docs/queue.md). The daemon decides
// by them; the database, the control socket, batch files and the command line hold the words, which
// are part of their formats.
#pragma once

#include "base/enum_words.hpp"

namespace lcrig {

// State of an entry. In the queue: the first four. `running`, `interrupted` and `failed` are at its
// head only.
enum class EntryState { waiting, running, interrupted, failed, done, skipped, removed };
template <>
inline constexpr EnumWords<7> kWordsOf<EntryState>{"waiting", "running", "interrupted", "failed",
                                                   "done",    "skipped", "removed"};

// The reason why the queue does not go.
enum class HoldCause {
  not_started,
  person,  // said so
  restart,  // of lcrigd
  empty,  // nothing is left in it
  not_standing,  // this and the next four: a Hazard (daemon/queue/hazard.hpp)
  left_loaded,
  frame_fault,
  limit,
  other_instrument,
  aborted,  // a person or a signal stopped the run
  failure,  // of an entry whose terms say so, or that no terms may decide on
  look,  // the same: one more attempt once a person has looked
  too_many_failures,
  clock_step,  // somebody set the clock while an entry waited for a time
  bug
};
template <>
inline constexpr EnumWords<15> kWordsOf<HoldCause>{
    "not_started",       "person",      "restart",     "empty",
    "not_standing",      "left_loaded", "frame_fault", "limit",
    "other_instrument",  "aborted",     "failure",     "look",
    "too_many_failures", "clock_step",  "bug"};

// Something that the first entry waits for while the queue goes.
enum class QueueGate {
  specimen,  // a person puts it on, and types its name
  probe,
  fixture,
  stranger,  // its capacitance is not that of the specimen: look, and type the name all the same
  person,  // be there while the frame moves, and type "yes"
  time  // nobody need act
};
template <>
inline constexpr EnumWords<6> kWordsOf<QueueGate>{"specimen", "probe",  "fixture",
                                                  "stranger", "person", "time"};

// The choice for a head that was interrupted or failed.
enum class HeadChoice { none, resume, repeat, skip };
template <>
inline constexpr EnumWords<4> kWordsOf<HeadChoice>{"none", "resume", "repeat", "skip"};

// The policy after an entry failed.
enum class OnFailure {
  hold,  // the queue, until a person says what is to be done
  skip,
  look,  // hold; once a person has looked, `queue start` repeats the entry, once
  repeat  // at once, and only after what did not touch the specimen
};
template <>
inline constexpr EnumWords<4> kWordsOf<OnFailure>{"hold", "skip", "look", "repeat"};

// The order in which the runs of a batch are queued.
enum class BatchOrder {
  given,  // row by row, the repeats of a row behind each other
  blocks,  // a specimen's runs together, specimens as in the table; by chance within
  random
};
template <>
inline constexpr EnumWords<3> kWordsOf<BatchOrder>{"given", "blocks", "random"};

}  // namespace lcrig
