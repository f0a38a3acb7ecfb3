// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/messages.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "daemon/control/fields.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

struct ErrcRow {
  Errc errc;
  int code;
  HintWords hint;
};
constexpr std::array<ErrcRow, 14> kErrcs{{
    {Errc::no_reply,
     -32001,
     {"check cable, power and the instrument's port choice, then: ", "lcrig status", ""}},
    {Errc::reply_cut_off, -32002, {"check the cable, then: ", "lcrig status", ""}},
    {Errc::garbled,
     -32003,
     {"check that the right instrument is on this port, then: ", "lcrig status", ""}},
    {Errc::refused,
     -32004,
     {"the instrument did not take it: change the protocol's settings", "", ""}},
    {Errc::unsupported, -32011, {"this instrument cannot do that: use another one", "", ""}},
    {Errc::not_standing,
     -32012,
     {"standstill not confirmed: use the E-stop, then look at the rig", "", ""}},
    {Errc::frame_fault,
     -32013,
     {"look at the frame, clear its fault, unload it by hand, run again", "", ""}},
    {Errc::disconnected,
     -32005,
     {"see to what the message names, then: ", "lcrig status --ask", ""}},
    {Errc::busy, -32006, {"", "lcrig status", "what goes on"}},
    {Errc::limit_tripped,
     -32007,
     {"a limit was reached: check specimen and limits, then run again", "", ""}},
    {Errc::invalid_request, -32008, {"correct the request", "", ""}},
    {Errc::aborted, -32009, {"it was stopped: start it again when the cause is gone", "", ""}},
    {Errc::io, -32010, {"the operating system refused; the message says what and why", "", ""}},
    {Errc::bug, -32603, {"a fault of this program: report it with the wire log", "", ""}},
}};

const ErrcRow& row_of(Errc errc) {
  for (const auto& row : kErrcs) {
    if (row.errc == errc) return row;
  }
  return kErrcs.back();
}

json to_json(const AnswerValue& value) {
  return std::visit([](const auto& v) { return json(v); }, value);
}

// Replaces bytes that are not UTF-8 (in a file name or an instrument's reply) instead of throwing.
std::string line_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::optional<AnswerValue> answer_value(const json* value) {
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return AnswerValue(value->get<bool>());
  if (value->is_number()) return AnswerValue(value->get<double>());
  if (value->is_string()) return AnswerValue(value->get<std::string>());
  return std::nullopt;
}

void answer_field(FieldWriter& f, const char* key, const std::optional<AnswerValue>& value) {
  f.put(key, value ? to_json(*value) : json());
}

void answer_field(ParamsReader& in, const char* key, std::optional<AnswerValue>& value) {
  value = answer_value(in.member(key));
}

void condition_field(FieldWriter& f, InstrumentCondition condition, const std::string&) {
  f.text("state", to_string(condition));
}

// Older daemons send sentences instead of words.
void condition_field(ParamsReader& in, InstrumentCondition& condition, std::string& why) {
  std::string word;
  in.text("state", word, true);
  const auto known = parse_word<InstrumentCondition>(word);
  if (!known && why.empty()) why = word;
  condition = known.value_or(InstrumentCondition::unasked);
}

}  // namespace

Hint::Hint(const HintWords& words) {
  before = words.before;
  command = words.command;
  remark = words.remark;
}

std::string Hint::text(std::string_view options) const {
  std::string out = before + command;
  if (!command.empty() && !options.empty()) out.append(" ").append(options);
  if (!remark.empty()) out += "   (" + remark + ")";
  return out;
}

int rpc_code_of(Errc code) {
  return row_of(code).code;
}

RpcError rpc_error_of(const Error& error) {
  const auto& row = row_of(error.code);
  constexpr std::size_t kLongest = 4000;  // the text may quote a file or an instrument
  RpcError out(row.code, printable(error.what, kLongest), Hint(row.hint));
  out.errc = error.code;
  out.detail = printable_lines(error.detail);
  return out;
}

template <class F>
void fields(F& f, Of<F, OpenQuestion>& open) {
  auto& q = open.question;
  f.integer("number", open.number, true);
  f.text("step", q.step_id, true);
  f.text("text", q.text, true);
  f.word("answer", q.type, true);
  f.word("on_timeout", q.on_timeout, true);
  answer_field(f, "default", q.fallback);
  if (q.type == AnswerType::choice) f.texts("choices", q.choices);
  if (q.type != AnswerType::number) return;
  f.text("unit", q.unit);
  f.number("min", q.min);
  f.number("max", q.max);
}

