// SPDX-License-Identifier: Apache-2.0
// Runs the daemon's App in virtual time with simulated instruments and without a socket. Base class
// of the rehearsals of a run (rehearse.cpp) and of a batch (rehearse_batch.cpp).
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <utility>

#include "daemon/app.hpp"

namespace lcrig {

// The rig of a rehearsal. A function makes the instruments when the run opens them. Not a
// SimulatedRig: people act there, a thread computes the specimen, and mistakes are found late.
class RehearsalRig final : public InstrumentFactory {
 public:
  using Make = std::function<Result<std::unique_ptr<Instruments>>(const InstrumentsRequest&)>;
  explicit RehearsalRig(Make make) : make_(std::move(make)) {}
  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) override;

 private:
  Make make_;
};

class Rehearsal {
 public:
  // Called on the calling thread whenever the status changed; may be empty.
  using Progress = std::function<void(const RunStatus&)>;
  explicit Rehearsal(const Progress& progress, VirtualClock clock = VirtualClock())
      : clock_(std::move(clock)), progress_(progress) {}
  virtual ~Rehearsal() = default;
  Rehearsal(const Rehearsal&) = delete;
  Rehearsal& operator=(const Rehearsal&) = delete;

 protected:
  // Does what clients and people would do. Afterwards App is shut down.
  virtual Task<> act() = 0;
  // Runs `act` to its end. Errors: bug.
  Result<> play();

  RealClock wall_;
  VirtualClock clock_;
  asio::io_context io_{1};
  std::unique_ptr<App> app_;

 private:
  Task<> act_and_end();
  void show();

  const Progress& progress_;
  bool is_over_ = false;
  std::exception_ptr bug_;
  MonoTime next_show_{};
};

}  // namespace lcrig
