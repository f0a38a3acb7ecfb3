// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/queue_messages.hpp"

#include <nlohmann/json.hpp>

#include "base/json_or_null.hpp"
#include "base/text.hpp"
#include "daemon/control/fields.hpp"

namespace lcrig {

using nlohmann::json;

namespace {

json json_of(const std::string& text) {
  json value = json::parse(text, nullptr, false);
  return value.is_discarded() ? json() : value;
}

json to_json(const QueueListing& e) {
  return json{{"entry", e.entry},
              {"state", to_string(e.state)},
              {"protocol", e.protocol_name},
              {"specimen", e.specimen_name},
              {"parameters", json_of(e.parameters_json)},
              {"operator", e.operator_name},
              {"note", e.note},
              {"terms", json_of(e.terms_json)},
              {"added_by", e.added_by},
              {"added_unix_ns", e.added_unix_ns},
              {"attempts", e.attempts},
              {"run", json_or_null(e.last_run)},
              {"resumes_run", json_or_null(e.resumes_run)}};
}

json to_json(const EntryBatch& b) {
  return json{{"name", b.batch.name},
              {"file", b.batch.file_name},
              {"order", to_string(b.batch.order)},
              {"position", b.position},
              {"of", b.of},
              {"line", b.line},
              {"repeat", b.repeat},
              {"seed", json_or_null(b.batch.seed)}};
}

// Reads "protocols": {"press": {"name": "press", "text": ".."}}: texts by the words of the cells.
void read_files(ParamsReader& in, const char* key, std::map<std::string, BatchFile>& out) {
  const json* files = in.member(key);
  if (files == nullptr) return;
  if (!files->is_object()) {
    return in.refuse(key, "expected an object");
  }
  for (const auto& [word, value] : files->items()) {
    ParamsReader file(value, in.pointer(key) + "/" + printable(word, 60));
    file.text("name", out[word].name, true, kNameMax);
    file.text("text", out[word].text);
    file.refuse_unknown();
    if (auto ok = file.finish(); !ok) in.fail_with(ok.error());
  }
}

// Reads "place": "first", "last", {"before": 3} or {"after": 3}.
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
  in.refuse("place", R"(expected "first", "last", {"before": ENTRY} or {"after": ENTRY})");
}

}  // namespace

template <class F>
void fields(F& f, Of<F, EntryPlan>& p) {
  f.integer("measure_readings", p.measure_readings);
  f.integer("bytes", p.bytes);
  f.number("peak_force_N", p.peak_force_N);
  f.boolean("moves", p.moves);
  f.text("why_not", p.why_not);
  f.text("pressure", p.pressure);
  f.quantity("duration_s", p.duration_s, 0);
}

json to_json(const EntryPlan& plan) {
  return written(plan);
}

EntryPlan parse_entry_plan(std::string_view json_text) {
  EntryPlan unknown;
  unknown.why_not = "its plan is not stored";
  return read_answer<EntryPlan>(json::parse(json_text, nullptr, false)).value_or(unknown);
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
              {"why_not", a.why_not},
              {"pressures", a.pressures}};
}

json to_json(const ListedEntry& e) {
  json out = to_json(e.listing);
  out["plan"] = to_json(e.plan);
  if (e.batch) out["batch"] = to_json(*e.batch);
  out["planned_begin_unix_ns"] = json_or_null(e.planned.begin_unix_ns);
  out["planned_end_unix_ns"] = json_or_null(e.planned.end_unix_ns);
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
  return json{{"seq", a.seq},
              {"at_unix_ns", a.at_unix_ns},
              {"act", a.act},
              {"user", a.user},
              {"detail", a.detail},
              {"entry", json_or_null(a.entry)},
              {"uid", json_or_null(a.uid)}};
}

Result<QueueAdd> parse_queue_add(const json& params) {
  return read_params<QueueAdd>(params, [](ParamsReader& in, QueueAdd& out) {
    read_run_request(in, out.run);
    read_place(in, out.place);
    read_terms(in, out.terms);
  });
}

Result<BatchAdd> parse_batch_add(const json& params) {
  return read_params<BatchAdd>(params, [](ParamsReader& in, BatchAdd& out) {
    in.text("name", out.name, true, kNameMax);
    in.text("file", out.file_name, true, kNameMax);
    in.text("table", out.table, true);
    in.word("order", out.order);
    in.integer("seed", out.seed, out.order != BatchOrder::given);
    if (out.name.empty()) in.refuse("name", "is empty");
    read_files(in, "protocols", out.protocols);
    read_files(in, "specimens", out.specimens);
    in.text("operator", out.operator_name, false, kNameMax);
    read_place(in, out.place);
    read_terms(in, out.terms);
  });
}

Result<QueueMove> parse_queue_move(const json& params) {
  return read_params<QueueMove>(params, [](ParamsReader& in, QueueMove& out) {
    in.integer("entry", std::get<std::int64_t>(out), true);
    if (in.member("place") == nullptr) in.refuse("place", "is missing");
    read_place(in, std::get<QueuePlace>(out));
  });
}

Result<QueueRange> parse_queue_range(const json& params, const char* from) {
  return read_params<QueueRange>(params, [from](ParamsReader& in, QueueRange& out) {
    in.integer("entry", out.entry);
    in.integer(from, out.from);
    in.integer("most", out.most);
    if (out.most < 1 || out.most > kQueuePageMax) {
      in.refuse("most", fmt::format("expected 1 to {}", kQueuePageMax));
    }
    if (out.from < 0) in.refuse(from, "expected 0 or more");
  });
}

}  // namespace lcrig