template <class F>
void fields(F& f, Of<F, RunStatus>& s) {
  f.integer("run", s.run, true);
  f.text("protocol", s.protocol);
  f.text("specimen", s.specimen);
  f.boolean("simulated", s.simulated);
  f.word("state", s.state, true);
  f.word("standstill", s.standstill);  // missing in messages of older daemons
  f.text("step", s.step_id);
  f.text("step_kind", s.step_kind);
  f.text("prompt", s.prompt);
  f.object("question", s.question, [&s](auto& inner, auto& open) {
    fields(inner, open);
    inner.quantity("left_s", s.question_left_s, 0);
  });
  f.text_or_null("stops_after", s.stops_after);
  f.text_or_null("pauses_at", s.pauses_at);
  f.integer("repeat", s.repeat);
  f.integer("repeats", s.repeats);
  f.number("elapsed_s", s.elapsed_s);
  f.number("planned_s", s.planned_s);
  f.number("left_s", s.left_s);
  f.boolean("overdue", s.overdue);
  f.integer("lcr_readings", s.lcr_readings);
  f.integer("measure_readings", s.measure_readings);
  f.integer("unproven_readings", s.unproven_readings);
  f.integer("frame_samples", s.frame_samples);
  f.quantity("capacitance_pF", s.capacitance_F, -12);
  f.quantity("secondary", s.secondary, 0);
  f.quantity("force_N", s.force_N, 0);
  f.quantity("travel_mm", s.travel_m, -3);
  f.quantity("gap_mm", s.gap_m, -3);
  f.quantity("pressure_kPa", s.pressure_Pa, 3);
  f.word("pressure_on", s.pressure_on);
}

void fields(FieldWriter& f, const PressureArea& p) {
  const json all = to_json(p);
  for (const auto& [key, value] : all.items()) f.put(key.c_str(), value);
}
void fields(ParamsReader& in, PressureArea& p) {
  in.word("on", p.on, true);
  in.quantity("probe_diameter_mm", p.probe_diameter_m, -3);
  in.quantity("disc_diameter_mm", p.disc_diameter_m, -3);
  in.boolean("plate", p.plate);
}

template <class F>
void fields(F& f, Of<F, RunOutcome>& e) {
  f.integer("run", e.run, true);
  f.word("exit_status", e.exit_status, true);
  f.word_or_null("code", e.code);
  f.text("reason", e.reason);
  f.boolean("stands", e.stands);
  f.quantity("stood_after_s", e.stood_after_s, 0);
  f.boolean("simulated", e.simulated);
  f.integer("lcr_readings", e.lcr_readings);
  f.integer("measure_readings", e.measure_readings);
  f.integer("unproven_readings", e.unproven_readings);
  f.integer("frame_samples", e.frame_samples);
  f.number("duration_s", e.duration_s);
  f.number("wall_s", e.wall_s);
  f.text_or_null("anchor", e.anchor);
  f.object("pressure", e.pressure);
}

template <class F>
void fields(F& f, Of<F, RunEventNote>& n) {
  std::int64_t t = n.event.t.time_since_epoch().count();
  std::string kind(n.event.kind.word());
  f.integer("run", n.run, true);
  f.integer("t_mono_ns", t);
  f.text("kind", kind, true);
  f.text("step", n.event.step_id);
  f.text("detail", n.event.detail);
  if constexpr (std::is_same_v<F, ParamsReader>) {
    n.event.t = MonoTime(Duration(t));
    n.event.kind = EventName(std::move(kind));
  }
}

template <class F>
void fields(F& f, Of<F, InstrumentState>& i) {
  f.word("name", i.which, true);
  f.text("port", i.port);
  f.text("why", i.why);
  condition_field(f, i.condition, i.why);
  f.text("identity", i.identity);
  f.boolean("simulated", i.simulated);
  f.word("learned_by", i.learned_by);  // missing in messages of older daemons
  f.integer("run", i.run);
  f.quantity("age_s", i.age_s, 0);
  f.quantity("since_s", i.since_s, 0);
  f.boolean("statements_known", i.statements_known);
  f.texts("unstated", i.unstated);
}

