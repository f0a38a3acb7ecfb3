// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/messages.hpp"

#include "base/decimal.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

struct ErrcRow {
  Errc errc;
  int code;
  std::string_view hint;
};
constexpr std::array<ErrcRow, 14> kErrcs{{
    {Errc::no_reply, -32001,
     "check cable, power and the instrument's port choice, then: lcrig status"},
    {Errc::reply_cut_off, -32002, "check the cable, then: lcrig status"},
    {Errc::garbled, -32003, "check that the right instrument is on this port, then: lcrig status"},
    {Errc::refused, -32004, "the instrument did not take it: change the protocol's settings"},
    {Errc::unsupported, -32011, "this instrument cannot do that: use another one"},
    {Errc::not_standing, -32012, "standstill not confirmed: use the E-stop, then look at the rig"},
    {Errc::frame_fault, -32013, "look at the frame, clear its fault, unload it by hand, run again"},
    {Errc::disconnected, -32005, "see to what the message names, then: lcrig status --ask"},
    {Errc::busy, -32006, "lcrig status   (what goes on; lcrig abort ends it)"},
    {Errc::limit_tripped, -32007, "a limit was reached: check specimen and limits, then run again"},
    {Errc::invalid_request, -32008, "correct the request"},
    {Errc::aborted, -32009, "it was stopped: start it again when the cause is gone"},
    {Errc::io, -32010, "the operating system refused; the message says what and why"},
    {Errc::bug, -32603, "a fault of this program: report it with the wire log"},
}};

const ErrcRow& row_of(Errc errc) {
  for (const auto& row : kErrcs) {
    if (row.errc == errc) return row;
  }
  return kErrcs.back();
}

std::optional<Errc> errc_of_word(std::string_view word) {
  for (const auto& row : kErrcs) {
    if (to_string(row.errc) == word) return row.errc;
  }
  return std::nullopt;
}

json to_json(const AnswerValue& value) {
  return std::visit([](const auto& v) { return json(v); }, value);
}

// The question that waits; null: none.
json question_json(const RunStatus& s) {
  if (!s.question) return nullptr;
  const Question& q = s.question->question;
  json out{{"number", s.question->number},
           {"step", q.step_id},
           {"text", q.text},
           {"answer", to_string(q.type)},
           {"on_timeout", to_string(q.on_timeout)}};
  out["left_s"] = nullptr;
  if (s.question_left_s) out["left_s"] = *s.question_left_s;
  out["default"] = nullptr;
  if (q.fallback) out["default"] = to_json(*q.fallback);
  if (q.type == AnswerType::choice) out["choices"] = q.choices;
  if (q.type == AnswerType::number) {
    out["unit"] = q.unit;
    out["min"] = q.min;
    out["max"] = q.max;
  }
  return out;
}

json optional_number(const std::optional<double>& value, int power) {
  if (!value) return nullptr;
  return shift_decimal(*value, power);
}

// Replaces bytes that are no UTF-8 (a file name, an instrument's words) instead of throwing.
std::string line_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

// A member that is one of the words of an enumeration, whose last value is `last`.
template <class Enum>
void read_word(ParamsReader& in, const char* key, Enum last, Enum& out) {
  std::string word;
  in.text(key, word, true);
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    out = static_cast<Enum>(i);
    if (to_string(out) == word) return;
  }
  in.fail_with(Error(Errc::garbled, fmt::format("{}: unknown word", in.pointer(key))));
}

json to_json(const InstrumentState& i) {
  json out{{"name", to_string(i.which)},
           {"port", i.port},
           {"why", i.why},
           {"state", to_string(i.condition)},
           {"identity", i.identity},
           {"simulated", i.simulated},
           {"run", nullptr},
           {"learned_by", to_string(i.learned_by)}};
  if (i.run) out["run"] = *i.run;
  out["age_s"] = optional_number(i.age_s, 0);
  out["since_s"] = optional_number(i.since_s, 0);
  return out;
}

