// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/cmd_rehearse_batch.hpp"

#include <fmt/ostream.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/doc_page.hpp"
#include "base/json_or_null.hpp"
#include "base/text.hpp"
#include "budget/search.hpp"
#include "storage/batches.hpp"
#include "tools/lcrig/cmd_budget_scene.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/live_line.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

// The runs with the same specimen, protocol and parameters.
struct BatchKind {
  const BatchEntry* row = nullptr;
  std::vector<std::int64_t> lines;  // lines of the rows that ask for it
  std::vector<const RehearsedEntry*> entries;
  std::vector<Prediction> predictions;
  std::string not_predicted;
  std::string pressure;  // PressureArea::words()
};

bool wants_the_same(const BatchEntry& a, const BatchEntry& b) {
  return a.specimen_name == b.specimen_name && a.protocol_text == b.protocol_text &&
         a.parameters == b.parameters;
}

std::vector<BatchKind> kinds_of(const BatchRequest& batch, const RehearseBatchResult& result) {
  std::vector<BatchKind> out;
  for (const BatchEntry& row : batch.rows) {
    auto kind = std::ranges::find_if(
        out, [&row](const BatchKind& k) { return wants_the_same(*k.row, row); });
    if (kind == out.end()) kind = out.insert(out.end(), BatchKind());
    if (kind->row == nullptr) kind->row = &row;
    kind->lines.push_back(row.at.line);
  }
  for (const RehearsedEntry& entry : result.entries) {
    const auto kind = std::ranges::find_if(out, [&entry](const BatchKind& k) {
      return std::ranges::find(k.lines, entry.line) != k.lines.end();
    });
    if (kind != out.end()) kind->entries.push_back(&entry);
  }
  return out;
}

// Predicts one run with the budget.
void predict(const Context& context, const std::string& bench, BatchKind& kind) {
  const BatchEntry& row = *kind.row;
  const auto refused = [&kind](std::string why) { kind.not_predicted = std::move(why); };
  auto protocol = parse_protocol(row.protocol_text, row.protocol_name);
  if (!protocol) return refused(protocol.error().what);
  auto environment = bind_parameters(*protocol, row.parameters);
  if (!environment) return refused(environment.error().what);
  LibraryFile specimen;
  specimen.name = row.specimen_name;
  specimen.text = row.specimen_text;
  auto rig = budget_rig(context, bench, specimen, *protocol);
  if (!rig) return refused(rig.error().what);
  kind.pressure = rig_for(*protocol, *rig).pressure.words();
  auto curve = budget_curve(specimen, *protocol, *environment, *rig);
  if (!curve) return refused(curve.error().what);
  BudgetQuestion question{*protocol, *environment, *rig, *curve, {}, {}, {}, {}};
  question.apertures = {protocol->sample.lcr.aperture};
  question.frequencies_Hz = {protocol->sample.lcr.frequency.si()};
  const Budget budget = reckon_budget(question);
  const BudgetPoint& planned = budget.settings.front().planned;
  if (!planned.possible()) return refused(planned.refused);
  kind.predictions = planned.predictions;
}

json to_json(const RehearsedEntry& e) {
  return json{{"position", e.position},
              {"entry", e.entry},
              {"line", e.line},
              {"repeat", e.repeat},
              {"protocol", e.protocol_name},
              {"specimen", e.specimen_name},
              {"state", to_string(e.state)},
              {"exit_status", e.run ? to_string(e.exit_status, kRunCutOff) : ""},
              {"reason", e.reason},
              {"measure_readings", e.measure_readings},
              {"duration_s", e.duration_s},
              {"acts", e.acts},
              {"run", json_or_null(e.run)}};
}

json to_json(const BatchKind& k) {
  json out{{"specimen", k.row->specimen_name},
           {"protocol", k.row->protocol_name},
           {"lines", k.lines},
           {"runs", k.entries.size()}};
  out["not_predicted"] = k.not_predicted;
  out["pressure"] = k.pressure;
  json predictions = json::array();
  for (const Prediction& p : k.predictions) {
    json one{{"quantity", p.quantity}, {"unit", p.unit}, {"reason", p.reason}};
    if (p.reason.empty()) {
      one["value"] = p.value;
      one["standard_error"] = p.standard_error;
      one["half_width"] = p.half_width;
      one["expanded_uncertainty"] = p.uncertainty.expanded;
    }
    predictions.push_back(std::move(one));
  }
  out["predictions"] = std::move(predictions);
  return out;
}

json to_json(const RehearseBatchResult& r, const BatchRequest& batch,
             const std::vector<BatchKind>& kinds) {
  json out{{"batch", r.name},
           {"simulated", true},
           {"order", to_string(batch.order)},
           {"length_s", r.length_s},
           {"machine_s", r.machine_s},
           {"hands_s", r.hands_s},
           {"measure_readings", r.measure_readings},
           {"troubles", r.troubles},
           {"wall_s", r.wall_s},
           {"db", r.db_path}};
  out["seed"] = batch.order == BatchOrder::given ? json() : json(batch.seed);
  out["entries"] = out["hands"] = out["kinds"] = json::array();
  for (const RehearsedEntry& entry : r.entries) out["entries"].push_back(to_json(entry));
  for (const HandTime& hand : r.hands) {
    out["hands"].push_back({{"at_s", hand.at_s},
                            {"entry", hand.entry},
                            {"kind", hand.gate ? to_string(*hand.gate) : "held"},
                            {"prompt", hand.prompt}});
  }
  for (const BatchKind& kind : kinds) out["kinds"].push_back(to_json(kind));
  return out;
}

