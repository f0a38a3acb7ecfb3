// SPDX-License-Identifier: Apache-2.0
#include "protocols/contact/contact_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/contact/contact_slope.hpp"
#include "protocols/rig/permit.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

Task<Result<>> ContactProbe::step_back(double touched_m) {
  auto looked = co_await look_at_contact();
  if (!looked) co_return looked;
  const RestMeasurement at_contact = looks_.front();
  const double pressed_N = left_N(looks_.front());
  const FrameCapabilities caps = run_.rig.frame.caps;
  const double speed = std::clamp(kStepSpeed_m_s.value, caps.speed_min.si(), caps.speed_max.si());
  const double end_m = device_limits(run_.rig.limits, caps).travel_min.si();
  const double least_m =
      std::max(kFirstStep_m.value, kBoundSigmas * looks_.front().travel_scatter_m());
  // A step back that is shorter than the step of the travel may lead deeper into the specimen.
  double now_N = pressed_N, step_m = std::max(least_m, run_.rig.travel_step_at_most_m());
  first_step_m_ = step_m;
  while (step_m < kFarthest_m && std::abs(now_N) > kEnough * std::abs(pressed_N) &&
         touched_m - step_m > end_m) {
    auto moved = co_await run_.motions.to_travel(touched_m - step_m, speed, 60 + step_m / speed);
    if (!moved) co_return moved;
    co_await run_.setup.clock.wait_for(kBatch_s.duration());
    auto now = co_await run_.meter.measure(kLook_s.duration());
    if (!now) co_return fail(now.error());
    now_N = left_N(*now);
    looks_.push_back(*now);
    // A contact never presses harder on the way back, so this is no contact.
    const double most_N = kMore * std::abs(pressed_N);
    if (std::abs(now_N) > most_N + kNoiseSigmas * now->error_N()) {
      if (now_N > pressed_N) rise_.emplace(at_contact, *now);
      break;
    }
    step_m *= 2;
  }
  co_return Result<>();
}

// While the filter of a slow cell still follows the search, the force shown may rise on a way back.
Task<> ContactProbe::let_follow() const {
  const Duration rest =
      shown_after(run_.setup.frame.capabilities()) - kBatch_s.duration() - kLook_s.duration();
  if (rest > Duration::zero()) co_await run_.setup.clock.wait_for(rest);
}

// Looks twice, and on until the specimen has relaxed. How fast the force falls at constant travel
// tells it from a fall on the way back.
Task<Result<>> ContactProbe::look_at_contact() {
  co_await run_.setup.clock.wait_for(kBatch_s.duration());
  auto first = co_await run_.meter.measure(kLook_s.duration());
  if (!first) co_return fail(first.error());
  touched_ = *first;
  co_await let_follow();
  std::vector<RestMeasurement> looks(1, *first);
  for (bool relaxed = false; !relaxed && std::ssize(looks) < kMostLooks.count();) {
    auto now = co_await run_.meter.measure(kLook_s.duration());
    if (!now) co_return fail(now.error());
    for (const RestMeasurement& before : looks) {
      relaxes_N_s_ = std::min(relaxes_N_s_, fastest_fall_N_s(before, *now));
    }
    const double fallen_N = std::abs(left_N(looks.back())) - std::abs(left_N(*now));
    const double error_N = kBoundSigmas * std::hypot(looks.back().error_N(), now->error_N());
    const double felt_N = std::abs(this->felt_N());
    relaxed = fallen_N < std::max(error_N, kRelaxed * felt_N) && relaxes_N_s_ < kSlow_s * felt_N;
    looks.push_back(*now);
  }
  looks_.assign(1, looks.back());
  co_return Result<>();
}

bool ContactProbe::is_contact() const {
  if (std::abs(felt_N()) < kLeastFelt * rise_N_) return false;
  const RestMeasurement& touched = looks_.front();
  const RestMeasurement& last = looks_.back();
  const double fallen_N = std::copysign(1, felt_N()) * (touched.force_N() - last.force_N());
  const double doubt_N = 2 * kBoundSigmas * std::hypot(touched.error_N(), last.error_N());
  return fallen_N > std::max(doubt_N, kGone * std::min(std::abs(felt_N()), rise_N_));
}

// What the cell drifts at rest goes on at rest.
double ContactProbe::rose_beyond_N(const RestMeasurement& after) const {
  if (!rise_) return 0;
  const auto& [from, to] = *rise_;
  const double drift_N_s =
      std::max(0.0, after.drift_N_s()) + kBoundSigmas * after.drift_error_N_s();
  const double doubt_N = kNoiseSigmas * std::hypot(from.error_N(), to.error_N());
  const double rise_N = to.force_N() - from.force_N();
  return rise_N - kDriftChanges * drift_N_s * seconds_between(from, to) - doubt_N;
}

std::string ContactProbe::why_rose() const {
  return fmt::format("{:.4f} N after {:.4f} N", rise_->second.force_N(), rise_->first.force_N());
}

