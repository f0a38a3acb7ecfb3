// SPDX-License-Identifier: Apache-2.0
// Sums up the state of the rig for a monitoring program: one word and the reason. Used by `lcrig
// status --check`.
#pragma once

#include <string>

#include "daemon/control/messages.hpp"

namespace lcrig::cli {

// The numbers are the exit codes that monitoring programs (Nagios and similar) expect.
enum class Verdict : int { ok = 0, warning = 1, critical = 2, unknown = 3 };
const char* to_string(Verdict verdict);

struct StatusCheck {
  Verdict verdict = Verdict::ok;
  std::string words;
};
StatusCheck check_status(const DaemonStatus& status);

}  // namespace lcrig::cli
