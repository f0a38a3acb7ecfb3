// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/real.hpp"

#include <utility>

#include "base/aside.hpp"
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
                  std::unique_ptr<LoadFrame> frame, Operator& person)
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
  Operator& person_;
};

class MeterAtPort final : public LoneMeter {
 public:
  explicit MeterAtPort(std::unique_ptr<LcrMeter> meter) : meter_(std::move(meter)) {}
  LcrMeter& meter() override { return *meter_; }
  Task<> close() override {
    meter_->close();
    co_return;
  }

 private:
  std::unique_ptr<LcrMeter> meter_;
};

// `busy` means that a run goes on. A port that another program holds is a fault of the rig instead.
Error as_rig_fault(Error error) {
  if (error.code == Errc::busy) error.code = Errc::disconnected;
  return error;
}

}  // namespace

RealRig::RealRig(asio::any_io_executor executor, Clock& clock, const Config& config,
                 KnownRig& known, Operator& person)
    : executor_(std::move(executor)),
      clock_(clock),
      config_(config),
      known_(known),
      person_(person) {
  const bool weights = config.frame_driver == FrameDriver::dead_weight;
  known_.declare(Instrument::lcr, config.meter_port, "the daemon has just begun", false);
  known_.declare(Instrument::frame, weights ? "dead weights" : config.frame_port,
                 "an idle daemon leaves the frame alone", false);
  if (!config.wire_log_directory.empty()) wire_logs_.emplace();
}

// Ends the shared logs, which would stay in the old folder.
void RealRig::config_changed() {
  looks_.clear();
  if (!config_.wire_log_directory.empty() && !wire_logs_) wire_logs_.emplace();
}

bool RealRig::finish_wire_logs(Duration patience) {
  return !wire_logs_ || wire_logs_->finish(patience);
}

// Opens a port; with a wire log directory all its bytes are logged. A port opens even if its log
// cannot be written, because making the frame safe is more important.
Task<Result<std::unique_ptr<Transport>>> RealRig::open_logged(std::string url,
                                                              std::string instrument,
                                                              WireLogOf log) {
  auto port = co_await open_port(std::move(url), SerialSettings(), clock_);
  if (!port) co_return fail(as_rig_fault(port.error()));
  if (config_.wire_log_directory.empty()) co_return port;
  port = std::make_unique<RecordingTransport>(std::move(*port), wire_log(instrument, log));
  co_return port;
}

std::shared_ptr<WireRecord> RealRig::wire_log(const std::string& instrument, WireLogOf log) {
  constexpr Duration kDay = std::chrono::hours(24);
  // Bytes; more than a day of questions needs.
  constexpr std::size_t kMostOfLooks = std::size_t{4} << 20U;
  const bool looks = log == WireLogOf::looks;
  if (looks && looks_[instrument] && looks_[instrument]->age() < kDay) return looks_[instrument];
  WireLogHeader header;
  header.instrument = instrument;
  header.date = fmt::format("{} ns since 1970", clock_.unix_ns());
  const auto name = wire_log_name(instrument, log, clock_.unix_ns());
  auto file = wire_logs_->create(config_.wire_log_directory + "/" + name, instrument);
  auto out = std::make_shared<WireRecord>(std::move(file), clock_, header,
                                          looks ? kMostOfLooks : WireRecord::kUnlimited);
  if (looks) looks_[instrument] = out;
  return out;
}

Task<Result<std::unique_ptr<LcrMeter>>> RealRig::open_meter(WireLogOf log) {
  auto port = co_await open_logged(config_.meter_port, "lcr", log);
  if (!port) co_return fail(port.error());
  co_return config_.meter_driver->make(std::move(*port), clock_, config_.meter_serial_number);
}

Task<Result<std::unique_ptr<LoadFrame>>> RealRig::open_link(WireLogOf log) {
  auto port = co_await open_logged(config_.frame_port, "frame", log);
  if (!port) co_return fail(port.error());
  co_return std::make_unique<ZwickLink>(std::move(*port), clock_, executor_);
}

