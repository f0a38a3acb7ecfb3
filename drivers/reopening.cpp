// SPDX-License-Identifier: Apache-2.0
#include "drivers/reopening.hpp"

#include <cmath>
#include <utility>

#include "base/text.hpp"

namespace lcrig {

Result<> compare_identity(const Identity& first, const Identity& now) {
  if (now.maker != first.maker || now.model != first.model) {
    return fail(Errc::refused, "\"{}\" answers instead of \"{}\": plug the first one in again",
                printable(now.text), printable(first.text));
  }
  if (now.serial == first.serial) return {};
  return fail(Errc::refused,
              "another {} answers: serial number {}, but this run began with {}: plug that one in "
              "again",
              printable(now.model), printable(now.serial), printable(first.serial));
}

namespace {

// A new zero of travel shifts both ends of the travel range by the same amount.
bool is_same_machine(FrameCapabilities now, const FrameCapabilities& first) {
  constexpr double kRounding_m = 1e-6;
  const double moved_m = now.travel_min.si() - first.travel_min.si();
  if (std::abs(now.travel_max.si() - first.travel_max.si() - moved_m) > kRounding_m) return false;
  now.travel_min = first.travel_min;
  now.travel_max = first.travel_max;
  return now == first;
}

}  // namespace

Task<Result<Identity>> ReopeningMeter::identify() {
  auto identity = co_await inner_->identify();
  if (identity && !identity_) identity_ = *identity;
  co_return identity;
}

Task<Result<Reconnected>> ReopeningMeter::reconnect(MeterState wanted) {
  if (!identity_) {
    co_return fail(Errc::invalid_request, "a meter comes back only after it was identified once");
  }
  inner_->close();  // frees the port before it is opened again
  auto opened = co_await open_();
  if (!opened) co_return fail(opened.error());
  std::unique_ptr<LcrMeter> meter = std::move(*opened);
  auto identity = co_await meter->identify();
  if (!identity) co_return fail(identity.error());
  if (auto same = compare_identity(*identity_, *identity); !same) co_return fail(same.error());
  // The settings that it has now are those of its last readings, unless it was without power.
  auto found = co_await meter->read_back(wanted);
  if (!found) co_return fail(found.error());
  auto settings = co_await meter->restore(wanted);
  if (!settings) co_return fail(settings.error());
  inner_ = std::move(meter);
  co_return Reconnected(std::move(*settings), std::move(*found));
}

Task<Result<Identity>> ReopeningFrame::identify() {
  auto identity = co_await inner_->identify();
  if (identity) observed_Hz_.reset();
  if (identity) remember(*identity);
  co_return identity;
}

Task<Result<Identity>> ReopeningFrame::observe(double rate_Hz) {
  auto identity = co_await inner_->observe(rate_Hz);
  if (identity) observed_Hz_ = rate_Hz;
  if (identity) remember(*identity);
  co_return identity;
}

void ReopeningFrame::remember(const Identity& identity) {
  if (identity_) return;
  identity_ = identity;
  by_gateway_ = inner_->capabilities();
  counted_ = count_the_worse(by_gateway_, stated_);
}

void ReopeningFrame::set_listener(Listener* listener) {
  listener_ = listener;
  inner_->set_listener(listener);
}

Task<Result<Identity>> ReopeningFrame::reconnect() {
  if (!identity_) co_return fail(Errc::invalid_request, "a frame that was never there");
  inner_->set_listener(nullptr);
  inner_->close();
  auto opened = co_await open_();
  if (!opened) co_return fail(opened.error());
  std::unique_ptr<LoadFrame> frame = std::move(*opened);
  Result<Identity> identity;
  if (observed_Hz_) {
    identity = co_await frame->observe(*observed_Hz_);
  } else {
    identity = co_await frame->identify();
  }
  if (!identity) co_return identity;
  if (auto same = compare_identity(*identity_, *identity); !same) co_return fail(same.error());
  if (!is_same_machine(frame->capabilities(), by_gateway_)) {
    co_return fail(Errc::refused,
                   "the frame came back with other capabilities; begin a new run ({})",
                   printable(identity->text));
  }
  inner_ = std::move(frame);
  inner_->set_listener(listener_);
  co_return identity;
}

}  // namespace lcrig
