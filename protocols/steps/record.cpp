// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/record.hpp"

#include <optional>
#include <string>
#include <utility>

#include "base/either.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

RecordStep RecordStep::parse(const StepReader& r) {
  RecordStep out;
  out.duration = r.optional("for", Dimension::time, kTimes);
  if (const auto until = r.json.find("until")) {
    static constexpr std::pair<std::string_view, bool> kUntil[] = {{"confirmed", true}};
    out.until_confirmed = until->word<bool>(kUntil);
    out.timeout = r.timeout();
  }
  if (out.duration.has_value() == out.until_confirmed) {
    r.json.refuse("expected exactly one of for_s (or another unit) and \"until\": \"confirmed\"");
  }
  return out;
}

StepPlan RecordStep::plan(PlannedRig& rig) const {
  StepPlan out(rig.get(until_confirmed ? timeout : *duration));
  if (until_confirmed) out.note = "until confirmed, at most this long";
  return out;
}

Task<Result<>> RecordStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  if (!until_confirmed) co_return co_await wait_out(run.get(*duration), run, progress.time);
  Clock& clock = run.setup.clock;
  const MonoTime deadline = progress.time.begin(clock.now(), from_seconds(run.get(timeout)));
  std::string prompt = "Recording. Confirm to end the recording.";
  // Nothing is ordered to move, except by a held force.
  std::optional<ProgressKeeper::Shown> waiting;
  if (run.drive.is_holding_force()) {
    prompt += " The frame moves to hold the force.";
  } else {
    auto shown = co_await run.wait_for_person(deadline);
    if (!shown) co_return fail(shown.error());
    waiting.emplace(std::move(*shown));
  }
  auto r = co_await either(run.setup.person->confirm(prompt), clock.wait_until(deadline));
  if (r.index() == 0) co_return std::get<0>(r);
  run.event(EventKind::late, "nobody confirmed the end of the recording; it ended by its time-out");
  co_return Result<>();
}

}  // namespace lcrig
