// SPDX-License-Identifier: Apache-2.0
// The part of a report that says where the numbers come from: instruments, settings, versions,
// events, and whether the rows are still those that were recorded.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/report/html.hpp"
#include "analysis/report/tables.hpp"
#include "base/iso_time.hpp"
#include "base/program_version.hpp"

namespace lcrig::report {

namespace {

constexpr std::size_t kMostEvents = 200;
// True for events that every run has. The report lists only the others.
bool is_ordinary(const EventRow& event) {
  switch (event.kind.kind()) {
    case EventKind::step_begin:
    case EventKind::motion:
    case EventKind::zero:
    case EventKind::settings:
    case EventKind::answer:  // answers have a table of their own
    case EventKind::state: return true;
    case EventKind::read_back: {
      const auto back = from_json<ReadBackEvent>(event.detail);
      return back && back->equal;
    }
    case EventKind::step_end: return !from_json<StepEndEvent>(event.detail)->stopped_by;
    default: return false;
  }
}

// A JSON object as "name value, name value". A text that is not an object is shown as it is.
std::string flat_json(const std::string& stored) {
  const auto json = nlohmann::json::parse(stored, nullptr, false);
  if (!json.is_object()) return text(stored);
  std::string out;
  for (const auto& [key, value] : json.items()) {
    out += (out.empty() ? "" : ", ") + text(key) + " " +
           text(value.is_string()
                    ? value.get<std::string>()
                    : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  return out.empty() ? "nothing is known" : out;
}

std::string correction_text(const RunRow& row) {
  const auto meter = parse_corrections(row.correction_json);
  if (!meter) return flat_json(row.correction_json);
  return text(fmt::format("open: {}; short: {}", correction_words(meter->open, row.started_unix_ns),
                          correction_words(meter->short_circuit, row.started_unix_ns)));
}

std::string chain_text(const ChainReport& chain) {
  if (!chain.intact) return "<b>BROKEN: " + text(chain.finding) + "</b>";
  return fmt::format("verified: {} rows in {} links are those that were recorded{}", chain.rows,
                     chain.head.links, chain.ended ? "" : " so far");
}

std::string or_dash(const std::string& words) {
  return words.empty() ? "–" : text(words);
}

}  // namespace

bool is_simulated(const ReportRun& run) {
  return run.data.row.simulated;
}

bool is_replayed(const ReportRun& run) {
  return run.data.replayed;
}

std::string simulated_mark(std::span<const ReportRun> runs) {
  const auto simulated = std::ranges::count_if(runs, is_simulated);
  if (simulated == 0) return {};
  if (std::ranges::all_of(runs, is_replayed)) {
    return "<div class='mark' id='simulated'>REPLAYED RECORDING (SIMULATED INSTRUMENTS). <span>The "
           "values were recorded earlier and played back; instruments and times of this run are "
           "those of the playback.</span></div>\n";
  }
  std::string what =
      "SIMULATED. <span>These numbers were computed by a model of the instruments "
      "and the specimen, not measured.</span>";
  if (simulated < std::ssize(runs)) {
    std::string which;
    for (const ReportRun& run : runs) {
      if (is_simulated(run)) which += fmt::format("{}{}", which.empty() ? "" : ", ", run.data.run);
    }
    what = "MIXED: SIMULATED AND MEASURED RUNS. <span>Simulated: run " + which +
           ". Differences between them and the others are differences between a model and a "
           "measurement.</span>";
  }
  return "<div class='mark' id='simulated'>" + what + "</div>\n";
}

std::string status_mark(const ReportRun& run) {
  const auto& listing = run.data.listing;
  std::string out;
  if (listing.exit_status != ExitStatus::success) {
    out += fmt::format("<div class='mark'>Run {}: {}. <span>{}</span></div>\n", run.data.run,
                       status_of(listing), text(listing.reason));
  }
  if (!run.chain.intact) {
    out += fmt::format(
        "<div class='mark'>Run {}: the rows are not those that were recorded. "
        "<span>{}</span></div>\n",
        run.data.run, text(run.chain.finding));
  }
  return out;
}

std::string notes_list(const ReportRun& run) {
  std::string out;
  for (const auto& note : run.analysis.notes) out += "<li>" + text(note) + "</li>\n";
  for (const auto& note : run.notes) {
    out += "<li>Note of " + or_dash(note.operator_name) + ", " + iso_time(note.added_unix_ns) +
           ": " + text(note.text) + "</li>\n";
  }
  return out.empty() ? out : "<ul>\n" + out + "</ul>\n";
}

std::string answer_table(const ReportRun& run) {
  Table table{"time, s", "step", "repeat", "question", "answer", "by"};
  bool any = false;
  for (const EventRow& e : run.data.events) {
    if (e.kind != EventKind::answer) continue;
    const auto answer = from_json<AnswerEvent>(e.detail);
    if (!answer) continue;  // damaged events are the export's business
    any = true;
    std::string said = answer->text ? text(*answer->text) : std::string("confirmed");
    if (answer->number) {
      said = number(*answer->number) + " " + text(answer->unit.value_or(""));
    }
    std::string by = answer->by ? text(*answer->by) : text(answer->source);
    if (answer->from_run) by += fmt::format(", in run {}", *answer->from_run);
    table.row({number(e.t_s, 1.0), or_dash(e.step_id),
               answer->repeat > 0 ? std::to_string(answer->repeat) : "–", text(answer->question),
               said, by});
  }
  return any ? table.html() : std::string();
}

std::string event_table(const ReportRun& run) {
  const RunData& d = run.data;
  std::string out = paragraph(fmt::format(
      "{} fresh readings, {} without a capacitance (overload), {} repeated by the meter; {} frame "
      "samples, {} gaps.",
      d.fresh_readings, d.overloads, d.repeated_readings, d.frame_samples, d.frame_gaps));
  Table table{"time, s", "event", "step", "detail"};
  std::size_t listed = 0, all = 0;
  for (const EventRow& e : d.events) {
    if (is_ordinary(e)) continue;
    ++all;
    if (listed == kMostEvents) continue;
    ++listed;
    table.row({number(e.t_s, 1.0), text(e.kind.word()), or_dash(e.step_id), flat_json(e.detail)});
  }
  if (listed > 0) out += table.html();
  if (all > listed) out += paragraph(fmt::format("The first {} of {}.", listed, all), "small");
  const auto ordinary = d.events.size() - all;
  return out +
         paragraph(
             fmt::format("{} events of the ordinary course (steps, motions, zeros, "
                         "settings and their read-backs) are left out; `lcrig export` has them.",
                         ordinary),
             "small");
}

std::string proof_text(const RunData& d) {
  if (!d.proof_known) {
    return "not known: an older lcrig recorded the run and did not read the settings back";
  }
  return fmt::format("{} of {}: taken between two equal read-backs of the settings",
                     d.fresh_readings, d.fresh_readings + d.unproven_readings);
}

std::string provenance_table(const ReportRun& run) {
  const RunRow& row = run.data.row;
  const auto& listing = run.data.listing;
  Table table = Table::of_facts();
  table.row({"run", fmt::format("{}, {}", run.data.run,
                                is_replayed(run) ? "<b>a recording, replayed</b>"
                                : row.simulated  ? "<b>simulated</b>"
                                                 : "measured")});
  if (!row.uuid.empty()) table.row({"uuid", text(row.uuid)});
  if (const auto& from = row.copied_from) {
    table.row({"recorded as", fmt::format("run {} in {}; what happened names runs by their numbers "
                                          "of there",
                                          from->run, text(from->file))});
  }
  table.row({"made", iso_time(true_time_ns(row))});
  if (row.made_unix_ns) table.row({"started, on its own clock", iso_time(row.started_unix_ns)});
  table.row({"ended", (listing.ended_unix_ns ? iso_time(*listing.ended_unix_ns) : "–") + ", " +
                          std::string(status_of(listing)) +
                          (listing.reason.empty() ? "" : ": " + text(listing.reason))});
  table.row({"protocol", text(row.protocol_name) + ", " + flat_json(row.parameters_json)});
  table.row({"specimen", or_dash(row.specimen_name)});
  table.row({"operator", or_dash(row.operator_name)});
  table.row({"note", or_dash(row.note)});
  table.row({"LCR meter", or_dash(row.lcr_identity)});
  table.row({"settings as read back", flat_json(row.lcr_settings_json)});
  table.row({"readings that are proven", proof_text(run.data)});
  table.row({"open and short correction", correction_text(row)});
  table.row({"load frame", or_dash(row.frame_identity)});
  table.row({"frame limits", flat_json(row.frame_limits_json)});
  table.row({"frame capabilities", flat_json(row.frame_capabilities_json)});
  table.row({"probe diameter", run.data.probe_diameter_m
                                   ? number(*run.data.probe_diameter_m * 1e3) + " mm"
                                   : "not known: no pressures"});
  if (row.simulated) {
    table.row({"bench", text(row.bench_name) +
                            (row.seed ? fmt::format(", seed {}", *row.seed) : std::string())});
    table.row({"model of the bench", or_dash(row.model_level.value_or(""))});
  }
  table.row({"software", fmt::format("recorded by lcrig {}, analysed by lcrig {}",
                                     text(row.software_version), program_version())});
  table.row({"hash chain", chain_text(run.chain)});
  if (const auto anchor = anchor_of(run.chain)) {
    table.row({"anchor", "<span class='hash'>" + to_string(*anchor) + "</span>"});
  }
  return table.html();
}

std::string files(const ReportRun& run) {
  const auto file = [](std::string_view name, const std::string& content) {
    return content.empty() ? std::string()
                           : fmt::format("<h3>{}</h3>\n<pre>{}</pre>\n", name, text(content));
  };
  const RunRow& row = run.data.row;
  return file("Specimen", row.specimen_text) + file("Protocol", row.protocol_text) +
         file("Bench", row.bench_text);
}

}  // namespace lcrig::report