// The words of older daemons are sentences.
void read_condition(ParamsReader& in, InstrumentState& out) {
  std::string word;
  in.text("state", word, true);
  for (int i = 0; i <= static_cast<int>(InstrumentCondition::fault); ++i) {
    out.condition = static_cast<InstrumentCondition>(i);
    if (to_string(out.condition) == word) return;
  }
  out.condition = InstrumentCondition::unasked;
  if (out.why.empty()) out.why = word;
}

Result<std::vector<InstrumentState>> parse_instruments(const json& list) {
  if (!list.is_array()) return fail(Errc::garbled, "/instruments: expected an array");
  std::vector<InstrumentState> out;
  for (const auto& item : list) {
    InstrumentState state;
    ParamsReader in(item, "/instruments/" + std::to_string(out.size()));
    read_word(in, "name", Instrument::frame, state.which);
    in.text("port", state.port);
    in.text("why", state.why);
    read_condition(in, state);
    in.text("identity", state.identity);
    in.boolean("simulated", state.simulated);
    // Older daemons do not say it.
    if (in.member("learned_by") != nullptr) {
      read_word(in, "learned_by", LearnedBy::port, state.learned_by);
    }
    if (in.member("run") != nullptr) in.integer("run", state.run.emplace());
    in.quantity("age_s", state.age_s, 0);
    in.quantity("since_s", state.since_s, 0);
    if (auto done = in.finish(); !done) return fail(done.error());
    out.push_back(std::move(state));
  }
  return out;
}

std::optional<AnswerValue> answer_value(const json* value) {
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return AnswerValue(value->get<bool>());
  if (value->is_number()) return AnswerValue(value->get<double>());
  if (value->is_string()) return AnswerValue(value->get<std::string>());
  return std::nullopt;
}

Result<OpenQuestion> parse_question(const json& value, std::optional<double>& left_s) {
  OpenQuestion open;
  Question& q = open.question;
  ParamsReader in(value, "/question");
  in.integer("number", open.number, true);
  in.text("step", q.step_id, true);
  in.text("text", q.text, true);
  read_word(in, "answer", AnswerType::line, q.type);
  read_word(in, "on_timeout", OnTimeout::use_default, q.on_timeout);
  in.quantity("left_s", left_s, 0);
  q.fallback = answer_value(in.member("default"));
  in.text("unit", q.unit);
  in.number("min", q.min);
  in.number("max", q.max);
  if (const auto* choices = in.member("choices"); choices != nullptr && choices->is_array()) {
    for (const json& choice : *choices) {
      if (choice.is_string()) q.choices.push_back(choice.get<std::string>());
    }
  }
  if (auto done = in.finish(); !done) return fail(done.error());
  return open;
}

Result<std::vector<ResumableRun>> parse_resumable(const json& list) {
  if (!list.is_array()) return fail(Errc::garbled, "/resumable: expected an array");
  std::vector<ResumableRun> out;
  for (const auto& item : list) {
    ResumableRun& r = out.emplace_back();
    ParamsReader in(item, "/resumable/" + std::to_string(out.size() - 1));
    in.integer("run", r.run, true);
    in.text("protocol", r.protocol);
    in.text("specimen", r.specimen);
    in.text("step", r.step_id);
    if (auto done = in.finish(); !done) return fail(done.error());
  }
  return out;
}

}  // namespace

std::string_view to_string(InstrumentCondition c) {
  constexpr std::string_view kWords[] = {"unasked", "ready", "in_use", "absent", "fault"};
  return kWords[static_cast<std::size_t>(c)];
}

std::string_view to_string(StopState s) {
  constexpr std::string_view kWords[] = {"standing", "finally", "not_begun", "not_ours", "later"};
  return kWords[static_cast<std::size_t>(s)];
}

std::string_view to_string(LearnedBy l) {
  constexpr std::string_view kWords[] = {"nothing", "look",   "plan", "start",
                                         "run",     "rescue", "port"};
  return kWords[static_cast<std::size_t>(l)];
}

int rpc_code_of(Errc code) {
  return row_of(code).code;
}

RpcError rpc_error_of(const Error& error) {
  const auto& row = row_of(error.code);
  constexpr std::size_t kLongest = 4000;  // it may quote a file or an instrument
  RpcError out(row.code, printable(error.what, kLongest), std::string(row.hint));
  out.errc = error.code;
  out.detail = printable_lines(error.detail);
  return out;
}

