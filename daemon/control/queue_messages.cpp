// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/queue_messages.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/enum_words.hpp"
#include "base/text.hpp"
#include "daemon/control/params.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

template <class T>
json or_null(const std::optional<T>& value) {
  if (!value) return nullptr;
  return *value;
}

json json_of(const std::string& text) {
  json value = json::parse(text, nullptr, false);
  return value.is_discarded() ? json() : value;
}

json to_json(const QueueListing& e) {
  json out{{"entry", e.entry},
           {"state", to_string(e.state)},
           {"protocol", e.protocol_name},
           {"specimen", e.specimen_name},
           {"parameters", json_of(e.parameters_json)},
           {"operator", e.operator_name},
           {"note", e.note},
           {"terms", json_of(e.terms_json)},
           {"added_by", e.added_by},
           {"added_unix_ns", e.added_unix_ns},
           {"attempts", e.attempts}};
  out["run"] = or_null(e.last_run);
  out["resumes_run"] = or_null(e.resumes_run);
  return out;
}

json to_json(const EntryBatch& b) {
  json out{{"name", b.batch.name},
           {"file", b.batch.file_name},
           {"order", to_string(b.batch.order)},
           {"position", b.position},
           {"of", b.of},
           {"line", b.line},
           {"repeat", b.repeat}};
  out["seed"] = or_null(b.batch.seed);
  return out;
}

// "protocols": {"press": {"name": "press", "text": ".."}}: texts by the words of cells.
void read_files(ParamsReader& in, const char* key, std::map<std::string, BatchFile>& out) {
  const json* files = in.member(key);
  if (files == nullptr) return;
  if (!files->is_object()) {
    in.fail_with(Error(Errc::invalid_request, in.pointer(key) + ": expected an object"));
    return;
  }
  for (const auto& [word, value] : files->items()) {
    ParamsReader file(value, in.pointer(key) + "/" + printable(word, 60));
    file.text("name", out[word].name, true, kNameMax);
    file.text("text", out[word].text);
    file.refuse_unknown();
    if (auto ok = file.finish(); !ok) in.fail_with(ok.error());
  }
}

// "place": "first", "last", {"before": 3} or {"after": 3}.
void read_place(ParamsReader& in, QueuePlace& out) {
  const json* place = in.member("place");
  if (place == nullptr) return;
  using Where = QueuePlace::Where;
  if (*place == "last") return;
  out.where = Where::first;
  if (*place == "first") return;
  for (const auto& [word, where] :
       {std::pair("before", Where::before), std::pair("after", Where::after)}) {
    if (!place->is_object() || place->size() != 1 || !place->contains(word)) continue;
    ParamsReader inner(*place, in.pointer("place"));
    out.where = where;
    inner.integer(word, out.entry, true);
    if (auto ok = inner.finish(); !ok) in.fail_with(ok.error());
    return;
  }
  in.fail_with(Error(Errc::invalid_request,
                     in.pointer("place") +
                         R"(: expected "first", "last", {"before": ENTRY} or {"after": ENTRY})"));
}

}  // namespace

json to_json(const EntryPlan& p) {
  json out{{"measure_readings", p.measure_readings},
           {"bytes", p.bytes},
           {"peak_force_N", p.peak_force_N},
           {"moves", p.moves},
           {"why_not", p.why_not}};
  out["duration_s"] = or_null(p.duration_s);
  return out;
}

EntryPlan parse_entry_plan(std::string_view json_text) {
  const json value = json::parse(json_text, nullptr, false);
  EntryPlan out, unknown;
  unknown.why_not = "its plan is not stored";
  if (!value.is_object()) return unknown;
  ParamsReader in(value, "plan");
  in.integer("measure_readings", out.measure_readings);
  in.integer("bytes", out.bytes);
  in.number("peak_force_N", out.peak_force_N);
  in.boolean("moves", out.moves);
  in.text("why_not", out.why_not);
  in.quantity("duration_s", out.duration_s, 0);
  return in.finish() ? out : unknown;
}

json to_json(const QueueAdded& added) {
  return json{{"entry", added.entry}, {"plan", to_json(added.plan)}};
}

