// SPDX-License-Identifier: Apache-2.0
// The first contact of a session with its instruments: it asks their identity, looks at the frame,
// and takes command. It reports everything to KnownRig, whatever becomes of the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/rig/instruments.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/session.hpp"
#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

using namespace std::chrono_literals;

namespace {

// Fewer tell too little about the noise of the cell, so the room that it needs would depend on
// chance. A cell that shows one value only tells nothing yet, not even its digit.
constexpr std::int64_t kEnoughForces = 20;

// Collects the samples of a frame that is only observed.
struct Looker final : LoadFrame::Listener {
  explicit Looker(LoadFrame& f) : frame(f) { frame.set_listener(this); }
  ~Looker() override { frame.set_listener(nullptr); }
  Looker(const Looker&) = delete;
  Looker& operator=(const Looker&) = delete;
  void on_samples(std::span<const FrameSample> samples) override { rest.add(samples); }
  void on_frame_event(EventName, std::string) override {}
  void on_frame_lost(Error error) override { lost = std::move(error); }
  LoadFrame& frame;
  RestMeasurement rest;
  std::optional<Error> lost;
};

}  // namespace

// Compares the mean of a few readings; the first one after new settings is ignored.
Task<Result<>> Session::compare_at_rest() {
  constexpr int kReadings = 5;
  const auto& wanted = prepared_.at_rest;
  if (!wanted || !is_capacitance(settings_.function)) co_return Result<>();
  double sum_F = 0;
  bool overload = false;
  for (int i = 0; i <= kReadings; ++i) {
    auto reading = co_await instruments_->meter().measure();
    if (!reading) co_return fail(reading.error());
    overload = overload || !reading->primary;
    if (i > 0) sum_F += reading->primary.value_or(0);
  }
  const double mean_F = sum_F / kReadings;
  if (!overload && std::abs(mean_F - wanted->capacitance_F) <= wanted->tolerance_F) {
    co_return Result<>();
  }
  const std::string shown =
      overload ? "the meter is overloaded" : fmt::format("{:.4g} pF are shown", mean_F * 1e12);
  stranger_ = fmt::format("at rest {}, but {} had {:.4g} pF {} ({:.2g} pF more or less allowed)",
                          shown, prepared_.request.specimen_name, wanted->capacitance_F * 1e12,
                          wanted->source, wanted->tolerance_F * 1e12);
  co_return fail(Errc::refused, "{}", *stranger_);
}

void Session::report_to(KnownRig& known, LearnedBy why) {
  known_ = &known;
  learned_ = Learned(why);
}

void Session::learn(Instrument which, const Result<Identity>& answer) {
  if (known_ != nullptr) known_->learned(which, answer, learned_);
}

// From here on, what is known about the instruments comes from this run.
void Session::learn_of_run(std::int64_t run) {
  learned_ = Learned(LearnedBy::run, run);
  for (const Instrument which : {Instrument::lcr, Instrument::frame}) on_loss(which, nullptr);
}

void Session::on_loss(Instrument which, const Error* lost) {
  if (known_ == nullptr) return;
  if (lost != nullptr) {
    known_->failed(which, *lost, learned_);
  } else {
    known_->confirmed(which, learned_);
  }
}

// If the frame cannot be observed and will be commanded anyway, takes command at once.
Task<Result<>> Session::identify() {
  auto meter = co_await instruments_->meter().identify();
  learn(Instrument::lcr, meter);
  if (!meter) co_return fail(meter.error());
  meter_identity_ = std::move(*meter);
  LoadFrame& frame = instruments_->frame();
  // 0: unknown before the frame has reported its identity. If the protocol wants a higher rate, the
  // plan refuses it.
  const double most_Hz = frame.capabilities().sample_rate_max_Hz;
  const double wanted_Hz = prepared_.protocol.sample.frame_rate_Hz;
  const double rate_Hz = most_Hz > 0 ? std::min(wanted_Hz, most_Hz) : wanted_Hz;
  auto seen = co_await frame.observe(rate_Hz);
  if (!seen && seen.error().code == Errc::unsupported && commands_) {
    seen = co_await frame.identify();
    commanded_ = true;
    if (seen) {
      auto rate = co_await frame.set_sample_rate(std::min(prepared_.protocol.sample.frame_rate_Hz,
                                                          frame.capabilities().sample_rate_max_Hz));
      if (!rate) seen = fail(rate.error());
    }
  }
  learn(Instrument::frame, seen);
  if (seen && known_ != nullptr) known_->stated(frame.capabilities());
  if (!seen && seen.error().code == Errc::unsupported) {
    co_return fail(Errc::unsupported, "{}; no change of the protocol can help", seen.error().what);
  }
  if (!seen) co_return fail(seen.error());
  frame_identity_ = std::move(*seen);
  co_return Result<>();
}

// Measures where the frame stands and how its force scatters there; the plan uses both.
Task<Result<>> Session::look() {
  rig_ = describe_rig(*instruments_);
  const FrameCapabilities& caps = rig_.frame;
  if (!caps.motion || !commands_) co_return Result<>();
  Looker looker(instruments_->frame());
  const MonoTime begin = clock_.now();
  const auto enough = [&] {
    const Duration seen = clock_.now() - begin;
    const std::int64_t forces = looker.rest.forces();
    if (seen >= (forces > 0 ? 4s : 2s)) return true;
    return seen >= 500ms && forces >= kEnoughForces && looker.rest.is_alive();
  };
  // Polled, because it ends by time, too; another end would move the times of every stored row.
  while (!enough() && !looker.lost) co_await clock_.wait_for(50ms);
  if (looker.lost) {
    learn(Instrument::frame, fail(*looker.lost));
    co_return fail(*looker.lost);
  }
  if (const auto travel = looker.rest.travel_m()) rig_.start_travel = Length::from_si(*travel);
  if (looker.rest.forces() > 1) {
    rig_.force_noise_N = looker.rest.scatter_N();
    rig_.force_scatter = CellNoise(looker.rest);
    rig_.rest_force_N = looker.rest.force_N();
  }
  co_return Result<>();
}

Task<Result<>> Session::take_command() {
  if (!commands_ || commanded_) co_return Result<>();
  const FrameCapabilities before = instruments_->frame().capabilities();
  auto identity = co_await instruments_->frame().identify();
  learn(Instrument::frame, identity);
  if (!identity) co_return fail(identity.error());
  if (instruments_->frame().capabilities() != before) {
    co_return fail(Errc::refused, "the frame's capabilities changed while the run was planned");
  }
  co_return Result<>();
}

}  // namespace lcrig
