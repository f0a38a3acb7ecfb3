// SPDX-License-Identifier: Apache-2.0
// Enumerations of the queue and of batches, each with its words (docs/queue.md). The daemon decides
// by them; the database, the control socket, batch files and the command line hold the words, which
// are part of their formats.
#pragma once

#include <string_view>

namespace lcrig {

// State of an entry. In the queue: the first four. `running`, `interrupted` and `failed` are at its
// head only.
enum class EntryState { waiting, running, interrupted, failed, done, skipped, removed };
std::string_view to_string(EntryState state);

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
std::string_view to_string(HoldCause cause);

// Something that the first entry waits for while the queue goes.
enum class QueueGate {
  specimen,  // a person puts it on, and types its name
  probe,
  fixture,
  stranger,  // its capacitance is not that of the specimen: look, and type the name all the same
  person,  // be there while the frame moves, and type "yes"
  time  // nobody need act
};
std::string_view to_string(QueueGate gate);

// The choice for a head that was interrupted or failed.
enum class HeadChoice { none, resume, repeat, skip };
std::string_view to_string(HeadChoice choice);

// The policy after an entry failed.
enum class OnFailure {
  hold,  // the queue, until a person says what is to be done
  skip,
  look,  // hold; once a person has looked, `queue start` repeats the entry, once
  repeat  // at once, and only after what did not touch the specimen
};
std::string_view to_string(OnFailure policy);

// The order in which the runs of a batch are queued.
enum class BatchOrder {
  given,  // row by row, the repeats of a row behind each other
  blocks,  // a specimen's runs together, specimens as in the table; by chance within
  random
};
std::string_view to_string(BatchOrder order);

}  // namespace lcrig
