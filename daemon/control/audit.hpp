// SPDX-License-Identifier: Apache-2.0
// Records who asked the daemon for what, as reported by the kernel (SO_PEERCRED) and not by the
// client. Used by App and the control sessions.
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
