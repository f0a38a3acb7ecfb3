// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/driver.hpp"

#include <cmath>
#include <initializer_list>

#include "base/clock.hpp"
#include "drivers/zwick/codec.hpp"
#include "drivers/zwick/link.hpp"

namespace lcrig {

namespace {

using frame_link::Link;

constexpr Duration kAnswerTime = std::chrono::seconds(1);
constexpr Duration kStopTime = std::chrono::seconds(1);  // in addition to the time of deceleration
constexpr Duration kStopTimeMax = std::chrono::seconds(30);
constexpr Duration kHelloTime = std::chrono::seconds(1);  // per attempt

Result<> check_finite(const Link& link, std::initializer_list<double> values) {
  for (const double v : values) {
    if (!std::isfinite(v)) {
      return fail(Errc::invalid_request, "{}: a command with a value that is not finite",
                  link.name());
    }
  }
  return {};
}

// Sends `line` and waits for OK or ERR.
Task<Result<>> answer_to(Link::Exchange& exchange, std::string line) {
  Link& link = exchange.waiting.link();
  if (link.lost()) co_return fail(*link.lost());
  if (!link.is_greeted()) co_return fail(Errc::disconnected, "{}: not identified yet", link.name());
  if (link.is_observer()) {
    co_return fail(Errc::bug, "{}: a command in an observer session", link.name());
  }
  link.send(line);
  const MonoTime deadline = link.clock().now() + kAnswerTime;
  while (!exchange.answer) {
    if (link.clock().now() >= deadline) {
      line.pop_back();
      co_return fail(Errc::no_reply, "{}: {} -> no answer in 1 s", link.name(), line);
    }
    auto waited = co_await exchange.waiting.next(deadline);
    if (!waited) co_return fail(waited.error());
  }
  co_return *exchange.answer;
}

Task<Result<MotionOutcome>> done_of(Link::Exchange& exchange) {
  while (!exchange.done) {
    auto waited = co_await exchange.waiting.next(std::nullopt);
    if (!waited) co_return fail(waited.error());
  }
  co_return *exchange.done;
}

// `make_line` gets the command number.
template <class MakeLine>
Task<Result<>> command(std::shared_ptr<Link> link, MakeLine make_line) {
  Link::Exchange exchange(link);
  std::string line = make_line(exchange.number);
  co_return co_await answer_to(exchange, std::move(line));
}

template <class MakeLine>
Task<Result<MotionOutcome>> motion(std::shared_ptr<Link> link, MakeLine make_line) {
  Link::Exchange exchange(link);
  std::string line = make_line(exchange.number);
  auto answer = co_await answer_to(exchange, std::move(line));
  if (!answer) {
    // The motion may have started, or may still start.
    if (answer.error().code == Errc::no_reply) link->send_stop();
    co_return fail(answer.error());
  }
  co_return co_await done_of(exchange);
}

// Asks for a session, then waits for the gateway's HELLO and CAPS or for the deadline.
Task<Result<>> greeting(Link::Waiting& waiting, std::optional<double> observe_Hz) {
  Link& link = waiting.link();
  const MonoTime deadline = link.clock().now() + kHelloTime;
  if (observe_Hz) {
    link.send_observe(*observe_Hz);
  } else {
    link.send_hello();
  }
  while (!link.is_greeted() && link.clock().now() < deadline) {
    auto waited = co_await waiting.next(deadline);
    if (!waited) co_return fail(waited.error());
    if (link.hello() && link.hello()->protocol != frame_link::kProtocol) co_return Result<>();
  }
  co_return Result<>();
}

Result<Identity> identity_of(const Link& link) {
  if (link.hello() && link.hello()->protocol != frame_link::kProtocol) {
    return fail(Errc::refused, "{}: the gateway speaks frame-link/{}, we speak frame-link/{}",
                link.name(), link.hello()->protocol, frame_link::kProtocol);
  }
  if (link.is_greeted()) {
    Identity identity = link.hello()->identity;
    identity.text = frame_link::format_hello(*link.hello());
    identity.text.pop_back();
    return identity;
  }
  if (link.last_garbage().empty() && !link.hello()) {
    return fail(Errc::no_reply, "{}: HELLO -> no answer in 2 s; is the gateway running?",
                link.name());
  }
  return fail(Errc::garbled, "{}: HELLO -> '{}' ({}); this is no frame-link/1 gateway", link.name(),
              link.last_garbage(), link.why_garbage());
}

}  // namespace

ZwickLink::ZwickLink(std::unique_ptr<Transport> transport, Clock& clock,
                     asio::any_io_executor executor)
    : link_(std::make_shared<Link>(std::move(transport), clock, std::move(executor))) {}

ZwickLink::~ZwickLink() {
  link_->set_listener(nullptr);
  link_->close();
}

void ZwickLink::close() {
  link_->close();
}

std::optional<std::string> ZwickLink::origin() const {
  return link_->origin();
}

void ZwickLink::set_listener(Listener* listener) {
  link_->set_listener(listener);
}

// Makes two attempts to open a session, either one that may command or an observer's.
Task<Result<>> ZwickLink::greet(std::optional<double> observe_Hz) {
  const auto link = link_;
  link->start();
  Link::Waiting waiting(link);
  for (int attempt = 0; attempt < 2; ++attempt) {
    auto greeted = co_await greeting(waiting, observe_Hz);
    if (!greeted) co_return greeted;
    if (link->hello() && link->hello()->protocol != frame_link::kProtocol) break;
    if (link->is_greeted()) break;
  }
  if (link->lost()) co_return fail(*link->lost());
  if (link->caps()) capabilities_ = *link->caps();
  co_return Result<>();
}

Task<Result<Identity>> ZwickLink::identify() {
  const auto link = link_;
  if (!link->is_greeted() || link->is_observer()) {
    auto greeted = co_await greet(std::nullopt);
    if (!greeted) co_return fail(greeted.error());
  }
  if (link->lost()) co_return fail(*link->lost());
  co_return identity_of(*link);
}

Task<Result<Identity>> ZwickLink::observe(double rate_Hz) {
  const auto link = link_;
  auto finite = check_finite(*link, {rate_Hz});
  if (!finite) co_return fail(finite.error());
  auto greeted = co_await greet(rate_Hz);
  if (!greeted) co_return fail(greeted.error());
  const bool other = link->hello() && link->hello()->protocol != frame_link::kProtocol;
  if (other || link->is_greeted()) co_return identity_of(*link);
  link->give_up_greeting();
  co_return fail(Errc::unsupported,
                 "{}: OBSERVE -> no answer in 2 s: no gateway is running there, or it knows only "
                 "revision 1 of frame-link/1, which has no observer sessions",
                 link->name());
}

Task<Result<>> ZwickLink::arm(FrameLimits limits) {
  auto finite =
      check_finite(*link_, {limits.force_min.si(), limits.force_max.si(), limits.travel_min.si(),
                            limits.travel_max.si(), limits.speed_max.si()});
  if (!finite) co_return fail(finite.error());
  const auto line = [limits](std::int64_t n) { return frame_link::format_limits(n, limits); };
  auto answer = co_await command(link_, line);
  if (answer) armed_speed_ = limits.speed_max;
  co_return answer;
}

Task<Result<>> ZwickLink::set_sample_rate(double rate_Hz) {
  auto finite = check_finite(*link_, {rate_Hz});
  if (!finite) co_return fail(finite.error());
  const auto line = [rate_Hz](std::int64_t n) { return frame_link::format_rate(n, rate_Hz); };
  co_return co_await command(link_, line);
}

Task<Result<MotionOutcome>> ZwickLink::move_to(Length travel, Velocity speed) {
  auto finite = check_finite(*link_, {travel.si(), speed.si()});
  if (!finite) co_return fail(finite.error());
  const auto line = [=](std::int64_t n) { return frame_link::format_move(n, travel, speed); };
  co_return co_await motion(link_, line);
}

Task<Result<MotionOutcome>> ZwickLink::move_until_force(Force force, Velocity speed, Length guard) {
  auto finite = check_finite(*link_, {force.si(), speed.si(), guard.si()});
  if (!finite) co_return fail(finite.error());
  const auto line = [=](std::int64_t n) {
    return frame_link::format_move_until(n, force, speed, guard);
  };
  co_return co_await motion(link_, line);
}

Task<Result<MotionOutcome>> ZwickLink::ramp_force(Force force, ForceRate rate) {
  auto finite = check_finite(*link_, {force.si(), rate.si()});
  if (!finite) co_return fail(finite.error());
  const auto line = [=](std::int64_t n) { return frame_link::format_ramp(n, force, rate); };
  co_return co_await motion(link_, line);
}

Task<Result<>> ZwickLink::hold_travel() {
  co_return co_await command(link_, &frame_link::format_hold_travel);
}

Task<Result<>> ZwickLink::hold_force(Force force) {
  auto finite = check_finite(*link_, {force.si()});
  if (!finite) co_return fail(finite.error());
  const auto line = [force](std::int64_t n) { return frame_link::format_hold_force(n, force); };
  co_return co_await command(link_, line);
}

Task<Result<>> ZwickLink::zero(bool force, bool travel) {
  const auto line = [=](std::int64_t n) { return frame_link::format_zero(n, force, travel); };
  co_return co_await command(link_, line);
}

Task<Result<>> ZwickLink::resync() {
  // Answers carry numbers and cannot be confused. One exchange is enough to show that the gateway
  // obeys.
  co_return co_await command(link_, &frame_link::format_status);
}

Task<Result<MotionOutcome>> ZwickLink::place_mass(Mass) {
  co_return fail(Errc::refused, "{}: a load frame carries no dead weights", link_->name());
}

// A machine that decelerates slowly needs longer before it can confirm standstill.
Duration ZwickLink::stop_time() const {
  const double a = capabilities_.deceleration.si();
  if (!(a > 0)) return kStopTime;
  const double v = armed_speed_.value_or(capabilities_.speed_max).si();
  return std::min(kStopTime + capabilities_.reaction + from_seconds(v / a), kStopTimeMax);
}

Task<Result<>> ZwickLink::stop() {
  const auto link = link_;
  link->start();
  Link::Waiting waiting(link);
  std::int64_t first = 0;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (link->lost()) co_return fail(*link->lost());
    const auto sent = link->send_stop();
    if (attempt == 0) first = sent;
    const MonoTime deadline = link->clock().now() + stop_time();
    while (!link->is_stopped(first) && link->clock().now() < deadline) {
      auto waited = co_await waiting.next(deadline);
      if (!waited) co_return fail(waited.error());
    }
    if (link->is_stopped(first)) co_return Result<>();
  }
  co_return fail(Errc::not_standing, "{}: STOP twice -> standstill not confirmed: use the E-stop",
                 link->name());
}

}  // namespace lcrig
