// SPDX-License-Identifier: Apache-2.0
#include "daemon/rehearsal.hpp"

#include <boost/asio/co_spawn.hpp>

namespace lcrig {

Task<Result<std::unique_ptr<Instruments>>> RehearsalRig::open(InstrumentsRequest request) {
  co_return make_(request);
}

Task<> Rehearsal::act_and_end() {
  co_await act();
  co_await app_->shut_down("over");
  is_over_ = true;
}

Result<> Rehearsal::play() {
  asio::co_spawn(io_, act_and_end(), [this](std::exception_ptr bug) { bug_ = bug; });
  const auto is_done = [this] {
    show();
    return is_over_ || bug_;
  };
  const bool ended = clock_.run(io_, is_done);
  if (bug_) std::rethrow_exception(bug_);
  if (!ended) return fail(Errc::bug, "the rehearsal waits for something that never comes");
  return {};
}

// Shows the status from time to time.
void Rehearsal::show() {
  if (!progress_) return;
  const MonoTime now = wall_.now();
  if (now < next_show_ && !is_over_) return;
  next_show_ = now + std::chrono::milliseconds(50);
  const DaemonStatus status = app_->status();
  if (status.run) progress_(*status.run);
}

}  // namespace lcrig
