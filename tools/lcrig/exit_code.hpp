// SPDX-License-Identifier: Apache-2.0
// The exit codes of `lcrig`, which scripts rely on (docs/cli-json.md), and the failure that a
// command prints.
#pragma once

#include <optional>
#include <string>

#include "base/exit_status.hpp"
#include "base/result.hpp"

namespace lcrig::cli {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,
  kUsage = 2,
  kUnreachable = 3,  // there is no daemon
  kInstrument = 4,
  kStopped = 5,  // the run was aborted, or a limit tripped
  kProtocol = 6,  // the protocol is invalid or cannot be executed
  kNotStanding = 7,  // the frame did not confirm standstill: use the E-stop
  kStoppedEarly = 8,  // the run ended as `stopped`, on request
  kInterrupted = 130,
};

ExitCode exit_code_of(Errc code);
// The exit code for a run that ended, from its status and the reason.
ExitCode exit_code_of_run(ExitStatus status, std::optional<Errc> code);

// A mistake or a fault, and the command to type next.
struct Failure {
  Failure() = default;
  Failure(ExitCode c, std::string w, std::string n)
      : code(c), what(std::move(w)), next(std::move(n)) {}
  explicit Failure(const Error& error, std::string n = {})
      : code(exit_code_of(error.code)),
        what(error.what),
        next(std::move(n)),
        detail(error.detail),
        busy(error.code == Errc::busy) {}
  ExitCode code = kFailed;
  std::string what;
  std::string next;  // empty: there is nothing to propose
  std::string detail;  // lines to print below the message
  bool no_daemon = false;  // no daemon answers, or it does not answer as one
  bool not_lcrigd = false;  // something answers that is not lcrigd
  bool refused_request = false;  // the daemon says that the request itself is wrong
  bool busy = false;  // another program or run uses what is needed
};

template <class T>
class [[nodiscard]] Outcome : public tl::expected<T, Failure> {
 public:
  using tl::expected<T, Failure>::expected;
  Outcome() = default;
  Outcome(Failure failure) : tl::expected<T, Failure>(tl::unexpected(std::move(failure))) {}
};

}  // namespace lcrig::cli
