// SPDX-License-Identifier: Apache-2.0
// The load frame of the manual rig: a guided rod that a person loads with weights. Force is mass
// times local g. Created by the App.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/quantity.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

struct DeadWeightSettings {
  double g_m_s2 = kStandardGravity_m_s2;  // of the place
  Mass rod;  // rod and plate, whose mass always rests on the specimen
  double sample_rate_Hz = 1;
  std::string serial;  // of the weight set's certificate, if any
};

// place_mass() is the only motion; all other motions are refused. From identify() on, samples come
// at every change and at the sample rate. `person` must honour cancellation, so that stop() can end
// a prompt. Operator and Clock must outlive this object; the Clock must outlive the io_context.
class DeadWeightFrame final : public LoadFrame {
 public:
  DeadWeightFrame(Operator& person, Clock& clock, asio::any_io_executor executor,
                  DeadWeightSettings settings = DeadWeightSettings());
  ~DeadWeightFrame() override;

  const FrameCapabilities& capabilities() const override { return capabilities_; }
  Task<Result<Identity>> identify() override;
  Task<Result<Identity>> observe(double rate_Hz) override;
  Task<Result<>> arm(FrameLimits limits) override;
  Task<Result<>> set_sample_rate(double rate_Hz) override;  // 0 to 10 Hz
  Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) override;
  Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed, Length guard) override;
  Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) override;
  Task<Result<>> hold_travel() override;  // nothing to do: weights lie still
  Task<Result<>> hold_force(Force force) override;
  Task<Result<>> zero(bool force, bool travel) override;
  // `mass` is the weights on the rod, without the rod. Errors: refused (not armed), limit_tripped
  // (force beyond the limits), busy, or the error of the operator's prompt. A stop() during the
  // prompt gives the outcome `stopped` and leaves the mass unchanged.
  Task<Result<MotionOutcome>> place_mass(Mass mass) override;
  void show_pressure(const PressureArea& pressure) override;
  Task<Result<>> stop() override;  // ends an open prompt at once
  Task<Result<>> resync() override;
  void close() override;
  void set_listener(Listener* listener) override;

  // The force on the specimen now, and the force after the open prompt is confirmed. Without a
  // prompt the two are equal.
  Force force() const;
  Force pending_force() const;

 private:
  struct State;
  Result<> check_place(Mass mass) const;
  std::string prompt(Mass mass) const;
  Force force_of(Mass mass) const;
  MotionOutcome outcome(MotionEnd reason) const;
  tl::unexpected<Error> no_motion() const;

  std::shared_ptr<State> state_;
  Operator& operator_;
  FrameCapabilities capabilities_;
};

}  // namespace lcrig
