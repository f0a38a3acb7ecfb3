// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sampler.hpp"

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

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

// Lets the watchdog see how long one exchange takes.
class Sampler::Exchange {
 public:
  explicit Exchange(Sampler& s) : sampler_(s) {
    ++s.exchanges_;
    if (!s.waiting_) s.waiting_ = s.clock_.now();
    s.exchange_ = s.clock_.now();
  }
  ~Exchange() { sampler_.exchange_.reset(); }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

 private:
  Sampler& sampler_;
};

Sampler::Sampler(asio::any_io_executor executor, Clock& clock, LcrMeter& lcr, MeterState state,
                 Hooks hooks)
    : executor_(executor),
      clock_(clock),
      lcr_(lcr),
      state_(std::move(state)),
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
  const Duration limit =
      std::max<Duration>(6s, 4 * lcr_.capabilities().conversion_time(state_.settings));
  if (now - *waiting_ <= limit) return std::nullopt;
  return fmt::format("the meter gave no reading for {:.1f} s", to_seconds(now - *waiting_));
}

std::optional<std::uint64_t> Sampler::overdue(MonoTime now) const {
  if (!exchange_) return std::nullopt;
  const Duration longest = 15s + 4 * lcr_.capabilities().conversion_time(state_.settings);
  if (now - *exchange_ <= longest) return std::nullopt;
  return exchanges_;
}

Result<> Sampler::lose(Error error) {
  waiting_.reset();
  hooks_.lost(error);
  return fail(std::move(error));
}

bool Sampler::is_lost(const Error& error) const {
  return error.code == Errc::disconnected || failures_ >= kFailuresInARow || astray_;
}

Task<Result<ReadBack>> Sampler::ask_back() {
  const Exchange exchange(*this);
  MeterState wanted = state_;
  auto found = co_await lcr_.read_back(std::move(wanted));
  if (!found) {  // only a reading ends a row of failures
    ++failures_;
    proof_.doubt();
    hooks_.event(EventKind::retry, found.error().what);
  }
  co_return found;
}

Result<> Sampler::judge(const ReadBack& found) {
  ReadBackEvent event;
  event.equal = found.equal();
  if (found.equal()) {
    proof_.equal(clock_.now());
    hooks_.read_back(event);
    return {};
  }
  proof_.doubt();
  event.differs = found.differs;
  hooks_.read_back(event);
  const std::string keys = fmt::format("{}", fmt::join(found.differs, ", "));
  const auto span = proof_.unproven("the meter had other settings at the next read-back: " + keys);
  if (span) hooks_.unproven(*span);
  return fail(Errc::refused,
              "the meter has other settings than this run set ({}): it restarted, or its keys were "
              "used; {} readings are unproven",
              keys, span ? span->readings : 0);
}

Task<Result<>> Sampler::compare() {
  // A read-back proves the readings before it. In virtual time it may be in the same instant.
  if (proof_.has_open() && clock_.now() <= proof_.last_asked()) co_await clock_.wait_for(1us);
  auto found = co_await ask_back();
  if (!found) co_return fail(found.error());
  auto same = judge(*found);
  if (!same) astray_ = true;
  co_return same;
}

// Asks until the meter answers, or is lost.
Task<Result<>> Sampler::compare_surely() {
  for (;;) {
    auto same = co_await compare();
    if (same) co_return same;
    const auto state = co_await asio::this_coro::cancellation_state;
    if (state.cancelled() != asio::cancellation_type::none) co_return same;
    if (is_lost(same.error())) co_return lose(same.error());
    co_await clock_.wait_for(100ms);
  }
}

Task<Result<>> Sampler::prove() {
  const Duration longest = 5s + 4 * lcr_.capabilities().conversion_time(state_.settings);
  auto r = co_await either(meter_.async_receive(kAsResult), clock_.wait_for(longest));
  if (r.index() == 1) {
    co_return fail(Errc::busy,
                   "the meter's settings were not read back: it is busy with another exchange");
  }
  const Lock lock(*this, true);
  co_return co_await compare();
}

Task<> Sampler::finish_proof() {
  if (!proof_.has_open()) co_return;
  auto same = co_await prove();
  if (same) co_return;
  const auto rest = proof_.unproven(same.error().what);
  if (rest) hooks_.unproven(*rest);
}

// Sending the set-up again ends the slow state of the meter, if its settings are those of the run.
Task<Result<>> Sampler::end_slowness() {
  auto same = co_await compare();
  if (!same) co_return same;
  spdlog::warn("the meter became slow; its set-up is sent again");
  LcrSettings wanted = state_.settings;
  const Exchange exchange(*this);
  auto got = co_await lcr_.configure(std::move(wanted));
  if (!got) {
    ++failures_;
    hooks_.event(EventKind::retry, got.error().what);
    co_return fail(got.error());
  }
  slow_ = false;
  proof_.doubt();
  waiting_.reset();
  next_flags_ |= lcr_flag::kAfterSetUp;
  co_return Result<>();
}

// The settings of a meter that is there are sent again; another one is opened again.
Task<Result<LcrSettings>> Sampler::bring_back() {
  MeterState wanted = state_;
  if (std::exchange(astray_, false)) co_return co_await lcr_.restore(std::move(wanted));
  auto back = co_await lcr_.reconnect(std::move(wanted));
  if (!back) co_return fail(back.error());
  auto found = judge(back->found);  // what differs is known to be unproven from now on
  static_cast<void>(found);
  co_return back->settings;
}

Task<Result<>> Sampler::reconnect() {
  co_await acquire();
  const Lock lock(*this, true);
  auto got = co_await bring_back();
  if (!got) co_return fail(got.error());
  state_.settings = *got;
  failures_ = 0;
  auto same = co_await compare();
  if (!same) co_return same;
  half_set_ = slow_ = false;
  next_flags_ |= lcr_flag::kAfterGap;
  co_return Result<>();
}

