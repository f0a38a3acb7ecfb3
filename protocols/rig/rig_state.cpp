// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/rig_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/rig/corridor.hpp"

namespace lcrig {

RigState::RigState(RigFacts f, std::optional<Forecast> c)
    : facts(std::move(f)),
      limits(facts.limits),
      forecast(std::move(c)),
      prediction_(facts.frame.cell(), shown_after(facts.frame)) {
  frame.caps = facts.frame;
}

Result<> Trust::may_press() const {
  if (no_pressing) return fail(Errc::limit_tripped, "{}", *no_pressing);
  return {};
}

Result<> Trust::may_move() const {
  if (!no_motion) return {};
  Error refusal = *no_motion;
  refusal.what += ": nothing is moved any more";
  return fail(std::move(refusal));
}

double RigState::zero_uncertainty_N() const {
  return facts.cell.zero_error_N(facts.frame.force_max.si());
}

double RigState::load_tolerance_N() const {
  const double noise_N = cell.unloaded ? cell.unloaded->scatter_N() : 0;
  return std::max(kNoiseSigmas * noise_N, kOfLimit * facts.limits.force_max_N);
}

bool RigState::is_loaded(double force_N) const {
  return force_N - cell.unloaded_at_most_N() > load_tolerance_N();
}

bool RigState::is_pulled(double force_N) const {
  return cell.unloaded_N() - force_N - zero_uncertainty_N() > load_tolerance_N();
}

bool RigState::stood_pulled() const {
  return course.is_force_known && *frame.force_N < limits.force_min_N;
}

bool RigState::shows_force() const {
  if (!frame.force_N || frame.overloaded) return false;
  const Duration new_enough = from_seconds(kNewSamples / facts.rate_Hz);
  return !frame.last_sample || *frame.last_sample - frame.force_at <= new_enough;
}

double RigState::travel_step_m() const {
  return facts.frame.travel_step ? facts.frame.travel_step->si() : course.finest_step_m;
}

double RigState::travel_step_at_most_m() const {
  const double known_m = travel_step_m();
  return known_m > 0 ? known_m : kCoarsestStep_m.value;
}

double RigState::travel_tolerance_m() const {
  return kPlace_m + kTravelSteps * travel_step_m() + kNoiseSigmas * tolerances.travel_noise_m;
}

double RigState::still_m() const {
  if (!is_watched()) return kStanding_m;
  return std::max(tolerances.against_m, kTravelSteps * travel_step_m());
}

double RigState::standing_m() const {
  return std::max(tolerances.standing_m, kTravelSteps * travel_step_m());
}

double RigState::standing_noise_N() const {
  return std::sqrt(course.noise_N2);
}

std::optional<double> RigState::relaxes_N_s() const {
  if (frame.motion != FrameMotion::standing || !course.stood_first) return std::nullopt;
  const double dt = to_seconds(course.stood_last->t - course.stood_first->t);
  if (dt < kObserved_s) return std::nullopt;
  const double lost_N = course.stood_first->force_N - course.stood_last->force_N;
  return std::max(0.0, lost_N + tolerances.contact_force_N) / dt;
}

// At the slowest speeds the expected way must exceed what a drive may hunt.
double RigState::stall_s() const {
  const Order& order = frame.order;
  if (order.direction == 0) {
    return std::max(tolerances.stall_s, 4 * tolerances.order_force_N / order.rate_N_s);
  }
  const double way_m = std::max(1.5 * tolerances.against_m, 3 * travel_step_at_most_m());
  return std::max(tolerances.stall_s, way_m / order.speed_m_s);
}

Order RigState::order_now(double direction, double speed_m_s, double measured_noise_N) const {
  Order m;
  m.direction = direction;
  m.speed_m_s = speed_m_s;
  m.force_N = frame.force_N.value_or(0);
  // For a motion into the specimen the last known force counts, however old it is.
  m.force_known = direction >= 0 || shows_force();
  m.zero_N = cell.zero_N();
  m.free_N = cell.unloaded_at_most_N();
  const double felt_N = std::abs(m.force_N - m.zero_N);
  const double noise_N = std::max({cell.noise_bound_N(), measured_noise_N, standing_noise_N()});
  const double least_N = std::max(kDifferenceSigmas * noise_N, kLeastOfLimit * force_max_N());
  m.against_N = least_N + (direction > 0 ? kRelaxes : kGivesBack) * felt_N + zero_uncertainty_N();
  m.drift_N_s = cell.drift_N_s;
  if (direction > 0) {  // pressing a specimen never makes it pull
    const double left_N = m.force_N - limits.force_min_N;
    m.against_N = std::min(m.against_N, std::max(left_N, kDifferenceSigmas * noise_N));
  }
  return m;
}

Order RigState::hold_now(double force_N, double measured_noise_N) const {
  Order m = order_now(0, 0, measured_noise_N);
  m.holds = true;
  m.to_N = force_N;
  if (const auto& loop = facts.frame.force_loop) m.loop_N = loop->ripple.si();
  return m;
}

RigState::Applied RigState::apply(const WatchInputEvent& e, const RestMeasurement* rest,
                                  MonoTime at) {
  Applied out;
  if (e.what == WatchInput::compared) {
    out.compared = compare(e);
  } else if (rest != nullptr) {
    out.tolerances = learn(e.what, *rest);
  } else {
    apply_fact(e, at);
  }
  return out;
}

std::optional<ForceComparison> RigState::compare(const WatchInputEvent& e) {
  if (!forecast) return std::nullopt;
  MotionOutcome outcome;
  outcome.reason = parse_word<MotionEnd>(e.reason.value_or("")).value_or(MotionEnd::fault);
  outcome.force_N = e.force_N;
  outcome.travel_m = e.travel_m;
  auto compared = prediction_.end(outcome, e.noise_N.value_or(0));
  trust_pressing(compared);
  return compared;
}

// Returns whether there are new tolerances.
bool RigState::learn(WatchInput what, const RestMeasurement& rest) {
  switch (what) {
    case WatchInput::rest_measurement: return learn_zero(rest, true);
    case WatchInput::rest_measurement_near_contact: return learn_zero(rest, false);
    case WatchInput::noise: return learn_noise(rest);
    default: cell.noise = CellNoise(rest); return false;
  }
}

// lint: table
void RigState::apply_fact(const WatchInputEvent& e, MonoTime at) {
  const double force_N = e.force_N.value_or(0), travel_m = e.travel_m.value_or(0);
  const double stiffness_N_m = e.stiffness_N_m.value_or(0);
  const bool on = e.on.value_or(false);
  switch (e.what) {
    case WatchInput::order: start(order_of(e), at); break;
    case WatchInput::permit:
      if (forecast) prediction_.begin(permit_of(e));
      break;
    case WatchInput::motion_end: take_standstill(e, at); break;
    case WatchInput::standstill: stand(at, e.travel_m); break;
    case WatchInput::motion_unknown: lose_motion(); break;
    case WatchInput::force_loop: prediction_.leave_to_loop(); break;
    case WatchInput::zero_before_contact: cell.untouched_N = force_N; break;
    case WatchInput::force_zeroed: zero_force(at, e); break;
    case WatchInput::zero_hides: hide(force_N); break;
    case WatchInput::zero_took: cell.zeros_under_load_N += force_N; break;
    case WatchInput::zero: set_limits_zero(force_N, e.noise_N.value_or(0)); break;
    case WatchInput::force_invalid: invalidate_force(); break;
    case WatchInput::contact: place_contact(travel_m, force_N); break;
    case WatchInput::contact_depth: contact.depth_m = travel_m; break;
    case WatchInput::contact_unknown: contact.forget(); break;
    case WatchInput::contact_taken_over: contact.travel_m = e.travel_m; break;
    case WatchInput::search: contact.searched_from_m = e.travel_m; break;
    case WatchInput::least_stiffness:
      if (is_watched()) contact.least.emplace(at, travel_m, force_N, stiffness_N_m);
      break;
    case WatchInput::largest_stiffness:
      if (forecast) forecast->measured(force_N, stiffness_N_m);
      break;
    case WatchInput::travel_zeroed: zero_travel(travel_m, at); break;
    case WatchInput::prepared: is_prepared = on; break;
    case WatchInput::stop_pending: is_stop_pending = on; break;
    case WatchInput::run_start: contact.start_travel_m = e.travel_m; break;
    case WatchInput::zeros_taken_over: frame.seen.zeroed = on, cell.zeros_N = e.force_N; break;
    case WatchInput::link_back: frame.seen.forget(); break;
    case WatchInput::pressing_locked_out:
      if (forecast) trust.no_pressing = e.reason.value_or("");
      break;
    case WatchInput::motion_locked_out:
      trust.no_motion = Error(Errc::frame_fault, e.reason.value_or(""));
      break;
    case WatchInput::age_watched: watches_age = on; break;
    case WatchInput::age_restarted: course.force_at = course.travel_at = at; break;
    case WatchInput::stopping: phase = RunPhase::stopping; break;
    case WatchInput::retreat: start_retreat(e.noise_N.value_or(0)); break;
    case WatchInput::ended: phase = RunPhase::ended; break;
    case WatchInput::compared:
    case WatchInput::rest_measurement:
    case WatchInput::rest_measurement_near_contact:
    case WatchInput::noise:
    case WatchInput::live_cell: break;
  }
}

void RigState::lose_motion() {
  frame.motion = FrameMotion::unknown;
  frame.reported_m.reset();
  frame.stands_from.reset();
  course.equal_forces = 0;
}

// The force was zeroed while the probe pressed with this force. The lower limit is lowered by it,
// because the unloaded cell shows minus that force without any pull.
void RigState::hide(double pressed_N) {
  if (trust.force) limits.force_min_N -= pressed_N - std::exchange(cell.hidden_N, pressed_N);
}

// A force within the noise lowers nothing.
void RigState::set_limits_zero(double zero_N, double noise_N) {
  if (trust.force) cell.below_zero_N = zero_N < -kNoiseSigmas * noise_N ? -zero_N : 0;
}

void RigState::start_retreat(double noise_N) {
  phase = RunPhase::finally;
  course.retreat_noise_N = noise_N;
  course.retreat_from_m = frame.seen.travel_m;
}

void RigState::start(const Order& order, MonoTime at) {
  if (!is_watched()) return;
  const auto relaxes = relaxes_N_s();
  course.runs_on_m = loop_runs_on_m();
  end_motion(at);
  course.pressed.relaxes_N_s = relaxes;
  frame.motion = FrameMotion::moving;
  frame.order = order;
  frame.since = at;
  course.from_m = frame.reported_m;
  course.furthest_m.reset();
  course.peak_N.reset();
  course.before_N.reset();
  course.fallen = 0;
  course.progress.reset();
  course.idle = 0;
  course.loop.reset();
  start_pressing(at);
}

// A force loop moves as fast as it approaches, or as its ramp needs in the softest contact. Its
// last samples may still be under way.
double RigState::loop_runs_on_m() const {
  const bool by_loop = frame.motion == FrameMotion::moving && frame.order.direction == 0;
  if (!by_loop || !frame.caps.force_loop) return 0;
  double speed_m_s = frame.caps.force_loop->approach.si();
  if (contact.least && contact.least->stiffness_N_m > 0) {
    speed_m_s = std::max(speed_m_s, frame.order.rate_N_s / contact.least->stiffness_N_m);
  }
  return kUnderWay_s * speed_m_s + stopping_way_m(frame.caps, speed_m_s);
}

void RigState::start_pressing(MonoTime at) {
  Course::Pressed& p = course.pressed;
  const bool is_clear = contact.least && course.last_travel_m &&
                        is_clear_of_contact(*this, at, *course.last_travel_m);
  p.zero_N = is_clear ? frame.order.force_N : frame.order.zero_N;
  p.start_N = frame.order.force_N - p.zero_N;
  p.start = p.last = at;
  p.too_small = 0;
  p.crept_m = 0;
  p.beyond_N.reset();
  p.best_N.reset();
  if (contact.least) set_base(p, *contact.least, course.last_travel_m, p.start_N);
}

// Called at the end of a motion: its force may be shown later.
void RigState::end_motion(MonoTime at) {
  const MonoTime until = at + shown_after(facts.frame);
  if (frame.motion == FrameMotion::moving && frame.order.direction < 0) course.falls_until = until;
  const auto worst_N = std::exchange(frame.order.worst_N, std::nullopt);
  if (!worst_N) return;
  course.follows_to_N = *worst_N;
  course.follows_until = until;
}

void RigState::stand(MonoTime at, std::optional<double> travel_m) {
  if (!is_watched()) return;
  end_motion(at);
  // The reported place is compared with the next samples, even if a new order has come by then.
  if (travel_m || frame.motion != FrameMotion::standing) frame.reported_m = travel_m;
  frame.motion = FrameMotion::standing;
  frame.since = at;
  frame.stands_from.reset();
  course.stood_m.reset();
  course.moving_flags = 0;
  course.recent.clear();
  course.stood_first.reset();
  course.stood_last.reset();
  course.noise_N2 = 0;
}

// The last sample may still belong to the motion, so the report of its end counts like one.
void RigState::take_standstill(const WatchInputEvent& e, MonoTime at) {
  frame.end_force_N = e.force_N;
  if (e.travel_m) frame.seen.travel_m = e.travel_m;
  if (!e.force_N) return;
  frame.force_N = e.force_N;
  frame.force_at = at;
  course.is_force_known = true;
  if (phase != RunPhase::finally) course.peak_force_N = std::max(course.peak_force_N, *e.force_N);
}

// Returns whether there are new tolerances. If a cell that was alive shows a single value, it may
// just have frozen, and nothing is learned from it.
bool RigState::learn_zero(const RestMeasurement& rest, bool is_unloaded) {
  if (is_watched() && cell.noise.alive && !rest.is_alive()) return false;
  cell.zero = rest;
  if (is_unloaded) {
    cell.unloaded = rest;
    cell.zeros_under_load_N = 0;
    cell.untouched_N.reset();
  }
  if (!is_watched()) return false;
  if (rest.drifts()) {
    cell.drift_N_s = std::abs(rest.drift_N_s()) + kBoundSigmas * rest.drift_error_N_s();
  }
  return learn_noise(rest);
}

bool RigState::learn_noise(const RestMeasurement& rest) {
  if (!is_watched()) return false;
  cell.noise.add(rest, tolerances.frozen_samples);
  const Tolerances before = tolerances;
  tolerances = tolerances_of(facts.frame, forecast->bound(), facts.limits.force_max_N,
                             facts.rate_Hz, &cell.noise, cell.noise.noise_N);
  // The noise is a new estimate each time, but an earlier promise to notice a frozen cell is kept.
  if (before.frozen_samples &&
      tolerances.frozen_samples.value_or(INT64_MAX) > *before.frozen_samples) {
    tolerances.frozen_samples = before.frozen_samples;
    tolerances.frozen_force_s = before.frozen_force_s;
  }
  return true;
}

// From now on every force that the cell can show is allowed, but no motion except a retreat.
void RigState::invalidate_force() {
  trust.force = false;
  cell.below_zero_N = 0;
  limits.force_max_N = facts.frame.force_max.si();
  limits.force_min_N = -limits.force_max_N;
}

void RigState::zero_force(MonoTime at, const WatchInputEvent& e) {
  frame.seen.zeroed = true;
  if (e.force_N) cell.zeros_N = cell.zeros_N.value_or(0) + *e.force_N;
  course.follows_until = MonoTime();
  course.recent.clear();
  frame.zeroed_at = at;
}

// This travel becomes 0, and the contact has to be found again.
void RigState::zero_travel(double travel_m, MonoTime at) {
  contact.travel_m.reset();
  if (contact.least) contact.least->zero_travel(travel_m);  // the specimen is where it was
  limits.zero_travel(travel_m);
  frame.caps = with_zero_at(frame.caps, travel_m);
  frame.zero_m += travel_m;
  ++frame.travel_zeros;
  frame.stands_from = at + old_samples(facts.rate_Hz);
  if (course.retreat_from_m) *course.retreat_from_m -= travel_m;
  course.old_zero_m = travel_m;
}

void RigState::place_contact(double travel_m, double force_N) {
  contact.least.reset();  // unknown until its stiffness is measured
  contact.travel_m = travel_m;
  contact.force_N = force_N;
  contact.depth_m = 0;
  limits.place_contact(travel_m);
}

// Once a prediction was exceeded, nothing is pressed any more.
void RigState::trust_pressing(const std::optional<ForceComparison>& compared) {
  if (!compared || !compared->exceeded) return;
  trust.no_pressing = fmt::format(
      "the force went to {:.4f} N where at most {:.4f} N was predicted: specimen or frame are not "
      "what they were said to be, and nothing is pressed any more",
      compared->observed_N, compared->predicted_N);
}

std::optional<std::string> RigState::broken_invariant() const {
  if (!trust.force && limits.force_max_N < facts.frame.force_max.si()) {
    return "the force is invalid, and limits it all the same";
  }
  if (contact.least && !(contact.least->stiffness_N_m > 0)) return "a contact without a stiffness";
  if (frame.motion == FrameMotion::moving && !is_watched()) {
    return "a frame moves that this run does not move";
  }
  if (limits.travel_min_m && *limits.travel_min_m > *limits.travel_max_m) {
    return "the limits of the travel contradict each other";
  }
  if (cell.below_zero_N < 0 || cell.hidden_N < 0) return "a zero raises a limit of the force";
  return std::nullopt;
}

}  // namespace lcrig
