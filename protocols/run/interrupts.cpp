// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/interrupts.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "base/as_result.hpp"
#include "base/either.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLagLasts = 1s;  // until everything that waited here has been read

bool is_stop(const InterruptRequest& request) {
  return request.kind != Interrupt::pause;
}

}  // namespace

EventKind event_of(Interrupt i) {
  switch (i) {
    case Interrupt::pause: return EventKind::pause;
    case Interrupt::abort: return EventKind::abort;
    case Interrupt::freeze: return EventKind::freeze;
    case Interrupt::limit: return EventKind::limit;
    case Interrupt::fault: return EventKind::fault;
    case Interrupt::loss: return EventKind::loss;
    case Interrupt::stop_after: return EventKind::stop_after;
  }
  return EventKind::fault;
}

InterruptRequest::InterruptRequest(Interrupt k, std::string w)
    : kind(k),
      code(k == Interrupt::limit ? Errc::limit_tripped : Errc::aborted),
      why(std::move(w)) {}

InterruptRequest request_for(const Error& error) {
  switch (error.code) {
    case Errc::limit_tripped: return InterruptRequest(Interrupt::limit, error);
    case Errc::aborted: return InterruptRequest(Interrupt::abort, error);
    default: return InterruptRequest(Interrupt::fault, error);
  }
}

InterruptQueue::InterruptQueue(asio::any_io_executor executor, Clock& clock, const EventLog& log,
                               std::function<void()> look)
    : clock_(clock), log_(log), look_(std::move(look)), wake_(executor, 1), resumes_(executor, 1) {}

InterruptQueue::Taken InterruptQueue::ask(InterruptRequest request) {
  if (over_) return Taken::over;
  const bool stops = is_stop(request);
  // A second abort must not end `finally`, because it unloads the specimen.
  const bool asks = request.kind == Interrupt::pause || request.kind == Interrupt::abort;
  if (finishing_ && asks) return frozen_ ? Taken::acts : Taken::finally_goes_on;
  if (stops && request.kind != Interrupt::freeze && stop_pending_) return Taken::acts;
  stop_pending_ = stop_pending_ || stops;
  frozen_ = frozen_ || request.kind == Interrupt::freeze;
  // The event of a limit contains the sample and was written with it.
  if (request.kind != Interrupt::limit) log_.event(event_of(request.kind), request.why);
  push(std::move(request));
  return Taken::acts;
}

void InterruptQueue::push(InterruptRequest request) {
  const auto same = [&](const InterruptRequest& other) { return other.kind == request.kind; };
  if (std::ranges::none_of(pending_, same)) pending_.push_back(std::move(request));
  wake_.try_send(boost::system::error_code());
}

InterruptRequest InterruptQueue::take() {
  InterruptRequest request = std::move(pending_.front());
  pending_.pop_front();
  return request;
}

InterruptRequest InterruptQueue::take_stop() {
  const auto first = std::ranges::find_if(pending_, is_stop);
  if (first != pending_.end()) std::rotate(pending_.begin(), first, std::next(first));
  return take();
}

Task<> InterruptQueue::wait(MonoTime until) {
  const auto over = [](std::optional<MonoTime>* due) { due->reset(); };
  const std::unique_ptr<std::optional<MonoTime>, decltype(over)> guard(&due_, over);
  while (pending_.empty() && clock_.now() < until) {
    ++ticks_;
    due_ = std::min(until, clock_.now() + kTick);
    auto r = co_await either(wake_.async_receive(kAsResult), clock_.wait_until(*due_));
    note_lag();
    if (r.index() == 1) look_();
  }
}

void InterruptQueue::note_lag() {
  const MonoTime now = clock_.now();
  const Duration late = std::max(Duration::zero(), now - due_.value_or(now));
  if (late < lag_ && now - lagged_ < kLagLasts) return;
  lag_ = late;
  lagged_ = now;
}

std::optional<Duration> InterruptQueue::own_lag(MonoTime now) const {
  if (!due_) return std::nullopt;
  const Duration before = now - lagged_ < kLagLasts ? lag_ : Duration::zero();
  return std::max({Duration::zero(), now - *due_, before});
}

Task<> InterruptQueue::wait_for_stop() {
  while (std::ranges::none_of(pending_, is_stop)) {
    auto woken = co_await wake_.async_receive(kAsResult);
    static_cast<void>(woken);
  }
}

Task<> InterruptQueue::resumed() {
  auto r = co_await resumes_.async_receive(kAsResult);
  static_cast<void>(r);
}

std::optional<InterruptRequest> InterruptQueue::begin_finish(std::optional<InterruptRequest> stop) {
  finishing_ = true;
  stop_pending_ = false;
  // A freeze outranks a stop that is already pending: the person wants the frame to stay where it
  // is.
  for (InterruptRequest& late : pending_) {
    const bool stops = is_stop(late) && late.kind != Interrupt::loss;
    const bool planned = !stop || stop->kind == Interrupt::stop_after;
    if (late.kind == Interrupt::freeze || (stops && planned)) stop = std::move(late);
  }
  pending_.clear();
  return stop;
}

}  // namespace lcrig