Result<> ContactProbe::check_felt(double felt_N) const {
  if (felt_N >= 0) return {};
  const std::string& step = run_.log.step_id();
  double least_N = looks_.front().scatter_N();
  for (const RestMeasurement& look : looks_) least_N = std::min(least_N, look.scatter_N());
  const double wavers_N = kNoiseSigmas * std::max(before_.scatter_N(), least_N);
  if (-felt_N < wavers_N) {
    return fail(Errc::refused,
                "step {}: where the probe touches the force wavers by {:.3g} N (standard "
                "deviation), more than contact at {:.3g} N tells: does the frame hunt?",
                step, least_N, rise_N_);
  }
  const std::string why = fmt::format(
      "the force falls where the probe presses ({:.4f} N, {:.4f} N at rest), and rises on the "
      "way back: the load cell is connected the wrong way",
      before_.force_N() + felt_N, before_.force_N());
  run_.response.act(Doubt::force, Response::stop_and_retreat, why);
  return fail(Errc::refused, "step {}: {}", step, why);
}

const RestMeasurement& ContactProbe::off_contact(const RestMeasurement& after) const {
  const RestMeasurement& farthest = looks_.back();
  const double doubt_N = kBoundSigmas * std::hypot(after.error_N(), farthest.error_N());
  const bool is_nearer =
      after.travel_m() && farthest.travel_m() && *after.travel_m() > *farthest.travel_m();
  return is_nearer && after.force_N() - farthest.force_N() > doubt_N ? farthest : after;
}

double ContactProbe::depth_m() const {
  const RestMeasurement& farthest = looks_.back();
  const double pressed_N = left_N(looks_.front());
  const double fallen_N = pressed_N - std::max(0.0, left_N(farthest));
  if (!touched_->travel_m() || !farthest.travel_m() || !(fallen_N > 0)) return 0;
  const double way_m = *touched_->travel_m() - *farthest.travel_m();
  return kTail * way_m * pressed_N / fallen_N;
}

bool ContactProbe::presses(const RestMeasurement& look) const {
  if (!touched_->travel_m() || !look.travel_m()) return false;
  const double error_N = kBoundSigmas * std::hypot(before_.error_N(), look.error_N());
  return *touched_->travel_m() - *look.travel_m() < depth_m() &&
         left_N(look) > 2 * error_N + run_.rig.zero_uncertainty_N();
}

// Counts the looks in which contact certainly remained, because a step that lost contact would make
// it seem softer than it is. The force must exceed what the cell shows without contact, before and
// afterwards, because its zero may have drifted meanwhile.
std::size_t ContactProbe::touching(const RestMeasurement& after) const {
  const double none_N = std::max(before_.force_N(), after.force_N());
  const auto lost = std::find_if(looks_.begin() + 1, looks_.end(), [&](const RestMeasurement& now) {
    const double noise_N = kBoundSigmas * std::hypot(before_.error_N(), now.error_N());
    return now.force_N() - none_N < std::max(2 * noise_N, kLeft * left_N(looks_.front()));
  });
  return static_cast<std::size_t>(lost - looks_.begin());
}

// In a few words.
std::string ContactProbe::why_not_measured(std::size_t touching, bool overran) const {
  if (overran) return "the search overran it by more than its stiffness explains";
  const auto from_m = looks_.front().travel_m();
  const auto to_m = looks_.size() > 1 ? looks_[1].travel_m() : std::nullopt;
  if (touching < 2 && from_m && to_m) {
    return fmt::format("the first step back, {:.3g} um, left it", (*from_m - *to_m) * 1e6);
  }
  return "noise, play or relaxation hide how the force falls on the way back";
}

void ContactProbe::conclude_stiffness(const RestMeasurement& after, double speed_m_s) const {
  const double passed_s = seconds_between(before_, after);
  const double drift_N_s =
      passed_s > 0 ? std::abs(after.force_N() - before_.force_N()) / passed_s : 0;
  const double left_N = this->left_N(looks_.front());
  const std::size_t touching = this->touching(after);
  const RetreatFacts course{left_N, drift_N_s, relaxes_N_s_, first_step_m_};
  auto slope = contact_slope(looks_, touching, course);
  // What relaxes since the probe came in is missing in the slope, and a quick motion feels it.
  if (slope) slope->at_most *= std::max(1.0, felt_N() / left_N);
  // The rise of the force while the frame stopped must fit the slope, too.
  const bool overran = slope && !explains(run_.rig, felt_N(), slope->at_most, rise_N_, speed_m_s);
  if (overran) slope.reset();
  StiffnessEvent measured;
  measured.force_N = touched_N();
  if (slope) {
    measured.stiffness_N_m = slope->about;
    measured.at_most_N_m = slope->at_most;
    measured.at_least_N_m = slope->at_least;
    run_.watch.know_largest_stiffness(felt_N(), slope->at_most);
  } else {
    run_.watch.not_measured(why_not_measured(touching, overran));
  }
  run_.event(measured);
  // A cell that lies shows itself by this, so it is needed where no slope is known, too.
  const double least_N_m = slope ? slope->at_least : proven_stiffness_N_m(looks_, course);
  if (touched_->travel_m() && least_N_m > 0) {
    run_.watch.know_least_stiffness(*touched_->travel_m(), felt_N(), least_N_m);
  }
}

}  // namespace lcrig
