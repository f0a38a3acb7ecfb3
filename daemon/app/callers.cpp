// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/callers.hpp"

#include "daemon/control/audit.hpp"

namespace lcrig {

Task<std::string> Callers::name_of(const PeerCredentials& peer) {
  return server_.user_name(peer, std::chrono::seconds(2));
}

Task<std::string> Callers::name_for_stop(const PeerCredentials& peer) {
  return server_.user_name(peer, std::chrono::milliseconds(20));
}

void Callers::note(std::string_view request, const PeerCredentials& peer, std::string_view why) {
  recorder_->event(request_event(clock_.now(), request, peer, why));
}

}  // namespace lcrig
