// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_clerk.hpp"

#include <algorithm>
#include <utility>

namespace lcrig::frame_link {

namespace {

constexpr Duration kPretence = std::chrono::milliseconds(500);  // before a false DONE

}  // namespace

void SimClerk::set_lies(MonoTime t, const ZwickSimLies& lies) {
  const bool from_now = lies.done_early && !lies_.done_early;
  lies_ = lies;
  if (from_now && latest_ && machine_.is_moving()) claim_.emplace(Claim{t, *latest_, true});
}

Verdict SimClerk::take(MonoTime t, Order order) {
  const bool is_possible = machine_.is_armed() && !machine_.is_moving() && !lies_.estop;
  if (is_possible && lies_.order_late_s > 0) {
    waiting_.push_back({t + from_seconds(lies_.order_late_s), std::move(order)});
    return std::nullopt;
  }
  if (is_possible && lies_.done_unmoved) {
    claim_.emplace(Claim{t + kPretence, std::move(order), false});
    return std::nullopt;
  }
  if (auto no = order.carry_out(t)) return no;
  const MonoTime end = machine_.next_event().value_or(t);
  if (lies_.done_early) claim_.emplace(Claim{t + (end - t) / 2, order, true});
  latest_ = std::move(order);
  return std::nullopt;
}

void SimClerk::stop(MonoTime t) {
  for (Waiting& w : waiting_) {
    if (std::exchange(w.is_wanted, false)) tell(w.order.number, t, MotionEnd::stopped);
  }
  if (claim_ && !claim_->moves) tell(claim_->order.number, t, MotionEnd::stopped);
  claim_.reset();
  for (Told& l : late_) finished_.push_back(std::move(l.motion));
  late_.clear();
}

void SimClerk::end_session() {
  for (Waiting& w : waiting_) w.is_wanted = false;
  claim_.reset();
  late_.clear();
  finished_.clear();
}

std::optional<MonoTime> SimClerk::next_event() const {
  auto due = machine_.next_event();
  const auto consider = [&due](MonoTime t) { due = std::min(due.value_or(t), t); };
  if (claim_) consider(claim_->due);
  if (!waiting_.empty()) consider(waiting_.front().due);
  if (!late_.empty()) consider(late_.front().due);
  return due;
}

void SimClerk::advance() {
  const MonoTime t = next_event().value();
  if (machine_.next_event() == t) {
    machine_.advance();
    return hear_machine(t);
  }
  if (claim_ && claim_->due == t) return claim(t);
  if (!waiting_.empty() && waiting_.front().due == t) return obey_late(t);
  finished_.push_back(std::move(late_.front().motion));
  late_.pop_front();
}

void SimClerk::hear_machine(MonoTime t) {
  auto ended = machine_.take_finished();
  if (!ended) return;
  claim_.reset();
  latest_.reset();
  const bool is_late = lies_.done_late_s > 0 && ended->outcome.reason == MotionEnd::target;
  if (is_late && ended->number) {
    late_.push_back({t + from_seconds(lies_.done_late_s), std::move(*ended)});
  } else {
    finished_.push_back(std::move(*ended));
  }
}

// Claims that the target was reached, and reports the target's values as measured.
void SimClerk::claim(MonoTime t) {
  const Claim said = *std::exchange(claim_, std::nullopt);
  if (said.moves && !machine_.is_moving()) return;
  if (said.moves) machine_.disown();
  tell(said.order.number, t, MotionEnd::target);
  MotionOutcome& outcome = finished_.back().outcome;
  if (said.order.travel_m) outcome.travel_m = said.order.travel_m;
  if (said.order.force_N) outcome.force_N = said.order.force_N;
}

void SimClerk::obey_late(MonoTime t) {
  Waiting w = std::move(waiting_.front());
  waiting_.pop_front();
  if (!machine_.is_armed()) return;
  const bool refused = w.order.carry_out(t).has_value();
  if (!w.is_wanted) {
    if (!refused) machine_.drop_number();
  } else if (refused) {
    tell(w.order.number, t, MotionEnd::fault);
  }
}

void SimClerk::tell(std::int64_t number, MonoTime t, MotionEnd reason) {
  const FrameSample now = machine_.sample(t);
  FinishedMotion& f = finished_.emplace_back();
  f.number = number;
  f.outcome.reason = reason;
  f.outcome.force_N = now.force_N;
  f.outcome.travel_m = now.travel_m;
}

std::optional<FinishedMotion> SimClerk::take_finished() {
  if (finished_.empty()) return std::nullopt;
  FinishedMotion first = std::move(finished_.front());
  finished_.pop_front();
  return first;
}

}  // namespace lcrig::frame_link
