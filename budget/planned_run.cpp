// SPDX-License-Identifier: Apache-2.0
#include "budget/planned_run.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "model/auto_level.hpp"
#include "model/response.hpp"
#include "protocols/expand.hpp"

namespace lcrig {

namespace {

MeterSetting setting_of(const LcrSettings& s, const LcrCapabilities& caps) {
  MeterSetting out;
  out.frequency_Hz = s.frequency.si();
  out.level_V = s.level.si();
  out.aperture = s.aperture;
  out.average = s.average;
  out.internal_trigger = s.trigger == LcrTrigger::internal;
  out.conversion_s = to_seconds(caps.conversion_time(s));
  return out;
}

double reading_noise_F(const MeterSetting& m, const Rig& rig) {
  if (!rig.noise) return meter_noise_F(m);
  const double once = rig.noise->capacitance_F[static_cast<std::size_t>(m.aperture)];
  return once * (1000 / m.frequency_Hz) / m.level_V / std::sqrt(m.average);
}

// Follows the force through the steps of a protocol and collects the readings.
class Walk {
 public:
  Walk(const Protocol& protocol, const Environment& environment, const Rig& rig, const Plan& plan)
      : protocol_(protocol),
        environment_(environment),
        rig_(rig_for(protocol, rig)),
        area_m2_(rig_.pressure.area_m2().value_or(0)) {
    interval_ = reading_interval_s(plan.lcr, rig.lcr);
    continuous_ = protocol.sample.lcr_continuous;
    for (const PlannedStep& s : plan.steps) {
      if (s.times > 0) seconds_[s.id] = s.total_s / static_cast<double>(s.times);
    }
    edge_ = kCycleEdge * plan.peak_force_N;
  }

  Result<> run() {
    StepCursor cursor(protocol_.steps, environment_);
    while (const Step* step = cursor.next()) {
      if (facts_of(*step).sets_meter != nullptr) {
        return fail(Errc::invalid_request,
                    "{}: step {} changes the meter's settings: a budget needs one setting for all",
                    protocol_.name, step->id);
      }
      take(*step);
    }
    finish();
    // A line is fitted to one direction, the one with more levels, as in the analysis.
    if (falling_.size() > levels.size()) levels.swap(falling_);
    if (levels.empty() && cycles.empty()) {
      return fail(Errc::invalid_request, "{}: it never loads the specimen by itself",
                  protocol_.name);
    }
    return {};
  }

  bool shows_drift() {
    StepCursor cursor(protocol_.steps, environment_);
    while (const Step* step = cursor.next()) take(*step);
    finish();
    const auto told = std::ranges::count_if(
        rests, [](const PlannedRest& r) { return r.readings >= kLeastOfRest; });
    return cycles.empty() || told >= 2;
  }

  std::vector<PlannedLevel> levels;
  std::vector<PlannedCycle> cycles;
  std::vector<PlannedRest> rests;

 private:
  void finish() {
    StepCursor cursor(protocol_.finally_steps, environment_);
    while (const Step* step = cursor.next()) take(*step);
    end_cycle();
    end_rest();
  }

  double readings_in(double seconds) const {
    return continuous_ ? std::max(seconds, 0.0) / interval_ : 0;
  }
  double kPa(double force_N) const { return force_N / area_m2_ * 1e-3; }
  double way(double force_N) const {
    return rig_.compression_m && force_N > 0 ? rig_.compression_m(force_N) : 0;
  }

  void take(const Step& step) {
    const auto found = seconds_.find(step.id);
    const double seconds = found == seconds_.end() ? 0 : found->second;
    const StepFacts facts = facts_of(step);
    switch (facts.frame_use) {
      case FrameUse::Kind::weight: place(*facts.aim, seconds); break;
      case FrameUse::Kind::motion:
      case FrameUse::Kind::cycle: move(facts, seconds); break;
      case FrameUse::Kind::hold:
        if (facts.aim != nullptr) hold(*facts.aim);
        watch(facts, seconds);
        break;
      case FrameUse::Kind::zero:
      case FrameUse::Kind::watch: watch(facts, seconds); break;
    }
    time_s_ += seconds;
  }

