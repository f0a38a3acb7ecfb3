// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/measure.hpp"

#include <fmt/format.h>

#include <cmath>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"

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
    const double needed_s = each_s * static_cast<double>(readings);
    out.refuse(Refusal(std::move(*why), at_least(within, needed_s, rig.protocol())));
  }
  out.note = fmt::format(
      "{} readings in {:.4g} s need a conversion of at most {:.0f} ms; aperture "
      "{} takes {:.0f} ms",
      readings, time_s, std::floor(time_s / static_cast<double>(readings) * 1e3),
      to_string(meter.aperture), each_s * 1e3);
  rig.add_readings(readings);
  return out;
}

}  // namespace lcrig
