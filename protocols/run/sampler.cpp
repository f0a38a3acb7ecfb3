// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sampler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/this_coro.hpp>
#include <memory>
#include <utility>

#include "base/as_result.hpp"
#include "base/either.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;
constexpr int kFailuresInARow = 5;
constexpr Duration kLateness = 20ms;  // a planned reading taken later than this is reported

}  // namespace

// Releases the meter when its scope ends, even by cancellation.
class Sampler::Lock {
 public:
  explicit Lock(Sampler& s, bool ends_wait = false) : sampler_(s), ends_wait_(ends_wait) {}
  ~Lock() {
    if (ends_wait_) sampler_.waiting_.reset();
    sampler_.release();
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  Sampler& sampler_;
  bool ends_wait_;  // afterwards nobody waits for a reading
};

Sampler::Sampler(asio::any_io_executor executor, Clock& clock, LcrMeter& lcr, LcrSettings settings,
                 Hooks hooks)
    : executor_(executor),
      clock_(clock),
      lcr_(lcr),
      settings_(std::move(settings)),
      hooks_(std::move(hooks)),
      meter_(executor, 1),
      ended_(executor, 1) {
  release();
}

// Waits for the meter. A cancelled wait throws at the next co_await of the cancelled task, which
// never got the token.
Task<> Sampler::acquire() {
  auto r = co_await meter_.async_receive(kAsResult);
  if (std::get<0>(r)) throw boost::system::system_error(std::get<0>(r));
}

void Sampler::release() {
  meter_.try_send(boost::system::error_code());
}

void Sampler::start(bool continuous) {
  if (!continuous || running_) return;
  while (ended_.try_receive([](auto&&...) {})) {
  }
  running_ = true;
  ending_ = interrupted_ = false;
  auto ended = [this](std::exception_ptr error) {
    running_ = false;
    waiting_.reset();
    if (error && !ending_ && !interrupted_) {
      hooks_.lost(Error(Errc::bug, "the background readings ended by an exception"));
    }
    ended_.try_send(boost::system::error_code());
  };
  asio::co_spawn(executor_, background(), asio::bind_cancellation_slot(cancel_.slot(), ended));
}

void Sampler::interrupt() {
  interrupted_ = true;
  cancel_.emit(asio::cancellation_type::terminal);
}

std::optional<std::string> Sampler::check_age(MonoTime now) const {
  if (!waiting_) return std::nullopt;
  const Duration limit = std::max<Duration>(6s, 4 * lcr_.capabilities().conversion_time(settings_));
  if (now - *waiting_ <= limit) return std::nullopt;
  return fmt::format("the meter gave no reading for {:.1f} s", to_seconds(now - *waiting_));
}

std::optional<std::uint64_t> Sampler::overdue(MonoTime now) const {
  if (!exchange_) return std::nullopt;
  const Duration longest = 15s + 4 * lcr_.capabilities().conversion_time(settings_);
  if (now - *exchange_ <= longest) return std::nullopt;
  return exchanges_;
}

Result<> Sampler::lose(Error error) {
  waiting_.reset();
  hooks_.lost(error);
  return fail(std::move(error));
}

Task<Result<>> Sampler::reconnect() {
  co_await acquire();
  const Lock lock(*this, true);
  auto got = co_await lcr_.reconnect();
  if (!got) co_return fail(got.error());
  settings_ = *got;
  failures_ = 0;
  half_set_ = false;
  waiting_.reset();
  after_gap_ = true;
  co_return Result<>();
}

Task<> Sampler::stop() {
  ending_ = true;
  if (!running_) co_return;
  const Duration patience = lcr_.capabilities().conversion_time(settings_) + 2s;
  const MonoTime limit = clock_.now() + std::min<Duration>(patience, 5s);
  auto r = co_await either(ended_.async_receive(kAsResult), clock_.wait_until(limit));
  if (r.index() == 0) co_return;
  cancel_.emit(asio::cancellation_type::terminal);
  auto last = co_await ended_.async_receive(kAsResult);
  static_cast<void>(last);
}

Task<> Sampler::background() {
  while (!ending_) {
    co_await acquire();
    const Lock lock(*this);
    if (ending_) break;
    if (half_set_) {
      co_await clock_.wait_for(100ms);
      continue;
    }
    auto reading = co_await read_once();
    if (!reading) {
      if (ending_ || interrupted_) break;
      if (reading.error().code == Errc::disconnected || failures_ >= kFailuresInARow) {
        static_cast<void>(lose(reading.error()));
        break;
      }
      co_await clock_.wait_for(100ms);  // do not spin on a failing line
      continue;
    }
    hooks_.taken(*reading, hooks_.tag());
  }
}

Task<Result<LcrReading>> Sampler::read_once() {
  ++exchanges_;
  if (!waiting_) waiting_ = clock_.now();
  exchange_ = clock_.now();
  const auto over = [](std::optional<MonoTime>* begin) { begin->reset(); };
  const std::unique_ptr<std::optional<MonoTime>, decltype(over)> guard(&exchange_, over);
  auto reading = co_await lcr_.measure();
  if (reading) {
    failures_ = 0;
    waiting_.reset();
    if (std::exchange(after_gap_, false)) reading->flags |= lcr_flag::kAfterGap;
  } else {
    ++failures_;
    hooks_.event(EventKind::retry, reading.error().what);
  }
  co_return reading;
}

Task<Result<>> Sampler::take(const Plan& plan, std::int64_t& taken) {
  co_await acquire();
  const Lock lock(*this, true);
  const Duration conversion = lcr_.capabilities().conversion_time(settings_);
  const Duration period = plan.within / plan.level.planned_readings;
  const MonoTime begin = clock_.now();
  const std::int64_t first = taken;
  // A repeated exchange may use up time of later ones. Beyond this limit the level has failed.
  const MonoTime limit = begin + period * (plan.level.planned_readings - first) +
                         std::max<Duration>(period, conversion) + 1s;
  while (taken < plan.level.planned_readings) {
    const MonoTime due = begin + period * (taken - first);
    if (clock_.now() < due) co_await clock_.wait_until(due);
    if (clock_.now() > limit) {
      auto late =
          fail(Errc::no_reply, "step {}: only {} of {} readings in {:.1f} s", plan.level.step_id,
               taken, plan.level.planned_readings, to_seconds(clock_.now() - begin));
      // A meter that is still silent is lost, not slow.
      if (failures_ > 0) co_return lose(std::move(late.value()));
      co_return late;
    }
    auto done = co_await take_one(plan, due, taken);
    if (!done) co_return done;
  }
  co_return Result<>();
}

Task<Result<>> Sampler::take_one(const Plan& plan, MonoTime due, std::int64_t& taken) {
  const Duration late = clock_.now() - due;
  auto reading = co_await read_once();
  if (!reading) {
    // A cancelled read also reports `disconnected`.
    const auto state = co_await asio::this_coro::cancellation_state;
    if (state.cancelled() != asio::cancellation_type::none) co_return fail(reading.error());
    if (reading.error().code == Errc::disconnected || failures_ >= kFailuresInARow) {
      co_return lose(reading.error());
    }
    co_return Result<>();
  }
  ReadingTag tag;
  tag.step_id = plan.level.step_id;
  tag.repeat = plan.level.repeat;
  tag.level = plan.level.level;
  tag.planned = due;
  if (reading->fresh) tag.index = ++taken;
  hooks_.taken(*reading, tag);
  if (late > kLateness) {
    hooks_.event(EventKind::late, fmt::format("reading {} of level {} was asked {:.0f} ms late",
                                              tag.index, tag.level, to_seconds(late) * 1e3));
  }
  co_return Result<>();
}

Task<Result<>> Sampler::configure(LcrSettings settings) {
  co_await acquire();
  const Lock lock(*this);
  half_set_ = true;
  auto got = co_await lcr_.configure(std::move(settings));
  const auto state = co_await asio::this_coro::cancellation_state;
  if (state.cancelled() != asio::cancellation_type::none) {
    co_return fail(Errc::aborted, "the set-up of the meter was given up");
  }
  if (!got && (got.error().code == Errc::disconnected || got.error().code == Errc::no_reply)) {
    co_return lose(got.error());
  }
  if (!got) co_return fail(got.error());
  settings_ = *got;
  half_set_ = false;
  co_return Result<>();
}

}  // namespace lcrig