  void watch(const StepFacts& facts, double seconds) {
    if (facts.measures == nullptr) return stay(readings_in(seconds), seconds);
    measure(environment_.get(facts.measures->count), seconds);
  }

  // A search for contact has no aim and leaves no force.
  void move(const StepFacts& facts, double seconds) {
    if (facts.aim == nullptr) return watch(facts, seconds);
    go(*facts.aim, facts.speed != nullptr ? environment_.get(*facts.speed) : 0, seconds);
  }

  // The force loop of the frame goes to the target and stays there.
  void hold(const Target& at) {
    const double force = target_force_N(at, environment_, rig_);
    if (force <= edge_) end_cycle();
    force_ = force;
    if (force_ <= 0) begin_repeat();
  }

  void go(const Target& to, double speed, double seconds) {
    const double from = force_;
    if (!is_force(to)) {
      unload(speed, seconds);
      return;
    }
    force_ = target_force_N(to, environment_, rig_);
    if (force_ > edge_ && speed > 0 && force_ > from) {
      loading_s_ = (way(force_) - way(from)) / speed;
      peak_s_ = time_s_ + seconds;
      // Without a specimen the plan cannot know where on the way the probe touches.
      if (rig_.compression_m) rest(time_s_, seconds - loading_s_);
    } else if (force_ > from && seconds > 0) {
      rise({kPa(from), kPa(force_), readings_in(seconds), seconds});
    }
  }

  // Moves up. The force falls to zero during the first part of the way.
  void unload(double speed, double seconds) {
    const double falling = speed > 0 ? way(force_) / speed : 0;
    falling_s_ = falling;
    end_cycle();
    force_ = 0;
    begin_repeat();
    rest(time_s_ + falling, seconds - falling);
  }

  void place(const Target& load, double seconds) {
    const double force = target_force_N(load, environment_, rig_);
    if (force <= edge_) end_cycle();
    // The person takes this time before the load is in place.
    if (force_ <= edge_) rest(time_s_, seconds);
    force_ = force;
    if (force_ <= 0) begin_repeat();
  }

  // A level whose force is below the edge of a cycle is a level, too.
  void measure(double count, double seconds) {
    if (force_ > 0) {
      if (force_ > edge_ && cycle_ended_) begin_repeat();
      (force_ > last_level_ ? levels : falling_)
          .push_back({kPa(force_), count, repeat_, time_s_ + seconds / 2});
      last_level_ = force_;
    }
    stay(count, seconds, true);
  }

  void begin_repeat() {
    if (last_level_ > 0) ++repeat_;
    last_level_ = 0;
    cycle_ended_ = false;
  }

  void stay(double readings, double seconds, bool is_level = false) {
    if (force_ > edge_) {
      rise({kPa(force_), kPa(force_), readings, seconds, is_level});
    } else if (force_ <= 0) {
      rest_until(time_s_, time_s_ + seconds, readings);
    }
  }

  void rise(const PlannedStretch& stretch) {
    rising_.push_back(stretch);
    if (stretch.to_kPa >= peak_kPa_) {
      peak_kPa_ = stretch.to_kPa;
      peak_s_ = time_s_ + stretch.seconds / 2;
    }
  }

  void rest(double from_s, double seconds) {
    if (seconds > 0) rest_until(from_s, from_s + seconds, readings_in(seconds));
  }

  void rest_until(double from_s, double to_s, double readings) {
    if (rest_.readings <= 0) rest_.from_s = from_s;
    rest_.to_s = to_s;
    rest_.readings += readings;
  }