Task<> Sampler::stop() {
  ending_ = true;
  if (!running_) co_return;
  const Duration patience = lcr_.capabilities().conversion_time(state_.settings) + 2s;
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
    if (ending_ || astray_) break;
    if (half_set_) {
      co_await clock_.wait_for(100ms);
      continue;
    }
    if (proof_.is_due(clock_.now())) proof_.doubt();
    auto reading = co_await read_once();
    if (!reading) {
      if (ending_ || interrupted_) break;
      if (is_lost(reading.error())) {
        static_cast<void>(lose(reading.error()));
        break;
      }
      co_await clock_.wait_for(100ms);  // do not spin on a failing line
      continue;
    }
    store(*reading, hooks_.tag());
  }
}

void Sampler::store(const LcrReading& reading, const ReadingTag& tag) {
  if (reading.fresh) proof_.taken(reading, clock_.now());
  hooks_.taken(reading, tag);
}

// Reads the settings back first, if they are doubted.
Task<Result<LcrReading>> Sampler::read_once() {
  if (slow_ || proof_.is_doubted()) {
    auto same = co_await settle_doubt();
    if (!same) {
      last_failure_ = ": " + same.error().what;
      co_return fail(same.error());
    }
  }
  const Exchange exchange(*this);
  auto reading = co_await lcr_.measure();
  last_failure_ = reading ? "" : ": " + reading.error().what;
  if (reading) {
    failures_ = 0;
    waiting_.reset();
    slow_ = reading->slow;
    reading->flags |= std::exchange(next_flags_, 0);
  } else {
    ++failures_;
    proof_.doubt();
    hooks_.event(EventKind::retry, reading.error().what);
  }
  co_return reading;
}

Task<Result<>> Sampler::settle_doubt() {
  if (slow_) co_return co_await end_slowness();
  co_return co_await compare();
}

// Reads the settings back between two planned readings, if it is time, and there is time.
Task<Result<>> Sampler::compare_before(MonoTime due) {
  const MonoTime now = clock_.now();
  const bool fits = SettingsProof::fits(due - now, lcr_.capabilities());
  if (!proof_.is_due(now) || !fits) co_return Result<>();
  co_return co_await compare_surely();
}

Task<Result<>> Sampler::take(const Plan& plan, std::int64_t& taken) {
  co_await acquire();
  const Lock lock(*this, true);
  const Duration conversion = lcr_.capabilities().conversion_time(state_.settings);
  const Duration period = plan.within / plan.level.planned_readings;
  auto before = co_await compare_surely();
  if (!before) co_return before;
  const MonoTime begin = clock_.now();
  const std::int64_t first = taken;
  // A repeated exchange may use up time of later ones. Beyond this limit the level has failed.
  const MonoTime limit = begin + period * (plan.level.planned_readings - first) +
                         std::max<Duration>(period, conversion) + 1s;
  while (taken < plan.level.planned_readings) {
    const MonoTime due = begin + period * (taken - first);
    auto same = co_await compare_before(due);
    if (!same) co_return same;
    if (clock_.now() < due) co_await clock_.wait_until(due);
    if (clock_.now() > limit) {
      auto late =
          fail(Errc::no_reply, "step {}: only {} of {} readings in {:.1f} s{}", plan.level.step_id,
               taken, plan.level.planned_readings, to_seconds(clock_.now() - begin), last_failure_);
      // A meter that is still silent is lost, not slow.
      if (failures_ > 0) co_return lose(std::move(late.value()));
      co_return late;
    }
    auto done = co_await take_one(plan, due, taken);
    if (!done) co_return done;
  }
  co_return co_await compare_surely();
}

Task<Result<>> Sampler::take_one(const Plan& plan, MonoTime due, std::int64_t& taken) {
  const Duration late = clock_.now() - due;
  auto reading = co_await read_once();
  if (!reading) {
    // A cancelled read also reports `disconnected`.
    const auto state = co_await asio::this_coro::cancellation_state;
    if (state.cancelled() != asio::cancellation_type::none) co_return fail(reading.error());
    if (is_lost(reading.error())) co_return lose(reading.error());
    co_return Result<>();
  }
  ReadingTag tag;
  tag.step_id = plan.level.step_id;
  tag.repeat = plan.level.repeat;
  tag.level = plan.level.level;
  tag.planned = due;
  if (reading->fresh) tag.index = ++taken;
  store(*reading, tag);
  if (late > kLateness) {
    hooks_.event(EventKind::late, fmt::format("reading {} of level {} was asked {:.0f} ms late",
                                              tag.index, tag.level, to_seconds(late) * 1e3));
  }
  co_return Result<>();
}

Task<Result<>> Sampler::configure(LcrSettings settings) {
  co_await acquire();
  const Lock lock(*this, true);
  if (proof_.has_open()) {
    auto same = co_await compare_surely();
    if (!same) co_return same;
  }
  half_set_ = true;
  MeterState wanted(std::move(settings), state_.corrections);
  auto got = co_await lcr_.restore(std::move(wanted));
  const auto state = co_await asio::this_coro::cancellation_state;
  if (state.cancelled() != asio::cancellation_type::none) {
    co_return fail(Errc::aborted, "the set-up of the meter was given up");
  }
  if (!got && (got.error().code == Errc::disconnected || got.error().code == Errc::no_reply)) {
    co_return lose(got.error());
  }
  if (!got) co_return fail(got.error());
  state_.settings = *got;
  half_set_ = slow_ = false;
  proof_.doubt();  // so that they are read back once more, when they have settled
  co_return Result<>();
}

}  // namespace lcrig
