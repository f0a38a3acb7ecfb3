// SPDX-License-Identifier: Apache-2.0
// The users at the control socket: finds their names, and records their requests in the run. Used
// by the parts of App that serve requests.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/task.hpp"
#include "base/time.hpp"

namespace lcrig {

class ControlServer;
class Recorder;
struct PeerCredentials;

class Callers {
 public:
  // `recorder` is empty while no database is open.
  Callers(Clock& clock, ControlServer& server, const std::unique_ptr<Recorder>& recorder)
      : clock_(clock), server_(server), recorder_(recorder) {}

  Task<std::string> name_of(const PeerCredentials& peer);
  // A stop must not wait long for a name: this time is enough for one in the password file.
  Task<std::string> name_for_stop(const PeerCredentials& peer);
  void note(std::string_view request, const PeerCredentials& peer, std::string_view why = {});

 private:
  Clock& clock_;
  ControlServer& server_;
  const std::unique_ptr<Recorder>& recorder_;
};

}  // namespace lcrig
