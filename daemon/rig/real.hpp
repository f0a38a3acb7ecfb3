// SPDX-License-Identifier: Apache-2.0
// The real instruments, at the ports of the config file. App asks for their identities while no run
// goes on.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/wire_log_name.hpp"
#include "daemon/rig/instruments.hpp"
#include "drivers/recording_transport.hpp"
#include "drivers/transport.hpp"
#include "drivers/wire_log_writer.hpp"

namespace lcrig {

// `config`, `clock`, `known` and `person` must outlive it and everything that it opens, because a
// lost port is opened again. Errors: as open_port.
class RealRig final : public InstrumentFactory {
 public:
  RealRig(asio::any_io_executor executor, Clock& clock, const Config& config, KnownRig& known,
          Operator& person);

  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) override;
  Task<> ask() override;
  Task<Result<std::unique_ptr<LoneMeter>>> open_lone_meter() override;
  bool is_real() const override { return true; }
  Task<> ask_meter() override;
  Task<bool> make_frame_safe() override;
  Task<bool> watch_ports() override;
  void config_changed() override;  // the wire logs may have another folder
  bool finish_wire_logs(Duration patience) override;

 private:
  // `log`: a run opens logs of its own; looks share one per instrument and day.
  Task<Result<std::unique_ptr<Transport>>> open_logged(std::string url, std::string instrument,
                                                       WireLogOf log);
  std::shared_ptr<WireRecord> wire_log(const std::string& instrument, WireLogOf log);
  Task<Result<std::unique_ptr<LcrMeter>>> open_meter(WireLogOf log);
  Task<Result<std::unique_ptr<LoadFrame>>> open_link(WireLogOf log);
  Task<Result<std::unique_ptr<LoadFrame>>> open_frame(WireLogOf log);
  Task<> ask_frame();

  asio::any_io_executor executor_;
  Clock& clock_;
  const Config& config_;
  KnownRig& known_;
  Operator& person_;
  std::optional<WireLogWriter> wire_logs_;  // set once the config has asked for wire logs
  std::map<std::string, std::shared_ptr<WireRecord>> looks_;  // shared logs by instrument, for a
                                                              // day
};

}  // namespace lcrig
