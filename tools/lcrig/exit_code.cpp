// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/exit_code.hpp"

namespace lcrig::cli {

ExitCode exit_code_of(Errc code) {
  switch (code) {
    case Errc::no_reply:
    case Errc::reply_cut_off:
    case Errc::garbled:
    case Errc::refused:
    case Errc::unsupported:
    case Errc::frame_fault:
    case Errc::disconnected: return kInstrument;
    case Errc::not_standing: return kNotStanding;
    case Errc::limit_tripped:
    case Errc::aborted: return kStopped;
    case Errc::busy:
    case Errc::invalid_request:
    case Errc::io:
    case Errc::bug: return kFailed;
  }
  return kFailed;
}

ExitCode exit_code_of_run(ExitStatus status, std::optional<Errc> code) {
  if (status == ExitStatus::success) return kOk;
  if (status == ExitStatus::abort) return kStopped;
  if (status == ExitStatus::stopped) return kStoppedEarly;
  if (!code) return kFailed;
  // The run could not be planned with the true capabilities of the instruments.
  if (*code == Errc::invalid_request) return kProtocol;
  return exit_code_of(*code);
}

}  // namespace lcrig::cli
