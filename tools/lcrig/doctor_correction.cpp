// SPDX-License-Identifier: Apache-2.0
// The finding about the corrections of the meter: whether they are on, and how old they are.
#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "tools/lcrig/console.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

namespace {

// No paper of the meter says how long one is good. A month is what a lab remembers.
constexpr std::int64_t kOldFrom_days = 30;

struct Known {
  MeterCorrections meter;
  std::string from;  // how that is known
};

struct LastRun {
  std::int64_t run = 0, started_unix_ns = 0;
  std::string correction;
};

// What was made after the last run began was read back as on.
Known since_run(MeterCorrections meter, const LastRun& run) {
  for (const auto kind : {CorrectionKind::open, CorrectionKind::short_circuit}) {
    CorrectionState& state = meter.of(kind);
    if (state.made_unix_ns && *state.made_unix_ns > run.started_unix_ns) state.on = true;
  }
  auto from = printable(meter.meter, kLongestName);
  if (run.run != 0) from += fmt::format(", as run {} found it", run.run);
  return Known{std::move(meter), std::move(from)};
}

// nullopt: nothing is known of any meter.
Result<std::optional<Known>> look_up(const Database& db) {
  auto last = db.first(
      "SELECT id, started_unix_ns, correction_json FROM run WHERE simulated = 0"
      " ORDER BY id DESC LIMIT 1",
      [](const Statement& row) {
        return LastRun{row.integer(0), row.integer(1), std::string(row.text(2))};
      });
  if (!last) return fail(last.error());
  const LastRun run = last->value_or(LastRun());
  if (auto meter = parse_corrections(run.correction)) {
    if (auto found = look_up_corrections(db, *meter); !found) return fail(found.error());
    return since_run(std::move(*meter), run);
  }
  auto all = list_corrections(db);
  if (!all) return fail(all.error());
  const auto real = std::ranges::find(*all, false, &MeterCorrections::simulated);
  if (real != all->end()) return since_run(*real, LastRun());
  if (run.run == 0) return std::nullopt;
  return Known{MeterCorrections(), fmt::format("run {} is of an older lcrig", run.run)};
}

Finding finding_of(CorrectionKind kind, Known& known, std::int64_t now_unix_ns) {
  const CorrectionState& state = known.meter.of(kind);
  const auto days = state.made_unix_ns ? days_between(*state.made_unix_ns, now_unix_ns) : 0;
  const bool old = days > kOldFrom_days;
  auto words = fmt::format("{}: {}; {}", to_string(kind),
                           printable(correction_words(state, now_unix_ns, "ago"), kLongestWords),
                           known.from);
  if (old) words += fmt::format("; older than {} days", kOldFrom_days);
  if (state.made_unix_ns && !old && state.on.value_or(true)) {
    return {"correction", Health::ok, std::move(words)};
  }
  return {"correction", Health::warn, std::move(words),
          fmt::format("lcrig lcr correct {}", to_string(kind))};
}

}  // namespace

void look_at_corrections(const Database& db, const std::optional<MeterCorrections>& asked,
                         std::int64_t now_unix_ns, Findings& findings) {
  Result<std::optional<Known>> known;
  if (asked && !asked->simulated) {
    known = Known{*asked, printable(asked->meter, kLongestName) + ", asked now"};
  } else {
    known = look_up(db);
  }
  if (!known) {
    findings.emplace_back("correction", Health::bad, printable(known.error().what, kLongestWords));
    return;
  }
  if (!*known) return;
  for (const auto kind : {CorrectionKind::open, CorrectionKind::short_circuit}) {
    findings.push_back(finding_of(kind, **known, now_unix_ns));
  }
}

}  // namespace lcrig::cli