template <class F>
void fields(F& f, Of<F, ResumableRun>& r) {
  f.integer("run", r.run, true);
  f.text("protocol", r.protocol);
  f.text("specimen", r.specimen);
  f.text("step", r.step_id);
}

template <class F>
void fields(F& f, Of<F, QueueStatus>& q) {
  f.boolean("going", q.going);
  f.word_or_empty("cause", q.cause);
  f.text("why", q.why);
  f.integer("count", q.count);
  f.integer("entry", q.entry);
  f.word_or_empty("gate", q.gate);
  f.text("prompt", q.prompt);
  f.text("locked_by", q.locked_by);
}

template <class F>
void fields(F& f, Of<F, DaemonStatus>& s) {
  f.text("version", s.version, true);
  f.text("database", s.database);
  f.list("instruments", s.instruments);
  f.object("run", s.run);
  f.boolean("correcting", s.correcting);
  f.object("last_run", s.last_run);
  f.object("queue", s.queue);
  f.list("resumable", s.resumable);
  f.text("socket_trouble", s.socket_trouble);
}

template <class F>
void fields(F& f, Of<F, RunRequest>& r) {
  f.text("protocol", r.protocol_name, true, kNameMax);
  f.text_or_absent("protocol_text", r.protocol_text);
  f.numbers("parameters", r.parameters);
  f.text("specimen", r.specimen_name, true, kNameMax);
  f.text_or_absent("specimen_text", r.specimen_text);
  f.text_or_absent("operator", r.operator_name, kNameMax);
  f.text_or_absent("note", r.note, kNoteMax);
}

void read_run_request(ParamsReader& in, RunRequest& out) {
  fields(in, out);
}

#define LCRIG_MESSAGE(Message, parse)        \
  json to_json(const Message& message) {     \
    return written(message);                 \
  }                                          \
  Result<Message> parse(const json& value) { \
    return read_answer<Message>(value);      \
  }
LCRIG_MESSAGE(RunStatus, parse_run_status)
LCRIG_MESSAGE(RunOutcome, parse_run_outcome)
LCRIG_MESSAGE(RunEventNote, parse_run_event)
LCRIG_MESSAGE(DaemonStatus, parse_daemon_status)
LCRIG_MESSAGE(QueueStatus, parse_queue_status)
#undef LCRIG_MESSAGE

json to_json(const RunRequest& request) {
  return written(request);
}

Result<RunRequest> parse_run_request(const json& params) {
  return read_params<RunRequest>(params);
}

json to_json(const StopAnswer& a) {
  return {{"standing", a.state == StopState::standing},
          {"state", to_string(a.state)},
          {"note", a.note}};
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
  return read_params<AnswerRequest>(params, [](ParamsReader& in, AnswerRequest& r) {
    const auto* value = in.member("value");
    if (const auto known = answer_value(value)) {
      r.value = *known;
    } else {
      in.refuse("value", value == nullptr ? "is missing" : "expected a text, a number or true");
    }
    if (const auto* text = std::get_if<std::string>(&r.value)) {
      auto good = check_text(in.pointer("value"), *text, kAnswerMax);
      if (!good) in.fail_with(good.error());
    }
    in.integer("question", r.question);
  });
}

json to_json(const TagRequest& r) {
  return {{"run", r.run}, {"tags", r.tags}, {"remove", r.remove}};
}

Result<TagRequest> parse_tag_request(const json& params) {
  return read_params<TagRequest>(params, [](ParamsReader& in, TagRequest& r) {
    constexpr std::size_t kMost = 100;
    in.integer("run", r.run, true);
    in.boolean("remove", r.remove);
    const auto* tags = in.member("tags");
    const bool fits = tags != nullptr && tags->is_array() && !tags->empty() &&
                      tags->size() <= kMost &&
                      std::ranges::all_of(*tags, [](const json& tag) { return tag.is_string(); });
    if (!fits) return in.refuse("tags", fmt::format("expected 1 to {} words", kMost));
    in.texts("tags", r.tags);
  });
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
  json data{{"errc", to_string(error.errc)}, {"hint", error.hint.text()}};
  if (!error.hint.command.empty()) {
    data["before"] = error.hint.before;
    data["command"] = error.hint.command;
    data["remark"] = error.hint.remark;
  }
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
