// SPDX-License-Identifier: Apache-2.0
// Sums up the state of the rig for a monitoring program: one word, and why. `lcrig status --check`
// uses it.
#pragma once

#include <string>

#include "daemon/control/messages.hpp"

namespace lcrig::cli {

// Their numbers are the exit codes that such programs know (Nagios and its kind).
enum class Verdict : int { ok = 0, warning = 1, critical = 2, unknown = 3 };
const char* to_string(Verdict verdict);

struct StatusCheck {
  Verdict verdict = Verdict::ok;
  std::string words;
};
StatusCheck check_status(const DaemonStatus& status);

}  // namespace lcrig::cli
