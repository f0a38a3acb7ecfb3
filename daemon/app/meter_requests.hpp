// SPDX-License-Identifier: Apache-2.0
// People's requests about the corrections of the meter, which need the rig for themselves. Owned by
// App; called by the control socket.
#pragma once

#include "daemon/control/handler.hpp"
#include "daemon/rig/corrector.hpp"

namespace lcrig {

class Callers;
class QueueTurns;
class RigUse;
class ServiceNotifier;

class MeterRequests final : public MeterHandler {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    RigUse& use;
    Callers& callers;
    QueueTurns& queue;
    const ServiceNotifier& notifier;
  };
  MeterRequests(const Corrector::Parts& corrector, const Parts& parts)
      : corrector_(corrector), parts_(parts) {}

  Task<Result<MeterCorrections>> correct(CorrectionKind kind, PeerCredentials peer) override;
  Task<Result<MeterCorrections>> look() override;
  // Call when the daemon ends.
  void give_up() { corrector_.give_up(); }

 private:
  Corrector corrector_;
  Parts parts_;
};

}  // namespace lcrig