json to_json(const RunStatus& s) {
  return json{{"run", s.run},
              {"protocol", s.protocol},
              {"specimen", s.specimen},
              {"simulated", s.simulated},
              {"state", to_string(s.state)},
              {"step", s.step_id},
              {"step_kind", s.step_kind},
              {"prompt", s.prompt},
              {"question", question_json(s)},
              {"stops_after", s.stops_after.empty() ? json() : json(s.stops_after)},
              {"pauses_at", s.pauses_at.empty() ? json() : json(s.pauses_at)},
              {"repeat", s.repeat},
              {"repeats", s.repeats},
              {"elapsed_s", s.elapsed_s},
              {"planned_s", s.planned_s},
              {"left_s", s.left_s},
              {"lcr_readings", s.lcr_readings},
              {"measure_readings", s.measure_readings},
              {"frame_samples", s.frame_samples},
              {"capacitance_pF", optional_number(s.capacitance_F, 12)},
              {"secondary", optional_number(s.secondary, 0)},
              {"force_N", optional_number(s.force_N, 0)},
              {"travel_mm", optional_number(s.travel_m, 3)},
              {"gap_mm", optional_number(s.gap_m, 3)},
              {"pressure_kPa", optional_number(s.pressure_Pa, -3)}};
}

Result<RunStatus> parse_run_status(const json& value) {
  RunStatus s;
  ParamsReader in(value, "");
  in.integer("run", s.run, true);
  in.text("protocol", s.protocol);
  in.text("specimen", s.specimen);
  in.boolean("simulated", s.simulated);
  read_word(in, "state", RunState::ended, s.state);
  in.text("step", s.step_id);
  in.text("step_kind", s.step_kind);
  in.text("prompt", s.prompt);
  in.integer("repeat", s.repeat);
  in.integer("repeats", s.repeats);
  in.number("elapsed_s", s.elapsed_s);
  in.number("planned_s", s.planned_s);
  in.number("left_s", s.left_s);
  in.integer("lcr_readings", s.lcr_readings);
  in.integer("measure_readings", s.measure_readings);
  in.integer("frame_samples", s.frame_samples);
  in.quantity("capacitance_pF", s.capacitance_F, -12);
  in.quantity("secondary", s.secondary, 0);
  in.quantity("force_N", s.force_N, 0);
  in.quantity("travel_mm", s.travel_m, -3);
  in.quantity("gap_mm", s.gap_m, -3);
  in.quantity("pressure_kPa", s.pressure_Pa, 3);
  if (in.member("stops_after") != nullptr) in.text("stops_after", s.stops_after);
  if (in.member("pauses_at") != nullptr) in.text("pauses_at", s.pauses_at);
  if (const auto* question = in.member("question")) {
    auto open = parse_question(*question, s.question_left_s);
    if (!open) return fail(open.error());
    s.question = std::move(*open);
  }
  if (auto done = in.finish(); !done) return fail(done.error());
  return s;
}

json to_json(const StopAnswer& a) {
  return {{"standing", a.state == StopState::standing},
          {"state", to_string(a.state)},
          {"note", a.note}};
}

json to_json(const RunOutcome& e) {
  json code = nullptr;
  if (e.code) code = to_string(*e.code);
  return json{{"run", e.run},
              {"exit_status", to_string(e.exit_status)},
              {"code", std::move(code)},
              {"reason", e.reason},
              {"stands", e.stands},
              {"simulated", e.simulated},
              {"lcr_readings", e.lcr_readings},
              {"measure_readings", e.measure_readings},
              {"frame_samples", e.frame_samples},
              {"duration_s", e.duration_s},
              {"wall_s", e.wall_s},
              {"anchor", e.anchor.empty() ? json() : json(e.anchor)}};
}

