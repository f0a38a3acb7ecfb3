// SPDX-License-Identifier: Apache-2.0
// Decides, without I/O, what the queue does next and what it does after a run. The runner
// (runner.hpp) asks and obeys; storage/queue_run.hpp makes sure that nothing begins otherwise.
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

HoldCause cause_of(Hazard hazard);

// The first entry, as far as it matters here.
struct HeadFacts {
  std::int64_t entry = 0;
  EntryState state = EntryState::waiting;
  std::string protocol, specimen;
  bool moves = true;  // the protocol commands the frame
  QueueTerms terms;
};
struct QueueFacts {
  bool going = false;
  bool run_goes_on = false;  // of whomever
  std::optional<HeadFacts> head;
  std::optional<std::string> on_rig;  // the specimen; nullopt: nobody knows
  std::optional<std::string> probe, fixture;  // likewise
  std::optional<std::string> stranger;  // why what is on the rig may not be that specimen
  bool person_there = false;  // acted since the last run of the queue began
  std::int64_t now_unix_s = 0;
  std::optional<std::int64_t> last_end_unix_s;  // of a run of anybody
};

// When an entry may begin, as far as its terms say: from `now_unix_s` on, and since the last run
// ended. `why` is empty when nothing has to be waited for.
struct BeginTime {
  std::int64_t unix_s = 0;
  std::string why;
};
BeginTime begin_time(const QueueTerms& terms, std::int64_t now_unix_s,
                     std::optional<std::int64_t> last_end_unix_s);
// Errors: invalid_request, when it could never begin.
Result<> check_begin(const QueueTerms& terms, std::int64_t now_unix_s);

// Something that a person has to do before an entry begins.
struct Gate {
  QueueGate kind = QueueGate::person;
  std::int64_t entry = 0;
  std::string prompt, expected;
};
// Errors: invalid_request, in words for who typed it. Nothing but the expected word opens a gate.
Result<> check_answer(const Gate& gate, std::string_view answer);

struct Stay {};  // held, or a run goes on
struct Finished {};  // it goes, and nothing is left
struct Begin {
  std::int64_t entry = 0;
};
struct WaitUntil {  // a time; nobody need act
  std::int64_t entry = 0, unix_s = 0;
  std::string why;
};
struct TooLate {  // it was to begin before a time that has passed
  std::int64_t entry = 0;
  std::string why;
};
using NextAct = std::variant<Stay, Finished, Gate, Begin, WaitUntil, TooLate>;
NextAct next_act(const QueueFacts& facts);

// How an entry came out.
struct EntryOutcome {
  bool begun = false;  // false: it was refused before anything was commanded
  bool resumes = false;  // an interrupted run was to go on
  ExitStatus status = ExitStatus::fail;
  std::optional<Errc> code;
  std::string reason;
  std::optional<Hazard> hazard;
};
// Consequences of an outcome for the entry and the queue. `attempts`: of this entry, with this one
// if it begun.
EntryEnd aftermath_of(const EntryOutcome& outcome, const QueueTerms& terms, std::int64_t attempts,
                      std::int64_t failures_in_row);

}  // namespace lcrig
