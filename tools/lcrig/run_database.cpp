// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/run_database.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "tools/lcrig/command_output.hpp"

namespace lcrig::cli {

namespace {

// The command to propose for a database without runs. Only the daemon writes into its database.
std::string first_run(const Context& context, const ChosenDatabase& chosen) {
  constexpr const char* kNote = "makes a first run";
  const Words pressing{"static-frame", "--specimen", "paper-1"};
  Words words{chosen.daemon_writes ? "run" : "rehearse"};
  words.insert(words.end(), pressing.begin(), pressing.end());
  if (chosen.daemon_writes) return next_command(context.global, words, kNote);
  return next_command(for_rehearsal(context, chosen.path), words, kNote);
}

Failure no_database(const Context& context, const ChosenDatabase& chosen) {
  if (auto safe = require_safe_to_create(chosen.path); !safe) {
    return Failure(safe.error());
  }
  const auto what = fmt::format("there is no database at {}", chosen.path);
  const auto folder = std::filesystem::path(chosen.path).parent_path();
  std::error_code ignored;
  if (!context.global.db.empty() && !folder.empty() &&
      !std::filesystem::is_directory(folder, ignored)) {
    return Failure(kFailed, what, "correct --db: its folder is not there either");
  }
  return Failure(kFailed, what, first_run(context, chosen));
}

// Most names are plain; any other text is escaped like all JSON.
std::string in_quotes(std::string_view text) {
  constexpr auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
  if (!std::ranges::all_of(text, is_plain)) return json_line(std::string(text));
  return fmt::format("\"{}\"", text);
}

std::string joined_tags(const std::vector<std::string>& tags) {
  std::string out;
  for (const auto& tag : tags) out += (out.empty() ? "" : ",") + in_quotes(tag);
  return out;
}

}  // namespace

Outcome<Database> open_runs(const Context& context) {
  auto chosen = context.database();
  if (!chosen) return chosen.error();
  std::error_code unknown;
  if (!std::filesystem::exists(chosen->path, unknown) && !unknown) {
    return no_database(context, *chosen);
  }
  auto db = open_read_only(chosen->path);
  if (!db) return Failure(db.error(), "give another --db");
  return std::move(*db);
}

Outcome<std::int64_t> named_run(const Context& context, const Database& db,
                                const std::string& text) {
  auto run = find_run(db, text);
  if (run) return *run;
  const auto runs = db.integer("SELECT count(*) FROM run");
  auto chosen = context.database();
  if (!chosen) return chosen.error();
  if (runs && *runs == 0) return Failure(run.error(), first_run(context, *chosen));
  return Failure(run.error(), next_command(context.global, {"runs"}, "lists them"));
}

Outcome<NamedRun> open_run(const Context& context, const std::string& text) {
  auto db = open_runs(context);
  if (!db) return db.error();
  auto number = named_run(context, *db, text);
  if (!number) return number.error();
  return NamedRun{std::move(*db), *number};
}

Outcome<std::int64_t> number_of_run(const Context& context, const std::string& text) {
  auto run = open_run(context, text);
  if (!run) return run.error();
  return run->number;
}

std::string next_after(const Error& error, std::string otherwise) {
  const bool of_database = error.code == Errc::io && !error.database.empty();
  return of_database ? "lcrig restore --help   (puts a backup in its place)" : otherwise;
}

void note_if_changed(const Context& context, const ChainReport& chain, std::int64_t run) {
  if (!chain.intact) context.console.note(fmt::format("run {} is {}", run, remark_on(chain)));
}

std::string format_utc(std::int64_t unix_ns) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(static_cast<std::time_t>(unix_ns / kSecond_ns)));
}

std::string run_listing_line(const RunListing& r) {
  std::string out;
  const auto add = std::back_inserter(out);
  const auto ended = r.ended_unix_ns ? in_quotes(format_utc(*r.ended_unix_ns)) : "null";
  const auto status = r.exit_status ? in_quotes(to_string(*r.exit_status)) : "null";
  fmt::format_to(add, R"({{"ended":{},"events":{},"exit_status":{},"frame_samples":{},)", ended,
                 r.events, status, r.frame_samples);
  fmt::format_to(add, R"("goes_on":{},"lcr_readings":{},"levels":{},"made":{},"operator":{},)",
                 r.goes_on, r.lcr_readings, r.levels, in_quotes(format_utc(true_time_ns(r))),
                 in_quotes(r.operator_name));
  fmt::format_to(add, R"("protocol":{},"reason":{},"run":{},"simulated":{},)",
                 in_quotes(r.protocol_name), in_quotes(r.reason), r.run, r.simulated);
  fmt::format_to(
      add, R"("specimen":{},"started":{},"tags":[{}],"unproven_readings":{},"uuid":{}}})",
      in_quotes(r.specimen_name), in_quotes(format_utc(r.started_unix_ns)), joined_tags(r.tags),
      r.unproven_readings, r.uuid.empty() ? "null" : in_quotes(r.uuid));
  return out;
}

}  // namespace lcrig::cli
