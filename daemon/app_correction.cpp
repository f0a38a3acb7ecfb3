// SPDX-License-Identifier: Apache-2.0
// Requests of people about the corrections of the meter, which need the rig for themselves.
#include <utility>

#include "daemon/app.hpp"

namespace lcrig {

Task<Result<MeterCorrections>> App::correct_meter(CorrectionKind kind, PeerCredentials peer) {
  if (queue_ && queue_->goes()) {
    co_return fail(Errc::busy,
                   "the queue goes, and its next run may begin at any moment: hold it first "
                   "(`lcrig queue hold`)");
  }
  auto claimed = co_await claim(Use::correcting);
  if (!claimed) co_return fail(claimed.error());
  notifier_.status("makes a correction of the meter");
  peer.user = co_await user_name(peer, kNamePatience);
  auto made = co_await corrector_->make(kind, std::move(peer));
  enter(Use::idle);
  co_return made;
}

Task<Result<MeterCorrections>> App::look_at_corrections(PeerCredentials /*peer*/) {
  auto claimed = co_await claim(Use::asking);
  if (!claimed) co_return fail(claimed.error());
  auto seen = co_await corrector_->look();
  enter(Use::idle);
  co_return seen;
}

}  // namespace lcrig