  void end_cycle() {
    const double peak_kPa = std::max(peak_kPa_, loading_s_ > 0 ? kPa(force_) : 0.0);
    if (peak_kPa > kPa(edge_)) {
      end_rest();
      cycles.push_back({peak_kPa, peak_s_, std::move(rising_), loading_s_, falling_s_});
      cycle_ended_ = true;
    }
    rising_.clear();
    peak_kPa_ = loading_s_ = falling_s_ = 0;
  }

  // Closes a rest. After a load only its later half counts, because the specimen still recovers.
  void end_rest() {
    const double counts = cycles.empty() ? 1 : 0.5;
    rests.push_back(
        {rest_.to_s - counts / 2 * (rest_.to_s - rest_.from_s), counts * rest_.readings});
    rest_ = {};
  }

  struct Rest {
    double from_s = 0, to_s = 0, readings = 0;
  };

  const Protocol& protocol_;
  Environment environment_;
  const Rig rig_;
  const double area_m2_;  // that pressures are over
  std::map<std::string, double> seconds_;
  double interval_ = 1, edge_ = 0;
  bool continuous_ = true;
  double time_s_ = 0;  // at the beginning of the step
  double force_ = 0, last_level_ = 0;
  int repeat_ = 1;
  bool cycle_ended_ = false;  // and there was no level since
  double peak_kPa_ = 0, peak_s_ = 0, loading_s_ = 0, falling_s_ = 0;  // of the present cycle
  std::vector<PlannedStretch> rising_;
  Rest rest_;
  std::vector<PlannedLevel> falling_;
};

// Visits all steps, including those inside loops.
void each_step(const Steps& steps, const auto& visit) {
  for (const Step& step : steps) {
    visit(step);
    if (const Loop* loop = facts_of(step).loop) each_step(loop->steps, visit);
  }
}

// The same, for a visitor that may replace their actions.
void change_steps(Steps& steps, const auto& visit) {
  for (Step& step : steps) {
    visit(step);
    if (facts_of(step).loop == nullptr) continue;
    auto loop = step.action->copy();
    change_steps(dynamic_cast<Loop&>(*loop).steps, visit);
    step.action = std::move(loop);
  }
}

}  // namespace

Result<SpecimenCurve> tabulate(const Specimen& specimen, Force force_max,
                               const PressureArea& pressure) {
  if (auto whole = require_whole_disc(pressure); !whole) return fail(whole.error());
  const Pressure most = Pressure::from_si(force_max.si() / specimen.area_m2());
  Result<LevelChoice> choice = fail(Errc::bug, "no tolerance");
  double tolerance = 0;
  ErrorEstimator estimator(specimen);  // used again, because it keeps its solutions
  for (const double t : kUsefulTolerances) {
    tolerance = t;
    choice = choose_level(estimator, t, most);
    if (choice) break;
  }
  if (!choice) return fail(choice.error());
  auto response = make_response(specimen, choice->settings, force_max, tolerance);
  if (!response) return fail(response.error());
  const std::shared_ptr<TabulatedResponse> table = std::move(*response);
  SpecimenCurve out;
  out.c0_F = table->c0_F();
  out.level = to_string(choice->settings.level);
  out.delta_C_fF = [table, area = pressure.area_m2().value_or(0)](double kPa) {
    return table->delta_capacitance_F(kPa * 1e3 * area) * 1e15;
  };
  return out;
}

Result<PlannedRun> plan_readings(const Protocol& protocol, const Environment& environment,
                                 const Rig& rig, const Plan& plan, const SpecimenCurve& curve) {
  if (!plan.pressure.area_m2() || !rig.compression_m) {
    return fail(Errc::invalid_request,
                "a budget needs the probe's diameter (fixture of the bench) and the specimen");
  }
  Walk walk(protocol, environment, rig, plan);
  if (auto ok = walk.run(); !ok) return fail(ok.error());
  PlannedRun out;
  out.meter = setting_of(plan.lcr, rig.lcr);
  out.reading_noise_F = reading_noise_F(out.meter, rig);
  if (rig.noise) {
    out.force_noise_N = rig.noise->force_N;
    out.noise_guessed = rig.noise->guessed[static_cast<std::size_t>(out.meter.aperture)];
    out.noise_basis = rig.noise->basis + (out.noise_guessed ? ": a guess" : "");
  }
  out.interval_s = reading_interval_s(plan.lcr, rig.lcr);
  if (out.meter.internal_trigger && !plan.lcr.poll_interval) {
    out.later_s = to_seconds(rig.lcr.found_later);
    out.earlier_s = to_seconds(rig.lcr.found_earlier);
  }
  out.sample_s = plan.frame_rate_Hz > 0 ? 1 / plan.frame_rate_Hz : 0;
  out.area_m2 = *plan.pressure.area_m2();
  out.pressure = plan.pressure;
  out.c0_F = curve.c0_F;
  out.delta_C_fF = curve.delta_C_fF;
  out.compression_m = rig.compression_m;
  out.dead_weights = rig.frame.weights;
  if (rig.frame.force_class) out.force_class_percent = rig.frame.force_class->percent();
  out.levels = std::move(walk.levels);
  out.cycles = std::move(walk.cycles);
  out.rests = std::move(walk.rests);
  return out;
}

bool shows_drift(const Protocol& protocol, const Environment& environment, const Rig& rig,
                 const Plan& plan) {
  return Walk(protocol, environment, rig, plan).shows_drift();
}

Variant with_settings(const Protocol& protocol, const Environment& environment, const Rig& rig,
                      Aperture aperture, Frequency frequency) {
  Variant out;
  out.protocol = protocol;
  out.protocol.sample.aperture_auto = false;
  out.protocol.sample.lcr.aperture = aperture;
  out.protocol.sample.lcr.frequency = frequency;
  const double conversion = to_seconds(rig.lcr.conversion_time(out.protocol.sample.lcr));
  Environment env = environment;
  change_steps(out.protocol.steps, [&](Step& step) {
    const Readings* measure = facts_of(step).measures;
    if (!measure) return;
    const bool known = measure->count.name.empty() || env.values().contains(measure->count.name);
    const bool timed = measure->within.name.empty() || env.values().contains(measure->within.name);
    if (!known || !timed) return;  // a sweep variable: the plan will tell whether it fits
    const double needed = env.get(measure->count) * conversion;
    if (env.get(measure->within) >= needed) return;
    const double within = std::ceil(needed * kReadingSlack * 10) / 10;
    const std::string& name = measure->within.name;
    const bool named = protocol.parameters.contains(name);
    out.note = named ? fmt::format("needs -p {}={:g}", name, within)
                     : fmt::format("within_s of step {} must be {:g}", step.id, within);
    if (named) out.parameters[name] = std::max(out.parameters[name], within);
    out.by_parameters = out.by_parameters && named;
    auto longer = step.action->copy();
    dynamic_cast<Readings&>(*longer).within = Number(within);
    step.action = std::move(longer);
  });
  return out;
}

Knobs find_knobs(const Protocol& protocol) {
  std::set<std::string> readings, within;
  bool fixed = false;
  each_step(protocol.steps, [&](const Step& step) {
    const Readings* measure = facts_of(step).measures;
    if (!measure) return;
    readings.insert(measure->count.name);
    within.insert(measure->within.name);
    fixed = fixed || !protocol.parameters.contains(measure->count.name) ||
            !protocol.parameters.contains(measure->within.name);
  });
  Knobs out;
  if (!fixed && readings.size() == 1 && within.size() == 1) {
    out.readings = *readings.begin();
    out.within = *within.begin();
  }
  for (const Step& step : protocol.steps) {
    const StepFacts facts = facts_of(step);
    const Number* count = facts.loop ? facts.loop->repeats() : nullptr;
    if (count != nullptr && protocol.parameters.contains(count->name)) out.repeats = count->name;
  }
  return out;
}

}  // namespace lcrig