Task<Result<std::unique_ptr<LoadFrame>>> RealRig::open_frame(WireLogOf log) {
  std::unique_ptr<LoadFrame> frame;
  if (config_.frame_driver == FrameDriver::dead_weight) {
    DeadWeightSettings settings;
    settings.g_m_s2 = config_.fixture.local_gravity_m_s2;
    frame = std::make_unique<DeadWeightFrame>(person_, clock_, executor_, settings);
    co_return frame;
  }
  auto link = co_await open_link(log);
  if (!link) co_return link;
  const auto again = [this, log] { return open_link(log); };
  frame = std::make_unique<ReopeningFrame>(std::move(*link), again, config_.frame.stated);
  co_return frame;
}

Task<Result<std::unique_ptr<Instruments>>> RealRig::open(InstrumentsRequest request) {
  if (wire_logs_) wire_logs_->remind();
  if (request.why != LearnedBy::plan) looks_.clear();
  auto first = co_await open_meter(WireLogOf::run);
  if (!first) {
    known_.failed(Instrument::lcr, first.error(), Learned(request.why));
    co_return fail(first.error());
  }
  const auto again = [this] { return open_meter(WireLogOf::run); };
  auto meter = std::make_unique<ReopeningMeter>(std::move(*first), again);
  auto frame = co_await open_frame(WireLogOf::run);
  if (!frame) {
    known_.failed(Instrument::frame, frame.error(), Learned(request.why));
    co_return fail(frame.error());
  }
  std::unique_ptr<Instruments> all =
      std::make_unique<RealInstruments>(config_, std::move(meter), std::move(*frame), person_);
  co_return all;
}

Task<bool> RealRig::watch_ports() {
  const auto look = [lcr = known_.port(Instrument::lcr), frame = known_.port(Instrument::frame)] {
    return std::pair(is_port_there(lcr), is_port_there(frame));
  };
  const auto there = co_await run_abandonable(executor_, clock_, look);
  if (!there) co_return false;
  const bool lcr = known_.set_port_there(Instrument::lcr, there->first);
  const bool frame = known_.set_port_there(Instrument::frame, there->second);
  co_return lcr || frame;
}

Task<Result<std::unique_ptr<LoneMeter>>> RealRig::open_lone_meter() {
  auto meter = co_await open_meter(WireLogOf::looks);
  if (!meter) co_return fail(meter.error());
  std::unique_ptr<LoneMeter> out = std::make_unique<MeterAtPort>(std::move(*meter));
  co_return out;
}

Task<> RealRig::ask() {
  co_await ask_frame();
  co_await ask_meter();
}

Task<> RealRig::ask_meter() {
  auto meter = co_await open_meter(WireLogOf::looks);
  if (!meter) {
    known_.failed(Instrument::lcr, meter.error(), Learned(LearnedBy::look));
    co_return;
  }
  auto identity = co_await (*meter)->identify();
  known_.learned(Instrument::lcr, identity, Learned(LearnedBy::look));
  (*meter)->close();
}

Task<> RealRig::ask_frame() {
  auto frame = co_await open_frame(WireLogOf::looks);
  if (!frame) {
    known_.failed(Instrument::frame, frame.error(), Learned(LearnedBy::look));
    co_return;
  }
  auto identity = co_await (*frame)->observe(0);
  known_.learned(Instrument::frame, identity, Learned(LearnedBy::look));
  if (identity) {
    known_.stated((*frame)->capabilities());
  } else if (identity.error().code == Errc::unsupported) {
    known_.cannot_state(config_.frame.stated);
  }
  (*frame)->close();
}

Task<bool> RealRig::make_frame_safe() {
  auto frame = co_await open_frame(WireLogOf::run);
  if (!frame) {
    known_.failed(Instrument::frame, frame.error(), Learned(LearnedBy::rescue));
    co_return false;
  }
  auto stopped = co_await (*frame)->stop();
  auto identity = co_await (*frame)->identify();
  if (identity) stopped = co_await (*frame)->stop();
  known_.learned(Instrument::frame, identity, Learned(LearnedBy::rescue));
  if (!stopped) known_.failed(Instrument::frame, stopped.error(), Learned(LearnedBy::rescue));
  (*frame)->close();
  co_return stopped.has_value();
}

}  // namespace lcrig
