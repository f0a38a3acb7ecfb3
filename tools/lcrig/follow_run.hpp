// SPDX-License-Identifier: Apache-2.0
// Shows a run of the daemon until it ends; Enter confirms or answers, Ctrl-C stops.
#pragma once

#include <cstdint>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

struct FollowOptions {
  std::int64_t run = 0;  // 0: whichever goes on
  // `lcrig run`: Enter confirms a prompt or sends the answer before it, the first Ctrl-C aborts the
  // run and waits for its end, the second one leaves. Otherwise (`lcrig watch`) Ctrl-C just leaves.
  bool owner = false;
};

// SIGINT and SIGTERM become readable instead of deadly while this lives.
class StopSignals {
 public:
  // With `hangup` a terminal that is closed stops, too; what the daemon does goes on without one.
  explicit StopSignals(bool hangup = false);
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  int fd() const { return fd_; }
  int take();  // one that is pending; 0: none is

 private:
  bool hangup_;
  int fd_ = -1;
};

struct FollowEnd {
  RunOutcome run;
  bool interrupted = false;  // by a signal to this process
};

// `client` has called `watch`. Failure: unreachable; interrupted, when left before the end.
Outcome<FollowEnd> follow_run(Context& context, ControlClient& client, StopSignals& signals,
                              FollowOptions options);
// Summary (or the JSON line) of a run that ended, and where to find it.
ExitCode print_run_end(Context& context, ControlClient& client, const RunOutcome& ended);

}  // namespace lcrig::cli
