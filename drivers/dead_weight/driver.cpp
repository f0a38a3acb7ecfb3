// SPDX-License-Identifier: Apache-2.0
#include "drivers/dead_weight/driver.hpp"

#include <boost/asio/co_spawn.hpp>
#include <cmath>
#include <exception>

#include "base/either.hpp"

namespace lcrig {

namespace {
constexpr double kRateMax_Hz = 10;
constexpr double kMassMax_kg = 1000;  // a larger mass is probably in the wrong unit
}  // namespace

// Shared with the sampling coroutine, which may end slightly after the frame is destroyed.
struct DeadWeightFrame::State {
  State(Clock& c, asio::any_io_executor e, DeadWeightSettings s)
      : clock(c), executor(e), settings(std::move(s)) {}

  Task<> sample() {
    MonoTime due = clock.now();
    while (!closed) {
      const double rate = settings.sample_rate_Hz;
      if (rate <= 0) {
        co_await clock.wait_until(MonoTime::max(), sampler);
        due = clock.now();
      } else if (clock.now() < due) {
        co_await clock.wait_until(due, sampler);
      } else {
        emit();
        due = clock.now() + from_seconds(1 / rate);
      }
    }
  }
  void emit() {
    if (closed || listener == nullptr) return;
    FrameSample s;
    s.device_seq = next_seq++;
    s.force_N = force.si();
    s.received = clock.now();
    listener->on_samples(std::span(&s, 1));
  }
  void failed(std::exception_ptr error) {
    if (error && listener != nullptr && !closed) {
      listener->on_frame_lost(Error(Errc::bug, "dead weights: an exception escaped"));
    }
  }