std::string counted(std::size_t n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

void print_kind(std::ostream& out, const BatchKind& kind) {
  double seconds = 0;
  std::int64_t readings = 0;
  std::size_t good = 0;
  for (const RehearsedEntry* entry : kind.entries) {
    seconds += entry->duration_s;
    readings += entry->measure_readings;
    good += entry->exit_status == ExitStatus::success ? 1 : 0;
  }
  fmt::print(out, "  {} on {}: {} of {} succeed, {} of machine time, {} readings\n",
             printable(kind.row->protocol_name, kLongestName),
             printable(kind.row->specimen_name, kLongestName), good,
             counted(kind.entries.size(), "run"), format_time(seconds), readings);
  if (!kind.not_predicted.empty()) {
    fmt::print(out, "    no prediction: {}\n", printable(kind.not_predicted, kLongestWords));
  }
  for (const Prediction& p : kind.predictions) {
    if (!p.reason.empty()) {
      fmt::print(out, "    {}: {}\n", p.quantity, p.reason);
      continue;
    }
    fmt::print(out, "    {}: {:.4g} ± {:.2g} {} in one run ({:.2g} %)\n", p.quantity, p.value,
               p.standard_error, p.unit, p.relative() * 100);
  }
}

void print_day(std::ostream& out, const RehearseBatchResult& r, const BatchRequest& batch,
               const std::vector<BatchKind>& kinds, double hand_s) {
  std::vector<std::string> pressures;
  for (const BatchKind& kind : kinds) {
    if (kind.pressure.empty() || std::ranges::find(pressures, kind.pressure) != pressures.end()) {
      continue;
    }
    pressures.push_back(kind.pressure);
    fmt::print(out, "{}\n", kind.pressure);
  }
  fmt::print(out, "batch {} (simulated): {}, {}\n", printable(r.name, kLongestName),
             counted(r.entries.size(), "run"), order_words(batch.order, batch.seed));
  fmt::print(out, "length {}: {} of machine time, {} of {} each; played in {:.1f} s\n",
             format_time(r.length_s), format_time(r.machine_s),
             counted(r.hands.size(), "hand time"), format_time(hand_s), r.wall_s);
  fmt::print(out, "{} readings of measure steps\n", r.measure_readings);
  if (!r.hands.empty()) fmt::print(out, "a person has to act at\n");
  for (const HandTime& hand : r.hands) {
    fmt::print(out, "  {:>8}  {}\n", format_time(hand.at_s), printable(hand.prompt, kLongestWords));
  }
  for (const RehearsedEntry& entry : r.entries) {
    if (entry.acts == 0) continue;
    fmt::print(out, "  inside entry {} ({} on {}): {} weights or answers\n", entry.entry,
               printable(entry.protocol_name, kLongestName),
               printable(entry.specimen_name, kLongestName), entry.acts);
  }
  fmt::print(out, "what it measures\n");
  for (const BatchKind& kind : kinds) print_kind(out, kind);
  std::size_t bad = r.troubles.size();
  if (bad > 0) fmt::print(out, "what goes wrong\n");
  for (const std::string& trouble : r.troubles) {
    fmt::print(out, "  {}\n", printable(trouble, kLongestWords));
  }
  for (const RehearsedEntry& entry : r.entries) {
    if (entry.exit_status == ExitStatus::success) continue;
    if (bad++ == 0) fmt::print(out, "what goes wrong\n");
    fmt::print(out, "  entry {} (line {}, repeat {}): {}{}\n", entry.entry, entry.line,
               entry.repeat, entry.run ? to_string(entry.exit_status, kRunCutOff) : "no run",
               entry.reason.empty() ? "" : ", " + printable(entry.reason, kLongestWords));
  }
  if (bad == 0) fmt::print(out, "nothing goes wrong\n");
}

// The command that queues the same batch on the rig.
std::string queue_command(const Context& context, const BatchRequest& batch,
                          const BatchOptions& options) {
  Words words{"queue", "add", "--batch", options.file()};
  if (batch.order != BatchOrder::given) {
    add_option(words, "--order", std::string(to_string(batch.order)));
    add_option(words, "--seed", std::to_string(batch.seed));
  }
  GlobalOptions daemon = context.global;
  daemon.db.clear();
  return next_command(daemon, words, "the same on the rig");
}

}  // namespace

Outcome<ExitCode> rehearse_table(Context& context, const BatchRequest& batch,
                                 RehearseBatchRequest request, const BatchOptions& options) {
  request.batch.name = batch.name;
  request.batch.file_name = batch.file_name;
  request.batch.table = batch.table;
  request.batch.order = batch.order;
  request.batch.seed = batch.seed;
  request.batch.protocols = batch.protocols;
  request.batch.specimens = batch.specimens;
  request.batch.terms = with_row_terms(QueueTerms(), batch.terms);
  LiveLine line(context.console, context.clock);
  request.progress = [&line](const RunStatus& status) { line.show(status); };
  auto result = context.daemon.rehearse_batch(request);
  line.finish();
  if (!result) {
    return Failure(result.error(), "change what the message names; " + doc_page("batch-file"));
  }
  auto kinds = kinds_of(batch, *result);
  for (BatchKind& kind : kinds) predict(context, request.bench, kind);
  const bool good = std::ranges::all_of(result->entries, [](const RehearsedEntry& e) {
    return e.exit_status == ExitStatus::success;
  });
  show(context, to_json(*result, batch, kinds), [&](std::ostream& out) {
    print_day(out, *result, batch, kinds, request.hand_s);
    context.console.next(
        next_command(at_database(result->db_path), {"report", "--batch", result->name}));
    context.console.next(queue_command(context, batch, options));
  });
  return good ? kOk : kFailed;
}

}  // namespace lcrig::cli
