// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/corridor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig {

namespace {

// Where a motion is judged, beyond its zero.
struct Depth {
  const RigState& rig;
  const Course::Pressed& pressed;
  const Contact::Least& contact;
  MonoTime t;
  double travel_m;

  // The part of the initial force that may have relaxed by now.
  double relaxed_N() const {
    const double most_N = kRelaxes * std::max(0.0, pressed.start_N);
    if (!pressed.relaxes_N_s) return most_N;
    return std::min(kSooner * *pressed.relaxes_N_s * to_seconds(t - pressed.start), most_N);
  }
  double from_m() const {
    const double thermal_m = pressed.is_loaded ? 0 : kThermal_m_s * to_seconds(t - contact.since);
    return pressed.base_m + thermal_m + rig.travel_tolerance_m();
  }
  // The range of force that is left in which the contact is as stiff as measured.
  double near_N() const {
    return std::max(0.0, kNearForces * contact.force_N -
                             contact.stiffness_N_m * (pressed.base_m - contact.travel_m));
  }
  bool is_in() const { return travel_m > from_m(); }
  double drift_N() const { return rig.frame.order.drift_N_s * to_seconds(t - rig.frame.since); }
};

Edge with_tolerance(Edge edge, const Depth& at) {
  return edge.add("noise", -at.rig.tolerances.order_force_N)
      .add("force loop", -at.rig.frame.order.loop_N)
      .add("drift", -at.drift_N());
}

// Since the start: the force there, and the least rise on the way into the contact.
Edge least_rise(const Depth& at) {
  const double elastic_N = at.contact.stiffness_N_m * (at.travel_m - at.from_m());
  const double near_N = std::min(elastic_N, at.near_N());
  Edge edge("contact");
  edge.add("zero of the cell", at.pressed.zero_N)
      .add("force at the start", at.pressed.base_N)
      .add("relaxation", -at.relaxed_N())
      .add("least stiffness, near", kStiffNear * near_N)
      .add("least stiffness, far", kStiffFar * (elastic_N - near_N));
  return with_tolerance(edge, at);
}

// Since the largest force of this motion. A specimen that is pressed ever deeper loses at most the
// force with which the motion started.
std::optional<Edge> least_since_best(const Depth& at) {
  const Course::Pressed& p = at.pressed;
  if (!p.best_N) return std::nullopt;
  const double way_m = kBrakes * at.rig.frame.order.speed_m_s * to_seconds(p.last - p.best_at);
  if (at.travel_m - p.best_m < way_m) return std::nullopt;  // it brakes, while the force relaxes
  Edge edge("contact, since the largest force");
  edge.add("zero of the cell", p.zero_N)
      .add("largest force, less its rise", *p.best_N)
      .add("least stiffness, far", kStiffFar * at.contact.stiffness_N_m * (at.travel_m - p.crept_m))
      .add("relaxation", -at.relaxed_N());
  return with_tolerance(edge, at);
}

void take_higher(std::optional<Edge>& edge, const std::optional<Edge>& other) {
  if (other && (!edge || other->value() > edge->value())) edge = other;
}

double against_N(const RigState& rig, MonoTime t) {
  const Order& order = rig.frame.order;
  return order.against_N + order.drift_N_s * to_seconds(t - rig.frame.since);
}

}  // namespace

void set_base(Course::Pressed& p, const Contact::Least& contact, std::optional<double> travel_m,
              double start_N) {
  p.is_loaded = travel_m && *travel_m >= contact.deepest_m - kPlace_m;
  p.base_m = p.is_loaded ? std::max(*travel_m, contact.deepest_m) : contact.deepest_m;
  p.base_N = p.is_loaded ? start_N : kReturns * contact.deepest_N;
}

// A servo may overshoot its end and come back.
std::optional<Edge> edge_behind(const RigState& rig) {
  const Order& order = rig.frame.order;
  if (order.direction == 0 || !rig.course.furthest_m) return std::nullopt;
  double furthest_m = *rig.course.furthest_m;  // in its direction
  if (order.target_m) furthest_m = std::min(furthest_m, order.direction * *order.target_m);
  const double allowed_m = std::max(rig.tolerances.against_m, kTravelSteps * rig.travel_step_m());
  return Edge("against the order")
      .add("furthest", order.direction * furthest_m)
      .add("hunting, noise, step", -order.direction * allowed_m)
      .add("force loop before", -order.direction * rig.course.runs_on_m);
}

std::optional<Edge> edge_ahead(const RigState& rig, MonoTime t) {
  const Order& order = rig.frame.order;
  if (order.direction == 0 || !rig.course.from_m) return std::nullopt;
  const double seconds = to_seconds(t - rig.frame.since) + kUnderWay_s;
  const double tolerance_m = rig.tolerances.order_travel_m + kTravelSteps * rig.travel_step_m();
  return Edge("ahead of the order")
      .add("where it stood", *rig.course.from_m)
      .add("ordered way", order.direction * kSpeedAllowance * order.speed_m_s * seconds)
      .add("tolerance", order.direction * tolerance_m);
}

