// SPDX-License-Identifier: Apache-2.0
#include "tests/property/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/property/own_bounds.hpp"

namespace lcrig::property {

namespace {

using Drive = TruthScene::Drive;
using Change = TruthScene::Change;
using What = Happening::Kind;

constexpr auto kReach = std::chrono::milliseconds(30);  // from a request to the wire
constexpr const char* kCondition = "if the stiffness that is measured at contact allows it";

// If this is refused before the first step, the run goes on as if nobody had asked.
void stop_after(RigWorld& w, StopPlace place) {
  if (w.live() == nullptr || w.live()->is_ending()) return;
  static_cast<void>(w.live()->ask_at(PlannedStops::Kind::stop, place, "somebody stops it"));
}

void act(RigWorld& w, What kind) {
  switch (kind) {
    case What::abort: return w.interrupt(Interrupt::abort, "somebody aborts it");
    case What::freeze: return w.interrupt(Interrupt::freeze, "somebody freezes it");
    case What::shutdown: return w.interrupt(Interrupt::abort, "SIGTERM");
    case What::pause:
      if (w.live() != nullptr) w.interrupt(Interrupt::pause, "somebody pauses it");
      return;
    case What::deaf: return w.bench().break_frame([](ZwickSimFaults& f) { f.deaf = true; });
    case What::silent: return w.bench().break_frame([](ZwickSimFaults& f) { f.silent = true; });
    case What::unplug: return w.bench().unplug_frame();
    case What::after_step: return stop_after(w, StopPlace::step);
    case What::after_level: return stop_after(w, StopPlace::level);
    case What::after_cycle: return stop_after(w, StopPlace::cycle);
    case What::after_repeat: return stop_after(w, StopPlace::repeat);
  }
}

void undo(RigWorld& w, What kind) {
  switch (kind) {
    case What::pause: return w.resume();
    case What::deaf: return w.bench().break_frame([](ZwickSimFaults& f) { f.deaf = false; });
    case What::silent: return w.bench().break_frame([](ZwickSimFaults& f) { f.silent = false; });
    case What::unplug: return w.bench().plug_frame();
    default: return;
  }
}

RigWorld::Act make_act(const Happening& h) {
  RigWorld::Act a;
  a.when = h.when;
  a.n = static_cast<std::size_t>(h.n);
  a.after_s = h.after_s;
  a.act = [h](RigWorld& w) {
    if (is_of_link(h.kind)) w.scene().watch_anew(w.clock.now());
    act(w, h.kind);
  };
  a.lasts_s = h.lasts_s;
  if (h.lasts_s > 0) a.undo = [h](RigWorld& w) { undo(w, h.kind); };
  return a;
}

RigWorld::Act make_lie(const Falsehood& f, Trial::Told& told) {
  RigWorld::Act a;
  a.when = f.when;
  a.n = static_cast<std::size_t>(f.n);
  a.after_s = f.after_s;
  a.act = [f, &told](RigWorld& w) {
    told.from = w.clock.now();
    begin_lie(w, f);
  };
  a.lasts_s = f.lasts_s;
  if (f.lasts_s > 0) {
    a.undo = [f, &told](RigWorld& w) {
      told.to = w.clock.now();
      end_lie(w, f);
    };
  }
  return a;
}

double limit_of(const std::string& protocol) {
  const auto j = nlohmann::json::parse(protocol);
  const auto& limits = j.at("limits");
  return limits.contains("force_N") ? limits.at("force_N").at(1).get<double>() : 1e9;
}

// A motion that never ends may take all the time that the protocol allows.
double patience_s(const nlohmann::json& steps) {
  double sum = 0;
  for (const auto& step : steps) {
    sum += step.value("timeout_s", 0.0);
    if (step.contains("steps")) sum += 5 * patience_s(step.at("steps"));
  }
  return sum;
}

// Motion towards the specimen. The ripple of a loop that holds a force does not count.
bool is_towards(const Change& c, const sim::RandomRig& rig) {
  if (!c.is_towards) return false;
  if (c.drive == Drive::travel) return c.to > rig.plant.contact_travel_m;
  return c.to - c.force_N > 2 * rig.frame.loop_ripple_N + 8 * rig.plant.force_noise_N;
}

}  // namespace

Trial::Trial(Case c)
    : case_(std::move(c)), rig_(case_.make_rig()), limit_N_(limit_of(case_.protocol)) {
  world_ = std::make_unique<RigWorld>(rig_, case_.protocol);
}

void Trial::run() {
  for (const Happening& h : case_.happenings) world_->acts.push_back(make_act(h));
  told_.resize(case_.lies.size());
  for (std::size_t i = 0; i < case_.lies.size(); ++i) {
    world_->acts.push_back(make_lie(case_.lies[i], told_[i]));
  }
  world_->is_witnessed = !case_.lies.empty();
  world_->fault_script = case_.fault_script;
  world_->longest_s += patience_s(nlohmann::json::parse(case_.protocol).at("steps"));
  world_->run();
}

void Trial::plan_only(ParameterValues parameters) {
  world_->parameters = std::move(parameters);
  world_->plan_only = true;
  world_->run();
}

bool Trial::is_conditional() const {
  if (!world_->plan) return false;
  return std::ranges::any_of(world_->plan->steps, [](const PlannedStep& s) {
    return s.note.find(kCondition) != std::string::npos;
  });
}

bool Trial::is_declined() const {
  const auto& result = world_->result;
  return is_conditional() && result && result->exit_status == ExitStatus::fail &&
         result->code == Errc::invalid_request &&
         (result->reason.find("at contact)") != std::string::npos ||
          result->reason.find("force loop is good for") != std::string::npos);
}

bool Trial::is_honest() const {
  return !rig_.lie.is_one();
}

double Trial::uncertainty_N() const {
  return world_->plan ? world_->plan->force_uncertainty.total_N() : 0;
}

void Trial::count(Counters& n) const {
  const RigWorld& w = *world_;
  ++n["pairs"];
  if (w.refused) {
    ++n["refused"];
    return;
  }
  ++n["accepted"];
  if (is_conditional()) ++n["accepted on a condition"];
  if (is_declined()) ++n["declined at contact"];
  if (rig_.frame.watch_period_s > 0) ++n["polled rigs"];
  if (rig_.frame.revision == 1) ++n["revision 1"];
  if (rig_.frame.missing_force > 0) ++n["rigs with missing forces"];
  if (rig_.plant.force_drift_N_s != 0) ++n["rigs that drift"];
  for (const Overshoot& o : w.overshoots) {
    ++n["force-stopped motions"];
    if (o.exceeded) ++n["predictions broken"];
  }
  for (const Change& c : w.changes) {
    if (c.drive == Drive::force && c.is_towards) ++n["force-controlled rises"];
  }
  for (const RunEvent& e : w.events) {
    if (e.kind == EventKind::contact) ++n["contacts found"];
    if (e.kind == EventKind::stiffness &&
        e.detail.find("\"at_most_N_m\":null") == std::string::npos) {
      ++n["stiffness measured"];
    }
    if (e.kind == EventKind::step_begin && e.detail == "hold") ++n["holds"];
    if (e.kind == EventKind::loss) ++n["losses"];
    if (e.kind == EventKind::reconnected) ++n["reconnected"];
    if (e.kind == EventKind::loaded) ++n["left loaded, and said so"];
    if (e.kind == EventKind::limit) ++n["stopped by the guard"];
    if (e.kind == EventKind::contradiction) ++n["not believed"];
  }
  for (const std::int64_t times : w.happened) n["faults injected"] += times;
  if (!w.events.empty()) {
    const Duration took = w.events.back().t - w.events.front().t;
    n["rig seconds"] += std::llround(to_seconds(took));
  }
  if (!w.result) return;
  ++n[fmt::format("ended {}", to_string(w.result->exit_status))];
}

Broken force_within_limit(Trial& t) {
  const RigWorld& w = t.world();
  if (!w.plan || !t.is_honest()) return {};
  Broken out;
  const double printed = t.uncertainty_N(), own = own_uncertainty_N(t.rig(), t.limit_N());
  if (w.all.peak_N > t.limit_N() + printed) {
    out.push_back(
        fmt::format("limit: the true force went to {:.5g} N, the limit is {:.5g} N and "
                    "the printed uncertainty {:.3g} N",
                    w.all.peak_N, t.limit_N(), printed));
  }
  // The scatter of ten samples may be off by a third.
  const bool moves = w.plan->worst_force_N > 0;
  if (moves && printed > own + 12 * t.rig().plant.force_noise_N) {
    out.push_back(fmt::format("uncertainty: {:.3g} N are printed, our own arithmetic says {:.3g} N",
                              printed, own));
  }
  return out;
}

Broken travel_within_limits(Trial& t) {
  const double allowed = 2 * t.rig().plant.travel_resolution_m + 1e-9;
  if (!t.world().plan || t.world().outside_m <= allowed) return {};
  return {fmt::format("travel: the true travel was {:.3g} um outside of the limits",
                      t.world().outside_m * 1e6)};
}

// Forecasts rely on this bound. The cell shows forces with its gain, which its class allows. A
// bound at three standard errors may be broken by chance, but seldom and by little.
Broken stiffness_is_not_underestimated(Trial& t) {
  if (!t.is_honest()) return {};
  Broken out;
  for (const MeasuredStiffness& m : t.world().stiffnesses) {
    const double shown_N_m = t.rig().plant.force_gain * m.true_N_m;
    if (m.at_most_N_m >= 0.99 * shown_N_m) continue;
    out.push_back(fmt::format(
        "stiffness: the contact has {:.5g} N/m, the run takes it for {:.5g} N/m at most", shown_N_m,
        m.at_most_N_m));
  }
  return out;
}

Broken healthy_runs_succeed(Trial& t) {
  const RigWorld& w = t.world();
  if (!w.result || !t.what().is_within || !t.is_honest()) return {};
  for (const Overshoot& o : w.overshoots) {
    if (!o.exceeded) continue;
    return {
        fmt::format("false: {:.5g} N after a prediction of {:.5g} N is called broken on a rig "
                    "that is what it was said to be",
                    o.observed_N, o.predicted_N)};
  }
  if (t.is_declined()) return {};
  if (w.result->exit_status == ExitStatus::success) return {};
  return {fmt::format("success: a run on a healthy rig ended with {} ({})",
                      to_string(w.result->exit_status), w.result->reason)};
}

// A stop that waits cuts no step short, and comes after the step that was announced.
Broken finishes_what_is_under_way(Trial& t) {
  const RigWorld& w = t.world();
  if (!w.result || !t.what().is_within || !t.is_honest() || t.is_declined()) return {};
  std::optional<StopAfterEvent> asked;
  std::int64_t done = 0;
  bool counts = false;  // the step is not one of `finally`
  auto before = EventKind::other;
  for (const RunEvent& e : w.events) {
    if (e.kind == EventKind::stop_after) asked = from_json<StopAfterEvent>(e.detail).value();
    if (e.kind == EventKind::step_begin) counts = before == EventKind::state;
    if (e.kind == EventKind::step_end && counts && e.detail != "done") {
      return {fmt::format("planned stop: step {} was cut off by {}", e.step_id, e.detail)};
    }
    if (e.kind == EventKind::step_end && counts) ++done;
    before = e.kind.kind();
  }
  const bool stopped = w.result->exit_status == ExitStatus::stopped;
  if (!asked && stopped) return {"planned stop: nobody asked for it"};
  if (!asked || (ended_well(w.result->exit_status) && done == asked->steps_done)) return {};
  return {fmt::format("planned stop: {} steps were done, {} were to be; the run ended {} ({})",
                      done, asked->steps_done, to_string(w.result->exit_status), w.result->reason)};
}

Broken ends_standing_and_honest(Trial& t) {
  const RigWorld& w = t.world();
  Broken out;
  if (!w.is_clean) out.push_back("clean: something still waits after the run");
  if (!w.replay_differs.empty()) out.push_back("replay: " + w.replay_differs);
  if (w.too_long) out.push_back("long: it did not end by itself");
  const std::string reason = w.result ? w.result->reason : "";
  const bool failed = !w.result || !ended_well(w.result->exit_status);
  const bool says_so =
      reason.find("standstill") != std::string::npos || reason.find("E-stop") != std::string::npos;
  if (!w.stood && !(failed && says_so)) {
    out.push_back(
        fmt::format("standing: the frame moves at the end, and the reason is `{}`", reason));
  }
  const double unloaded = 0.02 * t.limit_N() + 8 * t.rig().plant.force_noise_N +
                          own_uncertainty_N(t.rig(), t.limit_N());
  const bool told = reason.find("loaded") != std::string::npos ||
                    reason.find("pulls") != std::string::npos ||
                    reason.find("the frame is not there") != std::string::npos;
  if (w.last_N > unloaded && !(failed && told)) {
    out.push_back(
        fmt::format("loaded: {:.4g} N press at the end, and the reason is `{}`", w.last_N, reason));
  }
  // The rule for the way back must never keep the frame on the specimen.
  if (reason.find("rises on the way back") != std::string::npos && t.what().fault_script.empty()) {
    out.push_back(fmt::format("return: `finally` was ended, and the reason is `{}`", reason));
  }
  if (w.changes.size() > w.changes_at_end) {
    const auto& last = w.changes.back();
    if (last.drive != Drive::halt) out.push_back("over: something moves after the run was over");
  }
  return out;
}

Broken nothing_moves_after_the_stop(Trial& t) {
  const RigWorld& w = t.world();
  for (std::size_t i = 0; i < t.what().happenings.size(); ++i) {
    const What kind = t.what().happenings[i].kind;
    if (kind != What::abort && kind != What::freeze && kind != What::shutdown) continue;
    if (i >= w.acted.size()) continue;
    const RigWorld::Acted& a = w.acted[i];
    for (std::size_t k = 0; k < w.changes.size(); ++k) {
      const Change& c = w.changes[k];
      if (c.drive == Drive::halt || c.at <= a.at + kReach) continue;
      const bool may = kind != What::freeze && w.was_finishing[k];
      if (may) continue;
      return {fmt::format("after: {:.3f} s after {} the frame was set in motion",
                          to_seconds(c.at - a.at), to_string(kind))};
    }
  }
  return {};
}

Broken lost_within_the_second_figure(Trial& t) {
  const RigWorld& w = t.world();
  if (!w.plan || !t.is_honest()) return {};
  const double most = std::max(w.plan->lost_force_N, 0.0) + t.uncertainty_N();
  const double felt = std::max(w.all.peak_N, w.since.peak_N);
  if (felt <= most) return {};
  return {
      fmt::format("lost: the true force went to {:.5g} N, the plan says {:.5g} N without link, "
                  "and an uncertainty of {:.3g} N",
                  felt, w.plan->lost_force_N, t.uncertainty_N())};
}

Broken lies_are_not_pressed_again(Trial& t) {
  const RigWorld& w = t.world();
  const double noise_N = t.rig().plant.force_noise_N;
  std::optional<MonoTime> broken;
  std::string why;
  for (const Overshoot& o : w.overshoots) {
    const bool own = o.observed_N > 1.01 * o.predicted_N + 8 * noise_N;
    if (own && !o.exceeded) {
      return {fmt::format("unseen: {:.5g} N were predicted, {:.5g} N seen, and nobody said so",
                          o.predicted_N, o.observed_N)};
    }
    if (!o.exceeded || broken) continue;
    broken = o.at;
    why = fmt::format("{:.5g} N were predicted and {:.5g} N seen", o.predicted_N, o.observed_N);
  }
  const double most = t.limit_N() + t.uncertainty_N() + 8 * noise_N;
  for (const Change& c : w.changes) {
    if (broken && c.at > *broken + kReach && is_towards(c, t.rig())) {
      return {fmt::format("again: {}, and {:.3f} s later the frame was driven towards the specimen",
                          why, to_seconds(c.at - *broken))};
    }
    if (c.force_N > most && !broken) {
      broken = c.at + std::chrono::milliseconds(300);
      why = fmt::format("the true force was {:.5g} N, beyond the limit of {:.5g} N", c.force_N,
                        t.limit_N());
    }
  }
  return {};
}

Broken refused_and_nothing_moved(Trial& t) {
  const RigWorld& w = t.world();
  if (!w.refused) return {};
  Broken out;
  if (w.motions > 0) out.push_back(fmt::format("moved: {} commands were sent", w.motions));
  const bool drove =
      std::ranges::any_of(w.changes, [](const Change& c) { return c.drive != Drive::halt; });
  if (drove) out.push_back("moved: the frame was set in motion by a run that was refused");
  const bool observable = t.rig().frame.revision >= 2;
  if (observable && w.refused->code == Errc::invalid_request && w.hellos + w.stops > 0) {
    out.push_back("commanded: a frame that can be observed was greeted by a plan that was refused");
  }
  return out;
}

}  // namespace lcrig::property
