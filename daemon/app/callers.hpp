// SPDX-License-Identifier: Apache-2.0
// The users at the control socket: finds their names, and records their requests in the run. Used
// by the parts of App that serve requests.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "daemon/control/audit.hpp"
#include "daemon/control/server.hpp"
#include "daemon/record/recorder.hpp"

namespace lcrig {

class Callers {
 public:
  // `recorder` is empty while no database is open.
  Callers(Clock& clock, ControlServer& server, const std::unique_ptr<Recorder>& recorder)
      : clock_(clock), server_(server), recorder_(recorder) {}

  Task<std::string> name_of(const PeerCredentials& peer) {
    return server_.user_name(peer, std::chrono::seconds(2));
  }
  // A stop must not wait long for a name: this time is enough for one in the password file.
  Task<std::string> name_for_stop(const PeerCredentials& peer) {
    return server_.user_name(peer, std::chrono::milliseconds(20));
  }
  void note(std::string_view request, const PeerCredentials& peer, std::string_view why = {}) {
    recorder_->event(request_event(clock_.now(), request, peer, why));
  }

 private:
  Clock& clock_;
  ControlServer& server_;
  const std::unique_ptr<Recorder>& recorder_;
};

}  // namespace lcrig
