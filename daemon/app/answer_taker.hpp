// SPDX-License-Identifier: Apache-2.0
// What people say to a run, or to a gate of the queue, that waits for them: a confirmation or an
// answer. App owns it; the control socket calls it.
#pragma once

#include <memory>

#include "daemon/app/callers.hpp"
#include "daemon/app/queue_turns.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/control/handler.hpp"
#include "daemon/rig/operator.hpp"

namespace lcrig {

class AnswerTaker final : public AnswerHandler {
 public:
  AnswerTaker(RigUse& use, Callers& callers, RemoteOperator& person, const QueueTurns& queue,
              const std::unique_ptr<Recorder>& recorder)
      : use_(use), callers_(callers), person_(person), queue_(queue), recorder_(recorder) {}

  Task<Result<>> confirm(PeerCredentials peer) override;
  Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials peer) override;

 private:
  RigUse& use_;
  Callers& callers_;
  RemoteOperator& person_;
  const QueueTurns& queue_;
  const std::unique_ptr<Recorder>& recorder_;
};

}  // namespace lcrig
