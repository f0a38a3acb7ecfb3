// SPDX-License-Identifier: Apache-2.0
// The driver of a load frame behind a frame-link/1 gateway: ZwickRoell beside testXpert, DOLI EDC,
// or the simulator. Created by the App.
#pragma once

#include <memory>

#include "drivers/load_frame.hpp"
#include "drivers/transport.hpp"

namespace lcrig {

namespace frame_link {
class Link;
}

// One session over one transport. When the link is lost (1 s of silence, closed port, restarted
// gateway), every wait ends with `disconnected` and the listener is told once. The object cannot be
// used afterwards; make a new one to reconnect. Destroying it closes the link. The Clock must
// outlive the io_context.
class ZwickLink final : public LoadFrame {
 public:
  ZwickLink(std::unique_ptr<Transport> transport, Clock& clock, asio::any_io_executor executor);
  ~ZwickLink() override;

  const FrameCapabilities& capabilities() const override { return capabilities_; }
  std::optional<std::string> origin() const override;
  // Starts the link and sends STOP before anything else. Errors: no_reply, garbled (something else
  // answers), refused (another protocol).
  Task<Result<Identity>> identify() override;
  // Fails with a gateway of revision 1, which does not know OBSERVE. It does not try anything else.
  Task<Result<Identity>> observe(double rate_Hz) override;
  Task<Result<>> arm(FrameLimits limits) override;
  Task<Result<>> set_sample_rate(double rate_Hz) override;
  // A motion whose command is not answered within 1 s is stopped, in case it has started.
  Task<Result<MotionOutcome>> move_to(Length travel, Velocity speed) override;
  Task<Result<MotionOutcome>> move_until_force(Force force, Velocity speed, Length guard) override;
  Task<Result<MotionOutcome>> ramp_force(Force force, ForceRate rate) override;
  Task<Result<>> hold_travel() override;
  Task<Result<>> hold_force(Force force) override;
  Task<Result<>> zero(bool force, bool travel) override;
  Task<Result<MotionOutcome>> place_mass(Mass mass) override;
  // Errors: not_standing (two STOPs were not confirmed, each within the time of deceleration plus 1
  // s), disconnected.
  Task<Result<>> stop() override;
  Task<Result<>> resync() override;
  void close() override;
  void set_listener(Listener* listener) override;

 private:
  Task<Result<>> greet(std::optional<double> observe_Hz);
  Duration stop_time() const;

  std::shared_ptr<frame_link::Link> link_;
  FrameCapabilities capabilities_;
  std::optional<Velocity> armed_speed_;
};

}  // namespace lcrig
