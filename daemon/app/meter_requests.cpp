// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/meter_requests.hpp"

#include <utility>

#include "base/clock.hpp"
#include "daemon/app/callers.hpp"
#include "daemon/app/queue_turns.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/service.hpp"

namespace lcrig {

Task<Result<MeterCorrections>> MeterRequests::correct(CorrectionKind kind, PeerCredentials peer) {
  std::string if_it_goes(
      "the queue goes, and its next run may begin at any moment: hold it first "
      "(`lcrig queue hold`)");
  auto claimed =
      co_await parts_.queue.claim_for_person(RigUse::State::correcting, std::move(if_it_goes));
  if (!claimed) co_return fail(claimed.error());
  parts_.notifier.status("makes a correction of the meter");
  peer.user = co_await parts_.callers.name_of(peer);
  auto made = co_await corrector_.make(kind, std::move(peer));
  parts_.use.give_back();
  co_return made;
}

Task<Result<MeterCorrections>> MeterRequests::look() {
  auto claimed = co_await parts_.use.claim(RigUse::State::asking);
  if (!claimed) co_return fail(claimed.error());
  auto seen = co_await corrector_.look();
  parts_.use.give_back();
  co_return seen;
}

}  // namespace lcrig