  Clock& clock;
  asio::any_io_executor executor;
  DeadWeightSettings settings;
  Wakeup sampler, prompt_end;
  Listener* listener = nullptr;
  std::optional<FrameLimits> limits;
  PressureArea pressure;
  Mass mass, pending;  // on the rod now; requested by the open prompt
  Force force;
  std::int64_t next_seq = 1;
  bool started = false, closed = false, prompting = false;
};

DeadWeightFrame::DeadWeightFrame(Operator& person, Clock& clock, asio::any_io_executor executor,
                                 DeadWeightSettings settings)
    : state_(std::make_shared<State>(clock, std::move(executor), std::move(settings))),
      operator_(person) {
  state_->force = force_of(Mass());
  capabilities_.weights = true;
  capabilities_.travel_channel = false;
  capabilities_.force_max = force_of(Mass::from_si(kMassMax_kg));
  capabilities_.sample_rate_max_Hz = kRateMax_Hz;
}

DeadWeightFrame::~DeadWeightFrame() {
  state_->listener = nullptr;
  close();
}

void DeadWeightFrame::close() {
  state_->closed = true;
  state_->sampler.notify();
  state_->prompt_end.notify();
}

void DeadWeightFrame::set_listener(Listener* listener) {
  state_->listener = listener;
}

Force DeadWeightFrame::force_of(Mass mass) const {
  return (mass + state_->settings.rod) * Acceleration::from_si(state_->settings.g_m_s2);
}
Force DeadWeightFrame::force() const {
  return state_->force;
}
Force DeadWeightFrame::pending_force() const {
  return state_->prompting ? force_of(state_->pending) : state_->force;
}

tl::unexpected<Error> DeadWeightFrame::no_motion() const {
  return fail(Errc::refused, "dead weights: this rig does not move by itself; use place_weight");
}

// A rod takes no commands, so observing it is the same as identifying it.
Task<Result<Identity>> DeadWeightFrame::observe(double rate_Hz) {
  auto identity = co_await identify();
  if (!identity) co_return identity;
  auto sampled = co_await set_sample_rate(rate_Hz);
  if (!sampled) co_return fail(sampled.error());
  co_return identity;
}

Task<Result<Identity>> DeadWeightFrame::identify() {
  if (state_->closed) co_return fail(Errc::disconnected, "dead weights: closed");
  if (!state_->started) {
    state_->started = true;
    const auto on_end = [s = state_](std::exception_ptr error) { s->failed(error); };
    asio::co_spawn(state_->executor, [s = state_] { return s->sample(); }, on_end);
  }
  Identity identity;
  identity.maker = "lcrig";
  identity.model = "dead weights";
  identity.serial = state_->settings.serial;
  identity.text = fmt::format("dead weights, g = {} m/s2, rod {} g", state_->settings.g_m_s2,
                              state_->settings.rod.si() * 1e3);
  co_return identity;
}

Task<Result<>> DeadWeightFrame::arm(FrameLimits limits) {
  const double low = limits.force_min.si(), high = limits.force_max.si();
  if (!(low < high)) co_return fail(Errc::refused, "dead weights: an empty range of force");
  if (!(high <= capabilities_.force_max.si())) {
    co_return fail(Errc::refused, "dead weights: {:.6g} N is beyond any weight set", high);
  }
  state_->limits = limits;
  co_return Result<>();
}

Task<Result<>> DeadWeightFrame::set_sample_rate(double rate_Hz) {
  if (!(rate_Hz >= 0 && rate_Hz <= kRateMax_Hz)) {
    co_return fail(Errc::refused, "dead weights: a sample rate of {} Hz, 0 to {} are possible",
                   rate_Hz, kRateMax_Hz);
  }
  state_->settings.sample_rate_Hz = rate_Hz;
  state_->sampler.notify();
  co_return Result<>();
}

Task<Result<MotionOutcome>> DeadWeightFrame::move_to(Length, Velocity) {
  co_return no_motion();
}
Task<Result<MotionOutcome>> DeadWeightFrame::move_until_force(Force, Velocity, Length) {
  co_return no_motion();
}
Task<Result<MotionOutcome>> DeadWeightFrame::ramp_force(Force, ForceRate) {
  co_return no_motion();
}
Task<Result<>> DeadWeightFrame::hold_travel() {
  co_return Result<>();
}

Task<Result<>> DeadWeightFrame::hold_force(Force force) {
  // Weights can hold only the force that they exert.
  if (std::abs((force - state_->force).si()) <= 1e-3 * std::abs(force.si())) co_return Result<>();
  co_return no_motion();
}

Task<Result<>> DeadWeightFrame::zero(bool, bool) {
  co_return fail(Errc::refused, "dead weights: force is computed, there is nothing to zero");
}

Result<> DeadWeightFrame::check_place(Mass mass) const {
  if (state_->closed) return fail(Errc::disconnected, "dead weights: closed");
  if (!state_->limits) return fail(Errc::refused, "dead weights: not armed, send limits first");
  if (state_->prompting) return fail(Errc::busy, "dead weights: another prompt is open");
  if (!(mass.si() >= 0 && mass.si() <= kMassMax_kg)) {
    return fail(Errc::invalid_request, "dead weights: a mass of {} kg", mass.si());
  }
  const double force = force_of(mass).si();
  // Unloading completely is always allowed.
  if (mass.si() > 0 &&
      (force > state_->limits->force_max.si() || force < state_->limits->force_min.si())) {
    return fail(Errc::limit_tripped, "dead weights: {:.4g} N is outside {:.4g} to {:.4g} N", force,
                state_->limits->force_min.si(), state_->limits->force_max.si());
  }
  return {};
}

std::string DeadWeightFrame::prompt(Mass mass) const {
  const double total_g = (mass + state_->settings.rod).si() * 1e3;
  const double step_g = (mass - state_->mass).si() * 1e3;
  const Force force = force_of(mass);
  std::string total = fmt::format("total {:.6g} g = {:.4g} N", total_g, force.si());
  total += state_->pressure.words(force.si());
  if (mass.si() == 0) return fmt::format("Remove all weights from the rod ({})", total);
  if (step_g < 0) return fmt::format("Take {:.6g} g off the rod ({})", -step_g, total);
  return fmt::format("Place {:.6g} g on the rod ({})", step_g, total);
}

void DeadWeightFrame::show_pressure(const PressureArea& pressure) {
  state_->pressure = pressure;
}

MotionOutcome DeadWeightFrame::outcome(MotionEnd reason) const {
  MotionOutcome o;
  o.reason = reason;
  o.force_N = state_->force.si();
  return o;
}

Task<Result<MotionOutcome>> DeadWeightFrame::place_mass(Mass mass) {
  const auto checked = check_place(mass);
  if (!checked) co_return fail(checked.error());
  struct Prompting {
    explicit Prompting(State& s) : state(s) { state.prompting = true; }
    ~Prompting() { state.prompting = false; }
    State& state;
  };
  const auto state = state_;
  state->pending = mass;
  const Prompting prompting(*state);
  std::string text = prompt(mass);
  auto r = co_await either(operator_.confirm(std::move(text)),
                           state->clock.wait_until(MonoTime::max(), state->prompt_end));
  if (state->closed) co_return fail(Errc::disconnected, "dead weights: closed");
  if (r.index() == 1) co_return outcome(MotionEnd::stopped);
  const auto& confirmed = std::get<0>(r);
  if (!confirmed) co_return fail(confirmed.error());
  state->mass = mass;
  state->force = force_of(mass);
  state->emit();
  co_return outcome(MotionEnd::target);
}

Task<Result<>> DeadWeightFrame::stop() {
  if (state_->prompting) state_->prompt_end.notify();
  co_return Result<>();
}

Task<Result<>> DeadWeightFrame::resync() {
  co_return Result<>();
}

}  // namespace lcrig
