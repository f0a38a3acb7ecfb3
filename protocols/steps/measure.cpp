// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/measure.hpp"

#include <fmt/format.h>

#include <cmath>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

MeasureStep MeasureStep::parse(const StepReader& r) {
  MeasureStep out;
  out.count = r.count("count", 1, kCountMax);
  out.within = r.required("within", Dimension::time, kTimes);
  return out;
}

StepPlan MeasureStep::plan(PlannedRig& rig) const {
  const auto readings = std::llround(rig.get(count));
  const double time_s = rig.get(within);
  const LcrSettings& meter = rig.meter();
  const double each_s = to_seconds(rig.known().lcr.conversion_time(meter));
  StepPlan out(time_s);
  if (auto why = check_measure(readings, time_s, meter, rig.known().lcr)) {
    // Question and answer take 4 ms on the line, which is 5 % of the shortest conversion.
    const double needed_s =
        1.05 * reading_interval_s(meter, rig.known().lcr) * static_cast<double>(readings);
    out.refuse(Refusal(std::move(*why), at_least(within, needed_s, rig.asked())));
  }
  out.note = fmt::format(
      "{} readings in {:.4g} s need a conversion of at most {:.0f} ms; aperture "
      "{} takes {:.0f} ms",
      readings, time_s, std::floor(time_s / static_cast<double>(readings) * 1e3),
      to_string(meter.aperture), each_s * 1e3);
  rig.add_level(readings, time_s);
  return out;
}

// A level that is measured again gets a new number: after a loss, if the protocol wants that, and
// whenever one of its readings turned out to be unproven. The readings of the first one stay, and
// an event says that they do not count.
void MeasureStep::Progress::begin_again(RunParts& run) {
  if (!level) return;
  run.event(LevelAbandonedEvent{level->level, readings});
  run.labels.abandon();
  level.reset();
  readings = 0;
}

Task<Result<>> MeasureStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  if (progress.level && run.sampler.is_spoiled(progress.level->begin)) progress.begin_again(run);
  const auto readings = static_cast<std::int64_t>(std::llround(run.get(count)));
  if (!progress.level) {
    progress.level = run.labels.next(run.log.step_id(), readings, run.setup.clock.now());
    run.setup.sink.level(*progress.level);
  }
  Sampler::Plan order;
  order.level = *progress.level;
  order.within = from_seconds(run.get(within));
  co_return co_await run.sampler.take(order, progress.readings);
}

}  // namespace lcrig
