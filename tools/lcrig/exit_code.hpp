// SPDX-License-Identifier: Apache-2.0
// Exit codes of `lcrig`, a promise to scripts (docs/cli-json.md), and the failure that a command
// prints.
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
  kUnreachable = 3,  // no daemon
  kInstrument = 4,
  kStopped = 5,  // aborted, or a limit tripped
  kProtocol = 6,  // the protocol is invalid or cannot be done
  kNotStanding = 7,  // the frame did not confirm that it stands: use the E-stop
  kStoppedEarly = 8,  // the run ended as `stopped`, as somebody asked
  kInterrupted = 130,
};

ExitCode exit_code_of(Errc code);
// The exit code for a run that ended, and why.
ExitCode exit_code_of_run(ExitStatus status, std::optional<Errc> code);

// A mistake or fault, and the next command to type.
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
  std::string next;  // empty: nothing to suggest
  std::string detail;  // lines below the message
  bool no_daemon = false;  // none answers, or not as one
  bool not_lcrigd = false;  // something answers that does not speak its language
  bool refused_request = false;  // the daemon called the request itself wrong
  bool busy = false;  // another program or run has what is wanted
};

// A value or a Failure.
template <class T>
class [[nodiscard]] Outcome : public tl::expected<T, Failure> {
 public:
  using tl::expected<T, Failure>::expected;
  Outcome() = default;
  Outcome(Failure failure) : tl::expected<T, Failure>(tl::unexpected(std::move(failure))) {}
};

}  // namespace lcrig::cli
