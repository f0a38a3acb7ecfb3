// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "daemon/rig/instruments.hpp"
#include "drivers/dead_weight/driver.hpp"
#include "drivers/port.hpp"
#include "drivers/recording_transport.hpp"
#include "drivers/reopening.hpp"
#include "drivers/zwick/driver.hpp"

namespace lcrig {

namespace {

class RealInstruments final : public Instruments {
 public:
  RealInstruments(const Config& config, std::unique_ptr<LcrMeter> meter,
                  std::unique_ptr<LoadFrame> frame, RemoteOperator& person)
      : meter_(std::move(meter)), frame_(std::move(frame)), person_(person) {
    info_.fixture = config.fixture;
    info_.frame = config.frame;
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

namespace {

// `busy` tells a client that a run goes on; a port that another program holds is a fault of the
// rig.
Error as_rig_fault(Error error) {
  if (error.code == Errc::busy) error.code = Errc::disconnected;
  return error;
}

// Opens a port; with a wire log directory every byte is written down there.
Task<Result<std::unique_ptr<Transport>>> open_logged(std::string url, std::string instrument,
                                                     const Config& config, Clock& clock) {
  auto port = co_await open_port(std::move(url), SerialSettings(), clock);
  if (!port) co_return fail(as_rig_fault(port.error()));
  if (config.wire_log_directory.empty()) co_return port;
  WireLogHeader header;
  header.instrument = instrument;
  header.date = fmt::format("{} ns since 1970", clock.unix_ns());
  const std::string path =
      fmt::format("{}/{}-{}.wire", config.wire_log_directory, instrument, clock.unix_ns());
  auto logged = make_recording(std::move(*port), clock, path, header);
  co_return logged;
}

}  // namespace

Task<Result<std::unique_ptr<LcrMeter>>> open_real_meter(Clock& clock, const Config& config) {
  auto port = co_await open_logged(config.meter_port, "lcr", config, clock);
  if (!port) co_return fail(port.error());
  co_return config.meter_driver->make(std::move(*port), clock, config.meter_serial_number);
}

namespace {

Task<Result<std::unique_ptr<LoadFrame>>> open_link(asio::any_io_executor executor, Clock& clock,
                                                   const Config& config) {
  auto port = co_await open_logged(config.frame_port, "frame", config, clock);
  if (!port) co_return fail(port.error());
  co_return std::make_unique<ZwickLink>(std::move(*port), clock, executor);
}

}  // namespace

Task<Result<std::unique_ptr<LoadFrame>>> open_real_frame(asio::any_io_executor executor,
                                                         Clock& clock, const Config& config,
                                                         RemoteOperator& person) {
  std::unique_ptr<LoadFrame> frame;
  if (config.frame_driver == FrameDriver::dead_weight) {
    DeadWeightSettings settings;
    settings.g_m_s2 = config.fixture.local_gravity_m_s2;
    if (const auto area_m2 = config.fixture.probe_area_m2()) {
      settings.probe_area = Area::from_si(*area_m2);
    }
    frame = std::make_unique<DeadWeightFrame>(person, clock, executor, settings);
    co_return frame;
  }
  auto link = co_await open_link(executor, clock, config);
  if (!link) co_return link;
  const auto again = [executor, &clock, &config] { return open_link(executor, clock, config); };
  frame = std::make_unique<ReopeningFrame>(std::move(*link), again);
  co_return frame;
}

Task<Result<std::unique_ptr<Instruments>>> open_real_instruments(asio::any_io_executor executor,
                                                                 Clock& clock, const Config& config,
                                                                 RemoteOperator& person) {
  auto first = co_await open_real_meter(clock, config);
  if (!first) co_return fail(first.error());
  const auto again = [&clock, &config] { return open_real_meter(clock, config); };
  auto meter = std::make_unique<ReopeningMeter>(std::move(*first), again);
  auto frame = co_await open_real_frame(executor, clock, config, person);
  if (!frame) co_return fail(frame.error());
  std::unique_ptr<Instruments> all =
      std::make_unique<RealInstruments>(config, std::move(meter), std::move(*frame), person);
  co_return all;
}

}  // namespace lcrig
