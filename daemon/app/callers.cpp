// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/callers.hpp"

#include "base/clock.hpp"
#include "daemon/control/audit.hpp"
#include "daemon/control/server.hpp"
#include "daemon/record/recorder.hpp"

namespace lcrig {

using namespace std::chrono_literals;

Task<std::string> Callers::name_of(const PeerCredentials& peer) {
  return server_.user_name(peer, 2s);
}

Task<std::string> Callers::name_for_stop(const PeerCredentials& peer) {
  return server_.user_name(peer, 20ms);
}

void Callers::note(std::string_view request, const PeerCredentials& peer, std::string_view why) {
  recorder_->event(request_event(clock_.now(), request, peer, why));
}

}  // namespace lcrig
