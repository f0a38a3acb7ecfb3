// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/audit.hpp"

#include "daemon/control/user_names.hpp"

namespace lcrig {

RunEvent request_event(MonoTime now, std::string_view request, const PeerCredentials& peer,
                       std::string_view why) {
  RequestEvent asked{std::string(request), peer.user, peer.uid, peer.pid, std::nullopt};
  if (!why.empty()) asked.why = why;
  return RunEvent(now, "", asked);
}

std::string peer_words(const PeerCredentials& peer) {
  if (peer.user == uid_words(peer.uid)) return fmt::format("{} (pid {})", peer.user, peer.pid);
  return fmt::format("{} (uid {}, pid {})", peer.user, peer.uid, peer.pid);
}

}  // namespace lcrig
