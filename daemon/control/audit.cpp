// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/audit.hpp"

#include <nlohmann/json.hpp>

namespace lcrig {

using nlohmann::json;

RunEvent request_event(MonoTime now, std::string_view request, const PeerCredentials& peer,
                       std::string_view why) {
  json detail{{"request", request}, {"user", peer.user}, {"uid", peer.uid}, {"pid", peer.pid}};
  if (!why.empty()) detail["why"] = why;
  return RunEvent(now, "request", "", detail.dump(-1, ' ', false, json::error_handler_t::replace));
}

std::string peer_words(const PeerCredentials& peer) {
  return fmt::format("{} (uid {}, pid {})", peer.user, peer.uid, peer.pid);
}

}  // namespace lcrig
