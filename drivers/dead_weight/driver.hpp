// SPDX-License-Identifier: Apache-2.0
// The manual rig: a guided rod, loaded with weights by a person. Force is mass times local g.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

struct DeadWeightSettings {
  DeadWeightSettings() = default;
  double g_m_s2 = 9.80665;  // local
  Mass rod;  // of rod and plate: always on the specimen
  std::optional<Area> probe_area;  // for the pressure in the prompt
  double sample_rate_Hz = 1;
  std::string serial;  // of the weight set, if it has a certificate
};

// place_mass() is the only motion; everything else that moves is refused. Samples come at every
// change and at the sample rate from identify() on. `person` must honour cancellation, so that
// stop() can end a prompt. Operator and Clock must outlive this object, the Clock the io_context.
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
  // `mass` is what lies on the rod, the rod not counted. Errors: refused (not armed),
  // limit_tripped (force beyond the limits), busy, or what the operator's prompt says. A stop()
  // meanwhile gives the outcome `stopped`, the mass unchanged.
  Task<Result<MotionOutcome>> place_mass(Mass mass) override;
  Task<Result<>> stop() override;  // ends a prompt at once; asks nothing
  Task<Result<>> resync() override;
  void close() override;
  void set_listener(Listener* listener) override;

  // On the specimen now, and what it will be when the open prompt is confirmed (equal without one).
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
