// SPDX-License-Identifier: Apache-2.0
// The driver of the GW Instek LCR-6000 series, which speaks its serial dialect (codec.hpp). Created
// by the registry.
#pragma once

#include <memory>
#include <string>

#include "drivers/lcr6100/codec.hpp"
#include "drivers/lcr6100/pace.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/scpi.hpp"

namespace lcrig::lcr6100 {

class Lcr6100 final : public LcrMeter {
 public:
  // `transport` must have been opened just before. With a serial number, identify() refuses any
  // other meter.
  Lcr6100(std::unique_ptr<Transport> transport, Clock& clock, std::string expected_serial = "");

  const LcrCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override;
  Task<Result<LcrSettings>> configure(LcrSettings settings) override;
  // Reads every setting and sends only those that differ. Most of the 2.3 s of a whole set-up are
  // pauses after set commands.
  Task<Result<LcrSettings>> restore(MeterState wanted) override;
  Task<Result<ReadBack>> read_back(MeterState wanted) override;
  Task<Result<LcrReading>> measure() override;
  Task<Result<>> correct(CorrectionKind kind) override;
  Task<Result<CorrectionsOn>> corrections() override;
  Task<Result<>> resync() override;
  Task<Result<>> make_safe() override;
  void close() override { link_.close(); }
  // For a recording, which has the pace of the meter that recorded it, whatever the settings are: a
  // slow one must not be taken for a meter that lost its settings.
  void leave_pace_unjudged() { judges_pace_ = false; }

 private:
  Task<> wake();
  Task<Result<Reply>> ask_identity();
  Task<Result<>> quieten();
  Task<Result<>> set(std::string_view command);
  Task<Result<>> establish(const Setting& setting, LcrSettings& got);
  Task<Result<bool>> is_established(const Setting& setting, LcrSettings& got);
  Task<Result<LcrSettings>> set_up(MeterState wanted, bool look_first);
  Task<Result<Reply>> ask_setting(const Setting& setting, int tries);
  Task<Result<LcrReading>> trigger();
  Task<Result<LcrReading>> poll();
  Task<Result<>> await_verdict(std::string_view command);
  Task<Result<std::optional<bool>>> ask_switch(std::string_view query);
  Result<> check(const LcrSettings& settings) const;
  Result<LcrReading> reading(const Reply& reply, std::string_view command, bool& fresh);
  MonoTime next_poll(MonoTime now) const;
  void note_duration(Duration d);

  ScpiLink link_;
  Clock& clock_;
  std::string expected_serial_;
  LcrCapabilities capabilities_;
  LcrSettings settings_;  // the settings in force, as requested
  Duration conversion_{};
  MonoTime opened_;
  bool awake_ = false, configured_ = false;

  Pace pace_;
  std::string last_values_;  // the numbers of the last answer, as sent
  MonoTime last_poll_{};
  MonoTime last_fresh_{};
  bool judges_pace_ = true;
  int slow_ = 0;  // consecutive readings that took far too long
  MonoTime settled_{};  // when the setting that was sent last has settled
};

}  // namespace lcrig::lcr6100
