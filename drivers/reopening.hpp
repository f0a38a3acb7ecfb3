// SPDX-License-Identifier: Apache-2.0
// Wrappers that reconnect an instrument that was unplugged. Used by the App. They open the port
// again under the same name (a path, a USB identity, a host), compare the identity with the first
// one and verify the settings. One call is one attempt; the caller decides how often and how long
// to try.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/stated_frame.hpp"

namespace lcrig {

// Opens the port and makes a driver for it. Errors: as open_port.
using OpenMeter = std::function<Task<Result<std::unique_ptr<LcrMeter>>>()>;
using OpenFrame = std::function<Task<Result<std::unique_ptr<LoadFrame>>>()>;

// Errors: refused when `now` is not the instrument `first`; names both serial numbers or, without
// them, both identity lines.
Result<> compare_identity(const Identity& first, const Identity& now);

class ReopeningMeter final : public LcrMeter {
 public:
  ReopeningMeter(std::unique_ptr<LcrMeter> first, OpenMeter open)
      : inner_(std::move(first)), open_(std::move(open)) {}

  const LcrCapabilities& capabilities() const override { return inner_->capabilities(); }
  Task<Result<Identity>> identify() override;
  Task<Result<LcrSettings>> configure(LcrSettings settings) override {
    return inner_->configure(std::move(settings));
  }
  Task<Result<LcrSettings>> restore(MeterState wanted) override {
    return inner_->restore(std::move(wanted));
  }
  Task<Result<ReadBack>> read_back(MeterState wanted) override {
    return inner_->read_back(std::move(wanted));
  }
  Task<Result<LcrReading>> measure() override { return inner_->measure(); }
  Task<Result<>> correct(CorrectionKind kind) override { return inner_->correct(kind); }
  Task<Result<CorrectionsOn>> corrections() override { return inner_->corrections(); }
  Task<Result<>> resync() override { return inner_->resync(); }
  Task<Result<>> make_safe() override { return inner_->make_safe(); }
  Task<Result<Reconnected>> reconnect(MeterState wanted) override;
  void close() override { inner_->close(); }

 private:
  std::unique_ptr<LcrMeter> inner_;
  OpenMeter open_;
  std::optional<Identity> identity_;
};

class ReopeningFrame final : public LoadFrame {
 public:
  // `stated`: by a person, about this frame.
  ReopeningFrame(std::unique_ptr<LoadFrame> first, OpenFrame open, StatedFrame stated = {})
      : inner_(std::move(first)), open_(std::move(open)), stated_(std::move(stated)) {}

  const FrameCapabilities& capabilities() const override { return counted_.capabilities; }
  std::vector<std::string> differences() const override { return counted_.differences; }
  std::optional<std::string> origin() const override { return inner_->origin(); }
  Task<Result<Identity>> identify() override;
  Task<Result<Identity>> observe(double rate_Hz) override;
  Task<Result<>> arm(FrameLimits limits) override { return inner_->arm(limits); }
  Task<Result<>> set_sample_rate(double rate_Hz) override {
    return inner_->set_sample_rate(rate_Hz);
  }
  Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) override {
    return inner_->move_to(travel, speed);
  }
  Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed, Length guard) override {
    return inner_->move_until_force(force, speed, guard);
  }
  Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) override {
    return inner_->ramp_force(force, rate);
  }
  Task<Result<>> hold_travel() override { return inner_->hold_travel(); }
  Task<Result<>> hold_force(Force force) override { return inner_->hold_force(force); }
  Task<Result<>> zero(bool force, bool travel) override { return inner_->zero(force, travel); }
  Task<Result<MotionOutcome>> place_mass(Mass mass) override { return inner_->place_mass(mass); }
  void show_pressure(const PressureArea& pressure) override { inner_->show_pressure(pressure); }
  Task<Result<>> stop() override { return inner_->stop(); }
  Task<Result<>> resync() override { return inner_->resync(); }
  Task<Result<Identity>> reconnect() override;
  void close() override { inner_->close(); }
  void set_listener(Listener* listener) override;

 private:
  void remember(const Identity& identity);

  std::unique_ptr<LoadFrame> inner_;
  OpenFrame open_;
  Listener* listener_ = nullptr;
  std::optional<Identity> identity_;
  std::optional<double> observed_Hz_;  // sample rate of an observed frame; absent: it is commanded
  StatedFrame stated_;
  // As of the first identify, with the zero of travel at that time: what the gateway stated, and
  // what counts.
  FrameCapabilities by_gateway_;
  CountedCapabilities counted_;
};

}  // namespace lcrig
