// SPDX-License-Identifier: Apache-2.0
// Checks the corrections of the meter: whether they are on, and how old they are.
#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "tools/lcrig/console.hpp"
#include "tools/lcrig/doctor.hpp"

namespace lcrig::cli {

namespace {

// No document of the meter says how long a correction is good. A lab remembers about a month.
constexpr std::int64_t kOldFrom_days = 30;

struct Known {
  MeterCorrections meter;
  std::string from;  // where this knowledge comes from
};

struct LastRun {
  std::int64_t run = 0;
  std::string correction;
};

// A correction that was made since then was read back as on, and `then` did not know it. The times
// are not compared, because a clock may have been wrong.
void turn_on_what_is_new(MeterCorrections& meter, MeterCorrections then) {
  for (const auto kind : {CorrectionKind::open, CorrectionKind::short_circuit}) {
    CorrectionState& state = meter.of(kind);
    if (state.made_unix_ns && state.made_unix_ns != then.of(kind).made_unix_ns) state.on = true;
  }
}

// nullopt: nothing is known of any meter.
Result<std::optional<Known>> look_up(const Database& db) {
  auto last = db.first(
      "SELECT id, correction_json FROM run WHERE simulated = 0 ORDER BY id DESC LIMIT 1",
      [](const Statement& row) { return LastRun{row.integer(0), std::string(row.text(1))}; });
  if (!last) return fail(last.error());
  const LastRun run = last->value_or(LastRun());
  if (auto meter = parse_corrections(run.correction)) {
    const MeterCorrections then = *meter;
    if (auto found = look_up_corrections(db, *meter); !found) return fail(found.error());
    turn_on_what_is_new(*meter, then);
    auto from =
        fmt::format("{}, as run {} found it", printable(meter->meter, kLongestName), run.run);
    return Known{std::move(*meter), std::move(from)};
  }
  auto all = list_corrections(db);
  if (!all) return fail(all.error());
  const auto real = std::ranges::find(*all, false, &MeterCorrections::simulated);
  if (real != all->end()) {
    turn_on_what_is_new(*real, MeterCorrections());
    return Known{*real, printable(real->meter, kLongestName)};
  }
  if (run.run == 0) return std::nullopt;
  return Known{MeterCorrections(), fmt::format("run {} is of an older lcrig", run.run)};
}

Finding finding_of(CorrectionKind kind, Known& known, std::int64_t now_unix_ns) {
  const CorrectionState& state = known.meter.of(kind);
  const auto days = state.made_unix_ns ? days_between(*state.made_unix_ns, now_unix_ns) : 0;
  const bool old = days > kOldFrom_days;
  const bool future = is_in_future(state, now_unix_ns);
  const auto what =
      known.meter.meter.empty() ? "not known" : correction_words(state, now_unix_ns, "ago");
  auto words =
      fmt::format("{}: {}; {}", to_string(kind), printable(what, kLongestWords), known.from);
  if (old) words += fmt::format("; older than {} days", kOldFrom_days);
  if (future) words += "; look at the clock of this computer, then make it again";
  if (state.made_unix_ns && !old && !future && state.on.value_or(true)) {
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