json to_json(const BatchAdded& a) {
  return json{{"first_entry", a.first_entry},
              {"last_entry", a.last_entry},
              {"entries", a.entries},
              {"duration_s", a.duration_s},
              {"measure_readings", a.measure_readings},
              {"bytes", a.bytes},
              {"unplanned", a.unplanned},
              {"why_not", a.why_not}};
}

json to_json(const ListedEntry& e) {
  json out = to_json(e.listing);
  out["plan"] = to_json(e.plan);
  if (e.batch) out["batch"] = to_json(*e.batch);
  out["planned_begin_unix_ns"] = or_null(e.planned.begin_unix_ns);
  out["planned_end_unix_ns"] = or_null(e.planned.end_unix_ns);
  return out;
}

json to_json(const QueuePage& page) {
  json entries = json::array();
  for (const auto& e : page.entries) entries.push_back(to_json(e));
  json out{{"count", page.count}};
  out["entries"] = std::move(entries);
  return out;
}

json to_json(const QueueAct& a) {
  json out{{"seq", a.seq},
           {"at_unix_ns", a.at_unix_ns},
           {"act", a.act},
           {"user", a.user},
           {"detail", a.detail}};
  out["entry"] = or_null(a.entry);
  out["uid"] = or_null(a.uid);
  return out;
}

Result<QueueAdd> parse_queue_add(const json& params) {
  QueueAdd out;
  ParamsReader in(params, "/params");
  in.text("protocol", out.run.protocol_name, true, kNameMax);
  in.text("protocol_text", out.run.protocol_text);
  in.numbers("parameters", out.run.parameters);
  in.text("specimen", out.run.specimen_name, true, kNameMax);
  in.text("specimen_text", out.run.specimen_text);
  in.text("operator", out.run.operator_name, false, kNameMax);
  in.text("note", out.run.note, false, kNoteMax);
  read_place(in, out.place);
  read_terms(in, out.terms);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return out;
}

Result<BatchAdd> parse_batch_add(const json& params) {
  BatchAdd out;
  ParamsReader in(params, "/params");
  in.text("name", out.name, true, kNameMax);
  in.text("file", out.file_name, true, kNameMax);
  in.text("table", out.table, true);
  std::string order(to_string(out.order));
  in.text("order", order);
  const auto known = parse_word(order, BatchOrder::random);
  if (known) out.order = *known;
  if (!known) {
    in.fail_with(
        Error(Errc::invalid_request, in.pointer("order") + ": expected given, blocks or random"));
  }
  in.integer("seed", out.seed, known && *known != BatchOrder::given);
  if (out.name.empty()) {
    in.fail_with(Error(Errc::invalid_request, in.pointer("name") + ": is empty"));
  }
  read_files(in, "protocols", out.protocols);
  read_files(in, "specimens", out.specimens);
  in.text("operator", out.operator_name, false, kNameMax);
  read_place(in, out.place);
  read_terms(in, out.terms);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return out;
}

Result<QueueMove> parse_queue_move(const json& params) {
  QueueMove out;
  ParamsReader in(params, "/params");
  in.integer("entry", out.entry, true);
  if (in.member("place") == nullptr) {
    in.fail_with(Error(Errc::invalid_request, in.pointer("place") + ": is missing"));
  }
  read_place(in, out.place);
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return out;
}

Result<QueueRange> parse_queue_range(const json& params, const char* from) {
  QueueRange out;
  ParamsReader in(params, "/params");
  if (in.member("entry") != nullptr) in.integer("entry", out.entry.emplace());
  in.integer(from, out.from);
  in.integer("most", out.most);
  if (out.most < 1 || out.most > kQueuePageMax) {
    in.fail_with(Error(Errc::invalid_request,
                       fmt::format("{}: expected 1 to {}", in.pointer("most"), kQueuePageMax)));
  }
  if (out.from < 0) {
    in.fail_with(
        Error(Errc::invalid_request, fmt::format("{}: expected 0 or more", in.pointer(from))));
  }
  in.refuse_unknown();
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return out;
}

}  // namespace lcrig
