// SPDX-License-Identifier: Apache-2.0
// Decides, without I/O, what the queue does next, and what follows from the end of a run. The
// runner (runner.hpp) carries out these decisions; storage/queue_run.hpp ensures that nothing else
// begins.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "base/exit_status.hpp"
#include "base/queue_words.hpp"
#include "daemon/queue/hazard.hpp"
#include "daemon/queue/terms.hpp"
#include "storage/queue_run.hpp"

namespace lcrig {

// What matters here about the first entry.
struct HeadFacts {
  std::int64_t entry = 0;
  EntryState state = EntryState::waiting;
  std::string protocol, specimen;
  bool moves = true;  // whether the protocol commands the frame
  QueueTerms terms;
};
struct QueueFacts {
  bool going = false;
  bool run_goes_on = false;  // any run, not only the queue's
  std::optional<HeadFacts> head;
  std::optional<std::string> on_rig;  // name of the specimen; nullopt: unknown
  std::optional<std::string> probe, fixture;  // nullopt: unknown
  std::optional<std::string> stranger;  // why the specimen on the rig may be another one
  bool person_there = false;  // a person has acted since the queue's last run began
  std::int64_t now_unix_s = 0;
  std::optional<std::int64_t> last_end_unix_s;  // of any run
};

// When an entry may begin by its terms, given the present time and the end of the last run. `why`
// is empty when it need not wait.
struct BeginTime {
  std::int64_t unix_s = 0;
  std::string why;
};
BeginTime begin_time(const QueueTerms& terms, std::int64_t now_unix_s,
                     std::optional<std::int64_t> last_end_unix_s);
// Errors: invalid_request, when the entry could never begin.
Result<> check_begin(const QueueTerms& terms, std::int64_t now_unix_s);

// Something that a person has to do before an entry begins.
struct Gate {
  QueueGate kind = QueueGate::person;
  std::int64_t entry = 0;
  std::string prompt, expected;
};
// Errors: invalid_request, in words for the person who typed the answer. Only the expected word
// opens a gate.
Result<> check_answer(const Gate& gate, std::string_view answer);

struct Stay {};  // the queue is held, or a run goes on
struct Finished {};  // the queue goes, but no entry is left
struct Begin {
  std::int64_t entry = 0;
};
struct WaitUntil {  // waits for a time; nobody has to act
  std::int64_t entry = 0, unix_s = 0;
  std::string why;
};
struct TooLate {  // the latest time for its begin has passed
  std::int64_t entry = 0;
  std::string why;
};
using NextAct = std::variant<Stay, Finished, Gate, Begin, WaitUntil, TooLate>;
NextAct next_act(const QueueFacts& facts);

// How the attempt of an entry ended.
struct EntryOutcome {
  bool begun = false;  // false: it was refused before any command
  bool resumes = false;  // it was to continue an interrupted run
  ExitStatus status = ExitStatus::fail;
  std::optional<Errc> code;
  std::string reason;
  std::optional<Hazard> hazard;
};
// What an outcome means for the entry and the queue. `attempts`: of this entry, including this one
// if it began.
EntryEnd aftermath_of(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                      std::int64_t failures_in_row);

}  // namespace lcrig
