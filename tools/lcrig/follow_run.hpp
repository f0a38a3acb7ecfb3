// SPDX-License-Identifier: Apache-2.0
// Shows a run of the daemon until it ends: Enter confirms or answers, Ctrl-C stops. Used by `lcrig
// run` and `lcrig watch`.
#pragma once

#include <cstdint>

#include "tools/lcrig/command.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

struct FollowOptions {
  std::int64_t run = 0;  // 0: whichever run goes on
  // True for `lcrig run`: Enter confirms a prompt, or sends the answer typed before it. The first
  // Ctrl-C aborts the run and waits for its end, the second one leaves. False for `lcrig watch`:
  // Ctrl-C leaves and does nothing else.
  bool owner = false;
};

// While it lives, SIGINT and SIGTERM do not end the process but make `fd` readable.
class StopSignals {
 public:
  // With `hangup` a closed terminal stops, too. Work of the daemon goes on without a terminal.
  explicit StopSignals(bool hangup = false);
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  int fd() const { return fd_; }
  int take();  // a pending signal; 0: there is none

 private:
  bool hangup_;
  int fd_ = -1;
};

struct FollowEnd {
  RunOutcome run;
  bool interrupted = false;  // left because of a signal to this process
};

// `client` must have called `watch`. Failure: unreachable; interrupted, when left before the end.
Outcome<FollowEnd> follow_run(Context& context, ControlClient& client, StopSignals& signals,
                              FollowOptions options);
// Prints the summary (or the JSON line) of a run that ended, and where to find the run.
ExitCode print_run_end(Context& context, ControlClient& client, const RunOutcome& ended);

}  // namespace lcrig::cli