Corridor travel_corridor(const RigState& rig, MonoTime t) {
  Corridor out;
  if (rig.frame.motion == FrameMotion::standing && rig.course.stood_m) {
    const double stood_m = *rig.course.stood_m;
    out.lower = Edge("stands").add("where it stood", stood_m).add("tolerance", -rig.standing_m());
    out.upper = Edge("stands").add("where it stood", stood_m).add("tolerance", rig.standing_m());
  } else if (rig.frame.motion == FrameMotion::moving) {
    out.lower = edge_behind(rig);
    out.upper = edge_ahead(rig, t);
    if (rig.frame.order.direction < 0) std::swap(out.lower, out.upper);
  }
  return out;
}

std::optional<Edge> edge_from_start(const RigState& rig, MonoTime t) {
  if (!rig.trust.force || !(rig.frame.order.direction > 0)) return std::nullopt;
  return Edge("start")
      .add("force at the start", rig.frame.order.force_N)
      .add("noise, relaxation, zero, drift", -against_N(rig, t));
}

std::optional<Edge> edge_from_peak(const RigState& rig, MonoTime t) {
  const Course& course = rig.course;
  if (!rig.trust.force || !(rig.frame.order.direction > 0) || !course.peak_N) return std::nullopt;
  return Edge("largest force")
      .add("largest force", *course.peak_N)
      .add("noise, relaxation, zero, drift", -against_N(rig, t))
      .add("fall", -kFalls * std::abs(*course.peak_N - rig.frame.order.zero_N));
}

std::optional<Edge> edge_in_contact(const RigState& rig, MonoTime t, double travel_m) {
  if (!rig.trust.force || !rig.contact.least || rig.frame.order.direction < 0) return std::nullopt;
  const Depth at{rig, rig.course.pressed, *rig.contact.least, t, travel_m};
  std::optional<Edge> edge = least_since_best(at);
  if (at.is_in()) take_higher(edge, least_rise(at));
  return edge;
}

bool is_in_contact(const RigState& rig, MonoTime t, double travel_m) {
  return rig.contact.least &&
         Depth{rig, rig.course.pressed, *rig.contact.least, t, travel_m}.is_in();
}

bool is_clear_of_contact(const RigState& rig, MonoTime t, double travel_m) {
  const Contact::Least& c = *rig.contact.least;
  const double thermal_m = kThermal_m_s * to_seconds(t - c.since);
  return travel_m < c.travel_m - rig.contact.depth_m - kStanding_m - thermal_m;
}

std::optional<Edge> edge_of_retreat(const RigState& rig, MonoTime t) {
  const Order& order = rig.frame.order;
  if (!rig.trust.force || !(order.direction < 0)) return std::nullopt;
  // A specimen that sticks pulls until it lets go; after that the cell shows its zero.
  const double free_N = order.free_N.value_or(order.zero_N);
  return Edge("retreat")
      .add("force at the start", std::max({order.force_N, order.zero_N, free_N}))
      .add("noise, recovery, zero, drift", against_N(rig, t));
}

Corridor force_corridor(const RigState& rig, MonoTime t, std::optional<double> travel_m) {
  Corridor out;
  if (rig.frame.motion != FrameMotion::moving) return out;
  out.lower = edge_from_start(rig, t);
  take_higher(out.lower, edge_from_peak(rig, t));
  if (travel_m) take_higher(out.lower, edge_in_contact(rig, t, *travel_m));
  out.upper = edge_of_retreat(rig, t);
  if (rig.frame.order.worst_N) {
    const double worst_N = *rig.frame.order.worst_N;
    out.upper = Edge("prediction")
                    .add("predicted", worst_N)
                    .add("class of the cell", rig.facts.frame.cell().part() * worst_N)
                    .add("noise", kSampleSigmas * rig.cell.noise_bound_N());
  }
  return out;
}

std::optional<double> furthest_m(const RigState& rig, MonoTime now, double force_N) {
  if (!rig.is_watched() || !rig.contact.least) return std::nullopt;
  const Contact::Least& contact = *rig.contact.least;
  Course::Pressed next;
  next.start = now;
  next.start_N = contact.deepest_N;
  set_base(next, contact, rig.course.last_travel_m, next.start_N);
  const Depth at{rig, next, contact, now, 0};
  const double k = contact.stiffness_N_m, near_N = at.near_N();
  const double lost_N = next.is_loaded ? kRelaxes * std::max(0.0, next.base_N) : 0;
  const double felt_N = force_N - rig.cell.zero_N() + rig.tolerances.order_force_N;
  const double rise_N = std::max(0.0, felt_N + lost_N - next.base_N);
  const double by_near_N = std::min(rise_N, kStiffNear * near_N);
  return at.from_m() + by_near_N / kStiffNear / k + (rise_N - by_near_N) / kStiffFar / k;
}

}  // namespace lcrig