Result<RunOutcome> parse_run_outcome(const json& value) {
  RunOutcome e;
  ParamsReader in(value, "");
  in.integer("run", e.run, true);
  std::string status;
  in.text("exit_status", status, true);
  if (const auto known = parse_exit_status(status)) {
    e.exit_status = *known;
  } else {
    in.fail_with(Error(Errc::garbled, "/exit_status: unknown word"));
  }
  if (const auto* code = in.member("code")) {
    e.code = code->is_string() ? errc_of_word(code->get<std::string>()) : std::nullopt;
    if (!e.code) in.fail_with(Error(Errc::garbled, "/code: unknown code"));
  }
  in.text("reason", e.reason);
  in.boolean("stands", e.stands);
  in.boolean("simulated", e.simulated);
  in.integer("lcr_readings", e.lcr_readings);
  in.integer("measure_readings", e.measure_readings);
  in.integer("frame_samples", e.frame_samples);
  in.number("duration_s", e.duration_s);
  in.number("wall_s", e.wall_s);
  if (in.member("anchor") != nullptr) in.text("anchor", e.anchor);
  if (auto done = in.finish(); !done) return fail(done.error());
  return e;
}

json to_json(const RunEventNote& n) {
  return json{{"run", n.run},
              {"t_mono_ns", n.event.t.time_since_epoch().count()},
              {"kind", n.event.kind.word()},
              {"step", n.event.step_id},
              {"detail", n.event.detail}};
}

Result<RunEventNote> parse_run_event(const json& value) {
  RunEventNote n;
  std::int64_t t = 0;
  std::string kind;
  ParamsReader in(value, "");
  in.integer("run", n.run, true);
  in.integer("t_mono_ns", t);
  in.text("kind", kind, true);
  in.text("step", n.event.step_id);
  in.text("detail", n.event.detail);
  if (auto done = in.finish(); !done) return fail(done.error());
  n.event.t = MonoTime(Duration(t));
  n.event.kind = EventName(std::move(kind));
  return n;
}

json to_json(const DaemonStatus& s) {
  json instruments = json::array();
  for (const auto& i : s.instruments) instruments.push_back(to_json(i));
  json out{{"version", s.version}, {"database", s.database}};
  out["instruments"] = std::move(instruments);
  out["run"] = s.run ? to_json(*s.run) : json(nullptr);
  out["last_run"] = s.last_run ? to_json(*s.last_run) : json(nullptr);
  out["queue"] = s.queue ? to_json(*s.queue) : json(nullptr);
  out["resumable"] = json::array();
  for (const auto& r : s.resumable) {
    out["resumable"].push_back(json{
        {"run", r.run}, {"protocol", r.protocol}, {"specimen", r.specimen}, {"step", r.step_id}});
  }
  return out;
}

Result<DaemonStatus> parse_daemon_status(const json& value) {
  DaemonStatus s;
  ParamsReader in(value, "");
  in.text("version", s.version, true);
  in.text("database", s.database);
  if (const auto* list = in.member("instruments")) {
    auto instruments = parse_instruments(*list);
    if (!instruments) return fail(instruments.error());
    s.instruments = std::move(*instruments);
  }
  if (const auto* run = in.member("run")) {
    auto status = parse_run_status(*run);
    if (!status) return fail(status.error());
    s.run = std::move(*status);
  }
  if (const auto* last = in.member("last_run")) {
    auto ended = parse_run_outcome(*last);
    if (!ended) return fail(ended.error());
    s.last_run = std::move(*ended);
  }
  if (const auto* queue = in.member("queue")) {
    auto parsed = parse_queue_status(*queue);
    if (!parsed) return fail(parsed.error());
    s.queue = std::move(*parsed);
  }
  if (const auto* list = in.member("resumable")) {
    auto resumable = parse_resumable(*list);
    if (!resumable) return fail(resumable.error());
    s.resumable = std::move(*resumable);
  }
  if (auto done = in.finish(); !done) return fail(done.error());
  return s;
}

json to_json(const RunRequest& r) {
  json out{
      {"protocol", r.protocol_name}, {"parameters", json::object()}, {"specimen", r.specimen_name}};
  for (const auto& [name, value] : r.parameters) {
    std::visit([&](const auto& v) { out["parameters"][name] = v; }, value);
  }
  if (!r.protocol_text.empty()) out["protocol_text"] = r.protocol_text;
  if (!r.specimen_text.empty()) out["specimen_text"] = r.specimen_text;
  if (!r.operator_name.empty()) out["operator"] = r.operator_name;
  if (!r.note.empty()) out["note"] = r.note;
  return out;
}

