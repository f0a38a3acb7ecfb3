// SPDX-License-Identifier: Apache-2.0
// The messages of the control socket: JSON-RPC 2.0, one message per line. docs/control.md is the
// contract. The structs use SI, the wire uses the lab's units. Used by the daemon and `lcrig`.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/queue_words.hpp"
#include "base/result.hpp"
#include "daemon/run_request.hpp"
#include "protocols/run/sink.hpp"
#include "protocols/stop_places.hpp"

namespace lcrig {

// The stop that needs no control socket (docs/control.md).
constexpr const char* kStopBySignal =
    "systemctl stop lcrigd   (SIGTERM: aborts the run, unloads, ends the daemon)";

constexpr std::size_t kControlLineLimit = std::size_t{1} << 20U;  // bytes, without the newline

// The process at the other end (SO_PEERCRED). `user` is the name of `uid` if it is known, else "uid
// 1000" (UserNames).
struct PeerCredentials {
  std::uint32_t uid = 0;
  std::int32_t pid = 0;
  std::string user;
};

struct RunStarted {
  std::int64_t run = 0;
  std::optional<PressureArea> pressure;  // what its pressures are over; absent: it goes on
};

// A specimen file for the database. Without `as_stated`, implausible values are refused.
struct SpecimenToAdd {
  std::string text;
  bool as_stated = false;
};

// An answer to the open question. With `question`, only to the one with this number
// (OpenQuestion::number).
struct AnswerRequest {
  AnswerValue value = true;
  std::optional<std::int64_t> question;
};

struct TagRequest {
  std::int64_t run = 0;
  std::vector<std::string> tags;
  bool remove = false;
};

// The result of an abort or a freeze, or of a planned stop or pause.
enum class StopState {
  standing,  // the frame confirmed standstill after this request
  finally,  // `finally` is running and goes on
  not_begun,  // the run was being prepared and does not begin
  not_ours,  // the frame was only observed, so it was not stopped
  later,  // at the end of the current part
};
template <>
inline constexpr EnumWords<5> kWordsOf<StopState>{"standing", "finally", "not_begun", "not_ours",
                                                  "later"};

struct StopAnswer {
  StopAnswer(StopState s, std::string n) : state(s), note(std::move(n)) {}
  StopState state;
  std::string note;  // in words
};

// Condition of an instrument. `unasked`: nobody has asked it since the daemon started, or since its
// port came back.
enum class InstrumentCondition { unasked, ready, in_use, absent, fault };
template <>
inline constexpr EnumWords<5> kWordsOf<InstrumentCondition>{"unasked", "ready", "in_use", "absent",
                                                            "fault"};

// How the daemon knows the condition.
enum class LearnedBy {
  nothing,  // it does not know it
  look,  // the instrument's identity was asked, by a person or by the daemon
  plan,  // asked when a run was planned
  start,  // asked for a run that then did not begin
  run,  // a run used it
  rescue,  // the frame was stopped after a crash
  port  // the device node of its port went away
};
template <>
inline constexpr EnumWords<7> kWordsOf<LearnedBy>{"nothing", "look",   "plan", "start",
                                                  "run",     "rescue", "port"};

struct InstrumentState {
  Instrument which = Instrument::lcr;
  std::string port;
  InstrumentCondition condition = InstrumentCondition::unasked;
  std::string why;  // reason why it is unasked, absent or at fault
  std::string identity;  // its latest reply; empty while unknown
  bool simulated = false;
  LearnedBy learned_by = LearnedBy::nothing;
  std::optional<std::int64_t> run;  // the run that uses it, or that reported its condition
  std::optional<double> age_s;  // since its last answer or data; none: there was none
  std::optional<double> since_s;  // time in this condition
  // Of the frame: whether it is known what its gateway states, and the keys of the config file for
  // what neither states, though a run may need it (drivers/stated_frame.hpp).
  bool statements_known = false;
  std::vector<std::string> unstated;
};

// A run that a crash cut off and that `run.resume` can continue.
struct ResumableRun {
  std::int64_t run = 0;
  std::string protocol, specimen;
  std::string step_id;  // begun last; begins again
};

// Overview of the queue (docs/queue.md).
struct QueueStatus {
  bool going = false;
  std::optional<HoldCause> cause;  // set when it does not go
  std::string why;
  std::int64_t count = 0;  // number of entries in it
  std::optional<std::int64_t> entry;  // its first entry
  std::optional<QueueGate> gate;  // the gate it waits at; empty also for an unknown kind
  std::string prompt;  // the gate in words; empty: it does not wait
  std::string locked_by;  // empty: nobody
};

struct DaemonStatus {
  std::string version, database;
  std::vector<InstrumentState> instruments;
  std::optional<RunStatus> run;  // the current run
  bool correcting = false;  // the meter is being corrected
  std::optional<RunOutcome> last_run;  // the last one since the daemon started
  std::vector<ResumableRun> resumable;  // cut off after the last other run began; oldest first
  std::optional<QueueStatus> queue;
  std::string socket_trouble;  // why no new client finds the daemon; empty: they do
};

// An event row of a run, as watchers get it.
struct RunEventNote {
  std::int64_t run = 0;
  RunEvent event;
};

// Codes of error answers. Every Errc has one; the codes of JSON-RPC keep their meaning.
namespace rpc_code {
constexpr int kParseError = -32700;
constexpr int kInvalidRequest = -32600;
constexpr int kMethodNotFound = -32601;
constexpr int kInvalidParams = -32602;
constexpr int kLineTooLong = -32020;
constexpr int kTooManyClients = -32021;
constexpr int kTooManyCalls = -32022;  // too many simultaneous calls of one client
}  // namespace rpc_code
int rpc_code_of(Errc code);

// What to do next: words alone, or a command with words before or after it.
template <class Text>
struct BasicHint {
  Text before, command, remark;
};
using HintWords = BasicHint<std::string_view>;  // for tables
struct Hint : BasicHint<std::string> {
  Hint() = default;
  Hint(std::string words) { before = std::move(words); }
  Hint(const char* words) : Hint(std::string(words)) {}
  Hint(const HintWords& words);
  // "lcrig status   (what goes on)"; `options` follow the command.
  std::string text(std::string_view options = {}) const;
};

struct RpcError {
  RpcError() = default;
  RpcError(int c, std::string m, Hint h) : code(c), message(std::move(m)), hint(std::move(h)) {}
  int code = 0;
  std::string message;
  Hint hint;
  std::string detail;  // lines below the message, e.g. each wrong cell of a table
  Errc errc = Errc::invalid_request;
};
RpcError rpc_error_of(const Error& error);

// Conversions to and from JSON. The parsers refuse wrong types and name the JSON pointer. They
// ignore unknown members in answers and refuse them in requests.
nlohmann::json to_json(const RunStatus& status);
nlohmann::json to_json(const RunOutcome& ended);
nlohmann::json to_json(const StopAnswer& answer);
nlohmann::json to_json(const RunEventNote& note);
nlohmann::json to_json(const DaemonStatus& status);
nlohmann::json to_json(const QueueStatus& status);
nlohmann::json to_json(const RunRequest& request);
Result<RunStatus> parse_run_status(const nlohmann::json& value);
Result<RunOutcome> parse_run_outcome(const nlohmann::json& value);
Result<RunEventNote> parse_run_event(const nlohmann::json& value);
Result<DaemonStatus> parse_daemon_status(const nlohmann::json& value);
Result<QueueStatus> parse_queue_status(const nlohmann::json& value);
Result<RunRequest> parse_run_request(const nlohmann::json& params);
nlohmann::json to_json(const Answered& answered);
nlohmann::json to_json(const AnswerRequest& request);
Result<AnswerRequest> parse_answer_request(const nlohmann::json& params);
nlohmann::json to_json(const TagRequest& request);
Result<TagRequest> parse_tag_request(const nlohmann::json& params);

// Whole lines, with their newline. `id` is a JSON string, number or null.
std::string request_line(std::int64_t id, std::string_view method, const nlohmann::json& params);
std::string answer_line(const nlohmann::json& id, const nlohmann::json& result);
std::string error_line(const nlohmann::json& id, const RpcError& error);
std::string notification_line(std::string_view method, const nlohmann::json& params);

}  // namespace lcrig
