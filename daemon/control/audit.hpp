// SPDX-License-Identifier: Apache-2.0
// Who asked the daemon for what, by the kernel's word (SO_PEERCRED) and not the client's. App and
// the control sessions note it.
#pragma once

#include <string>
#include <string_view>

#include "daemon/control/messages.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// Event row of kind "request":
// {"request":"run.abort","user":"lab","uid":1000,"pid":4711,"why":"wrong specimen"}.
RunEvent request_event(MonoTime now, std::string_view request, const PeerCredentials& peer,
                       std::string_view why = {});
// "lab (uid 1000, pid 4711)", for the log.
std::string peer_words(const PeerCredentials& peer);

}  // namespace lcrig
