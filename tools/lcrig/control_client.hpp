// SPDX-License-Identifier: Apache-2.0
// The command line's end of the control socket, for every command that talks to lcrigd. It blocks;
// use it from one thread.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "base/time.hpp"
#include "daemon/control/messages.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

// The answer to a `post`.
struct ControlAnswer {
  std::int64_t id = 0;
  std::optional<Failure> failure;
};
using ControlNews = std::variant<RunStatus, RunEventNote, RunOutcome, QueueStatus, ControlAnswer>;

// For a call that plans a run: it may have to wait for the instruments first.
inline constexpr Duration kPlanPatience = std::chrono::minutes(2);

// The command to propose when no daemon answers: it looks for the daemon, or rehearses instead.
std::string without_daemon(const std::string& rehearsal);
// The same for a command that needs a daemon, so that a rehearsal is no substitute.
Failure without_rehearsal(Failure failure);
// "run 12, dynamic-cycles on paper-1, in step load"
std::string words_of(const ResumableRun& run);

// Works for files that do not exist yet, too.
bool is_same_file(const std::string& a, const std::string& b);

// For a person whose stop was not answered.
inline constexpr const char* kStopByHand =
    "no answer yet: if the frame moves, stop it at the machine (E-stop)";

class ControlClient {
 public:
  // `clock` must outlive the client. Failure: unreachable, with what to do about it. `patience`
  // limits the wait for a daemon that accepts no client, or reads nothing.
  static Outcome<ControlClient> connect(const std::string& path, const Clock& clock,
                                        Duration patience = std::chrono::seconds(15));
  // Connects as the options of the command line say. Failure: also usage, when --db names another
  // database than the daemon's, because the daemon writes only into its own.
  static Outcome<ControlClient> connect(const Context& context);
  // For those who stop the frame or only look: they are served first, and then told of another
  // --db.
  static Outcome<ControlClient> connect_for_any_database(
      const Context& context, Duration patience = std::chrono::seconds(15));
  // For those who stop the frame: as above, and while they wait they are told once how to stop it
  // by hand.
  static Outcome<ControlClient> connect_to_stop(const Context& context);
  void tell_other_database(const Context& context);
  // From now on `call` fails as interrupted when `fd` (of StopSignals) becomes readable. It must
  // outlive the calls.
  void leave_on(int fd);
  ControlClient(ControlClient&&) noexcept;
  ~ControlClient();

  // The daemon's database, an absolute path. Failure: no answer in time, or it is not a path.
  Outcome<std::string> database(Duration patience = std::chrono::seconds(15));
  // "--db x.db: the daemon at ... has another database, ..."; "" when it is the daemon's own.
  Outcome<std::string> other_database(const std::string& named, const char* named_by = "--db");

  // Waits for the answer. Other messages that arrive meanwhile are kept for `take`.
  Outcome<nlohmann::json> call(std::string_view method, const nlohmann::json& params,
                               Duration timeout = std::chrono::seconds(15));
  // Sends without waiting. `take` will return the answer.
  Outcome<std::int64_t> post(std::string_view method, const nlohmann::json& params);
  // The next message that has arrived; does not wait. Failure: unreachable, when the daemon closed
  // the connection.
  Outcome<std::optional<ControlNews>> take();
  int fd() const;  // readable when `take` may have a message

 private:
  struct State;
  explicit ControlClient(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Makes one call to the daemon that `connect` finds.
Outcome<nlohmann::json> call_daemon(const Context& context, std::string_view method,
                                    const nlohmann::json& params,
                                    Duration timeout = std::chrono::seconds(15));

}  // namespace lcrig::cli