Result<RunRequest> parse_run_request(const json& params) {
  RunRequest r;
  ParamsReader in(params, "/params");
  in.text("protocol", r.protocol_name, true, kNameMax);
  in.text("protocol_text", r.protocol_text);
  in.numbers("parameters", r.parameters);
  in.text("specimen", r.specimen_name, true, kNameMax);
  in.text("specimen_text", r.specimen_text);
  in.text("operator", r.operator_name, false, kNameMax);
  in.text("note", r.note, false, kNoteMax);
  in.refuse_unknown();
  if (auto done = in.finish(); !done) return fail(done.error());
  return r;
}

json to_json(const Answered& a) {
  json out{{"run", a.run}, {"step", a.question.step_id}, {"value", to_json(a.value)}};
  if (a.question.type == AnswerType::number) out["unit"] = a.question.unit;
  return out;
}

json to_json(const AnswerRequest& r) {
  json out{{"value", to_json(r.value)}};
  if (r.question) out["question"] = *r.question;
  return out;
}

Result<AnswerRequest> parse_answer_request(const json& params) {
  AnswerRequest r;
  ParamsReader in(params, "/params");
  const auto* value = in.member("value");
  const auto known = answer_value(value);
  if (known) {
    r.value = *known;
  } else {
    in.fail_with(
        Error(Errc::invalid_request,
              fmt::format("{}: {}", in.pointer("value"),
                          value == nullptr ? "is missing" : "expected a text, a number or true")));
  }
  if (const auto* text = std::get_if<std::string>(&r.value)) {
    auto good = check_text(in.pointer("value"), *text, kAnswerMax);
    if (!good) in.fail_with(good.error());
  }
  if (in.member("question") != nullptr) in.integer("question", r.question.emplace());
  in.refuse_unknown();
  if (auto done = in.finish(); !done) return fail(done.error());
  return r;
}

json to_json(const TagRequest& r) {
  return {{"run", r.run}, {"tags", r.tags}, {"remove", r.remove}};
}

Result<TagRequest> parse_tag_request(const json& params) {
  constexpr std::size_t kMost = 100;
  TagRequest r;
  ParamsReader in(params, "/params");
  in.integer("run", r.run, true);
  in.boolean("remove", r.remove);
  const auto* tags = in.member("tags");
  const bool words = tags != nullptr && tags->is_array() && !tags->empty() &&
                     tags->size() <= kMost &&
                     std::ranges::all_of(*tags, [](const json& tag) { return tag.is_string(); });
  if (words) {
    r.tags = tags->get<std::vector<std::string>>();
  } else {
    in.fail_with(Error(Errc::invalid_request,
                       fmt::format("{}: expected 1 to {} words", in.pointer("tags"), kMost)));
  }
  in.refuse_unknown();
  if (auto done = in.finish(); !done) return fail(done.error());
  return r;
}

std::string request_line(std::int64_t id, std::string_view method, const json& params) {
  json message{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}};
  if (!params.is_null()) message["params"] = params;
  return line_of(message);
}

std::string answer_line(const json& id, const json& result) {
  return line_of(json{{"jsonrpc", "2.0"}, {"id", id}, {"result", result}});
}

std::string error_line(const json& id, const RpcError& error) {
  json data{{"errc", to_string(error.errc)}, {"hint", error.hint}};
  if (!error.detail.empty()) data["detail"] = error.detail;
  json body{{"code", error.code}, {"message", error.message}};
  body["data"] = std::move(data);
  json message{{"jsonrpc", "2.0"}, {"id", id}};
  message["error"] = std::move(body);
  return line_of(message);
}

std::string notification_line(std::string_view method, const json& params) {
  return line_of(json{{"jsonrpc", "2.0"}, {"method", method}, {"params", params}});
}

}  // namespace lcrig
