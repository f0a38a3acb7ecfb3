// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/set_lcr.hpp"

#include <cmath>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

SetLcrStep SetLcrStep::parse(const StepReader& r) {
  SetLcrStep out;
  out.frequency = r.optional("frequency", Dimension::frequency, kFrequencyRange);
  out.level = r.optional("level", Dimension::voltage, kLevelRange);
  out.bias = r.optional("bias", Dimension::voltage, kBiasRange);
  if (const auto off = r.json.find("bias")) {
    static constexpr std::pair<std::string_view, bool> kOff[] = {{"off", true}};
    out.bias_off = off->word<bool>(kOff);
  }
  if (out.bias && out.bias_off) r.json.refuse("a bias voltage and \"off\", expected one of them");
  if (r.json.has("average")) out.average = r.count("average", 1, kAverageMax);
  if (r.json.has("aperture")) out.aperture = r.json.word<Aperture>("aperture");
  if (r.json.has("function")) out.function = r.json.word<LcrFunction>("function");
  if (r.json.has("trigger")) out.trigger = r.json.word<LcrTrigger>("trigger");
  if (r.json.keys().size() < 3) r.json.refuse("no setting, expected at least one to change");
  return out;
}

LcrSettings SetLcrStep::change(LcrSettings settings, const Environment& env) const {
  if (frequency) settings.frequency = Frequency::from_si(env.get(*frequency));
  if (level) settings.level = Voltage::from_si(env.get(*level));
  if (bias) settings.bias = Voltage::from_si(env.get(*bias));
  if (bias_off) settings.bias.reset();
  if (average) settings.average = static_cast<int>(std::lround(env.get(*average)));
  if (aperture) settings.aperture = *aperture;
  if (function) settings.function = *function;
  if (trigger) settings.trigger = *trigger;
  // With the bus trigger each reading is requested, and polling does not apply.
  if (settings.trigger == LcrTrigger::bus) settings.poll_interval.reset();
  return settings;
}

StepPlan SetLcrStep::plan(PlannedRig& rig) const {
  // Each changed setting takes 0.15 s, and so does the trigger; the read-back of all takes little.
  constexpr double kPace_s = 0.15;
  const LcrCapabilities& meter = rig.known().lcr;
  const auto count = [](const auto&... key) { return (0 + ... + (key ? 1 : 0)); };
  const int sent = count(frequency, level, bias, bias_off, average, aperture, function);
  StepPlan out(to_seconds(meter.settling + meter.read_back) + kPace_s * (sent + 1));
  out.note = fmt::format("settles for {:.3g} s", to_seconds(meter.settling));
  rig.set_meter(change(rig.meter(), rig.environment()));
  if (auto why = check_lcr(rig.meter(), meter)) {
    const double Hz = rig.meter().frequency.si();
    std::vector<Change> changes;
    if (frequency && Hz > meter.frequency_max.si()) {
      changes = at_most(*frequency, meter.frequency_max.si(), rig.asked());
    } else if (frequency && Hz < meter.frequency_min.si()) {
      changes = at_least(*frequency, meter.frequency_min.si(), rig.asked());
    }
    out.refuse(Refusal(std::move(*why), std::move(changes)));
  }
  return out;
}

Task<Result<>> SetLcrStep::execute(RunParts& run, StepProgress& /*remembered*/) const {
  LcrSettings s = change(run.sampler.settings(), run.values);
  auto set = co_await run.sampler.configure(std::move(s));
  if (!set) co_return set;
  const Duration conversion = run.setup.lcr.capabilities().conversion_time(run.sampler.settings());
  run.event(settings_event(run.sampler.settings(), conversion));
  co_return Result<>();
}

}  // namespace lcrig
