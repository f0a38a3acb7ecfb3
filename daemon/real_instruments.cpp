// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "daemon/instruments.hpp"
#include "drivers/dead_weight/driver.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/port.hpp"
#include "drivers/zwick/driver.hpp"

namespace lcrig {

namespace {

class RealInstruments final : public Instruments {
 public:
  RealInstruments(const Config& config, std::unique_ptr<LcrMeter> meter,
                  std::unique_ptr<LoadFrame> frame, RemoteOperator& person)
      : meter_(std::move(meter)), frame_(std::move(frame)), person_(person) {
    info_.fixture = config.fixture;
  }
  LcrMeter& meter() override { return *meter_; }
  LoadFrame& frame() override { return *frame_; }
  Operator& person() override { return person_; }
  Task<> close() override {
    meter_->close();
    frame_->close();
    co_return;
  }

 private:
  std::unique_ptr<LcrMeter> meter_;
  std::unique_ptr<LoadFrame> frame_;
  RemoteOperator& person_;
};

}  // namespace

Task<Result<>> RemoteOperator::confirm(std::string prompt) {
  while (confirmations_.try_receive([](auto&&...) {})) {
  }
  prompt_ = std::move(prompt);
  // The prompt goes away with the wait, cancelled or not.
  const auto clear = [](std::string* p) { p->clear(); };
  const std::unique_ptr<std::string, decltype(clear)> guard(&prompt_, clear);
  auto r = co_await confirmations_.async_receive(asio::as_tuple(asio::use_awaitable));
  if (std::get<0>(r)) co_return fail(Errc::aborted, "the prompt was withdrawn");
  co_return Result<>();
}

bool RemoteOperator::confirmed() {
  return !prompt_.empty() && confirmations_.try_send(boost::system::error_code());
}

Task<Result<std::unique_ptr<Instruments>>> open_real_instruments(asio::any_io_executor executor,
                                                                 Clock& clock, const Config& config,
                                                                 RemoteOperator& person) {
  auto meter_port = co_await open_port(config.meter_port, SerialSettings(), clock);
  if (!meter_port) co_return fail(meter_port.error());
  auto meter = std::make_unique<lcr6100::Lcr6100>(std::move(*meter_port), clock,
                                                  config.meter_serial_number);
  std::unique_ptr<LoadFrame> frame;
  if (config.frame_driver == FrameDriver::dead_weight) {
    DeadWeightSettings settings;
    settings.g_m_s2 = config.fixture.local_gravity_m_s2;
    settings.probe_area = Area::from_si(config.fixture.probe_area_m2());
    frame = std::make_unique<DeadWeightFrame>(person, clock, executor, settings);
  } else {
    auto frame_port = co_await open_port(config.frame_port, SerialSettings(), clock);
    if (!frame_port) co_return fail(frame_port.error());
    frame = std::make_unique<ZwickLink>(std::move(*frame_port), clock, executor);
  }
  std::unique_ptr<Instruments> all = std::make_unique<RealInstruments>(
      config, std::move(meter), std::move(frame), person);
  co_return all;
}

}  // namespace lcrig
