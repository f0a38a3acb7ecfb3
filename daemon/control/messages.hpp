// SPDX-License-Identifier: Apache-2.0
// The messages of the control socket: JSON-RPC 2.0, one message per line. docs/control.md is the
// contract. Plain structs here (SI inside), lab units on the wire. The daemon and `lcrig` use them.
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

constexpr std::size_t kControlLineLimit = std::size_t{1} << 20U;  // bytes, without the newline

// The process at the other end (SO_PEERCRED). `user` is the name of `uid` as far as it is known, or
// "uid 1000" (UserNames).
struct PeerCredentials {
  std::uint32_t uid = 0;
  std::int32_t pid = 0;
  std::string user;
};

struct RunStarted {
  std::int64_t run = 0;
};

// An answer to the question that waits. `question`: only if it is this one (OpenQuestion::number).
struct AnswerRequest {
  AnswerValue value = true;
  std::optional<std::int64_t> question;
};

struct TagRequest {
  std::int64_t run = 0;
  std::vector<std::string> tags;
  bool remove = false;
};

// Result of an abort or a freeze, or of a stop or a pause that waits.
enum class StopState {
  standing,  // the frame confirmed it after this request
  finally,  // it is running and goes on
  not_begun,  // the run was being prepared and does not begin
  not_ours,  // the frame was only observed
  later,  // at the end of what is under way
};
std::string_view to_string(StopState s);

struct StopAnswer {
  StopAnswer(StopState s, std::string n) : state(s), note(std::move(n)) {}
  StopState state;
  std::string note;  // in words
};

// Condition of an instrument. `unasked`: nobody asked it since the daemon began, or since its port
// came back.
enum class InstrumentCondition { unasked, ready, in_use, absent, fault };
std::string_view to_string(InstrumentCondition c);

// Where the daemon knows it from.
enum class LearnedBy {
  nothing,  // it is not
  look,  // somebody asked the instrument who it is, or the daemon did by itself
  plan,  // asked for a plan of a run
  start,  // asked for a run that did not begin
  run,  // a run used it
  rescue,  // the frame was stopped after a crash
  port  // the node of its port went away
};
std::string_view to_string(LearnedBy l);

struct InstrumentState {
  Instrument which = Instrument::lcr;
  std::string port;
  InstrumentCondition condition = InstrumentCondition::unasked;
  std::string why;  // it is unasked, absent or at fault; in words
  std::string identity;  // as the instrument sent it last; empty while unknown
  bool simulated = false;
  LearnedBy learned_by = LearnedBy::nothing;
  std::optional<std::int64_t> run;  // that it is in use by, or that it was learned by
  std::optional<double> age_s;  // since it was asked, or sent data; none: it was not
  std::optional<double> since_s;  // in this condition
};

// A run that a crash cut off and `run.resume` can continue.
struct ResumableRun {
  std::int64_t run = 0;
  std::string protocol, specimen;
  std::string step_id;  // begun last; it begins anew
};

// The queue at a glance (docs/queue.md).
struct QueueStatus {
  bool going = false;
  std::optional<HoldCause> cause;  // when it does not go
  std::string why;
  std::int64_t count = 0;  // of the entries in it
  std::optional<std::int64_t> entry;  // the first of them
  std::optional<QueueGate> gate;  // that it waits for; none also of a kind that is not known here
  std::string prompt;  // the same in words; empty: it waits for nothing
  std::string locked_by;  // empty: nobody
};

struct DaemonStatus {
  std::string version, database;
  std::vector<InstrumentState> instruments;
  std::optional<RunStatus> run;  // the run that is going on
  bool correcting = false;  // the meter's open or short correction is being made
  std::optional<RunOutcome> last_run;  // the last one of this daemon's life
  std::vector<ResumableRun> resumable;  // cut off since any other run began; oldest first
  std::optional<QueueStatus> queue;
};

// An event row of a run, as a watcher sees it.
struct RunEventNote {
  std::int64_t run = 0;
  RunEvent event;
};

// Codes of an error answer. Every Errc has one; JSON-RPC's own keep their meaning.
namespace rpc_code {
constexpr int kParseError = -32700;
constexpr int kInvalidRequest = -32600;
constexpr int kMethodNotFound = -32601;
constexpr int kInvalidParams = -32602;
constexpr int kLineTooLong = -32020;
constexpr int kTooManyClients = -32021;
constexpr int kTooManyCalls = -32022;  // of one client at the same time
}  // namespace rpc_code
int rpc_code_of(Errc code);

// What to do next: words alone, or a command with words before or behind it.
template <class Text>
struct BasicHint {
  Text before, command, remark;
};
using HintWords = BasicHint<std::string_view>;  // of a table
struct Hint : BasicHint<std::string> {
  Hint() = default;
  Hint(std::string words) { before = std::move(words); }
  Hint(const char* words) : Hint(std::string(words)) {}
  Hint(const HintWords& words);
  // "lcrig status   (what goes on)"; `options` come behind the command.
  std::string text(std::string_view options = {}) const;
};

struct RpcError {
  RpcError() = default;
  RpcError(int c, std::string m, Hint h) : code(c), message(std::move(m)), hint(std::move(h)) {}
  int code = 0;
  std::string message;
  Hint hint;
  std::string detail;  // lines below the message: each wrong cell of a table
  Errc errc = Errc::invalid_request;
};
RpcError rpc_error_of(const Error& error);

// Wire forms. The parsers refuse a wrong type and name the JSON pointer; members that they do not
// know are ignored in answers and refused in requests.
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
