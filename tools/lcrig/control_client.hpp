// SPDX-License-Identifier: Apache-2.0
// The command line's end of the control socket, for every command that talks to lcrigd. Blocking;
// one thread.
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
using ControlNews = std::variant<RunStatus, RunEventNote, RunOutcome, ControlAnswer>;

// The command to type when no daemon answers: it looks for the daemon, or rehearses instead.
std::string without_daemon(const std::string& rehearsal);
// The same for a command that only a daemon can do: nothing is rehearsed instead.
Failure without_rehearsal(Failure failure);
// "run 12, dynamic-cycles on paper-1, in step load"
std::string words_of(const ResumableRun& run);

// Also of files that are not there yet.
bool is_same_file(const std::string& a, const std::string& b);

// For whom a stop was not answered.
inline constexpr const char* kStopByHand =
    "no answer yet: if the frame moves, stop it at the machine (E-stop)";

class ControlClient {
 public:
  // `clock` outlives the client. Failure: unreachable, with what to do about it. `patience`: of a
  // daemon that takes no new client, or nothing that is sent.
  static Outcome<ControlClient> connect(const std::string& path, const Clock& clock,
                                        Duration patience = std::chrono::seconds(15));
  // As its options say. Failure: also usage, when --db names another database than the daemon's,
  // which is the only one that it writes into.
  static Outcome<ControlClient> connect(const Context& context);
  // For who stops the frame, and who only looks: these are answered first, and told then.
  static Outcome<ControlClient> connect_for_any_database(
      const Context& context, Duration patience = std::chrono::seconds(15));
  // For who stops the frame: as the last, and whoever waits is told once how to stop it by hand.
  static Outcome<ControlClient> connect_to_stop(const Context& context);
  void tell_other_database(const Context& context);
  // From now on `call` fails as interrupted when `fd` becomes readable (StopSignals), which
  // outlives the calls.
  void leave_on(int fd);
  ControlClient(ControlClient&&) noexcept;
  ~ControlClient();

  // An absolute path. Failure: nobody answered in time, or not with a path.
  Outcome<std::string> database(Duration patience = std::chrono::seconds(15));
  // "--db x.db: the daemon at ... has another database, ..."; "" when it is the daemon's.
  Outcome<std::string> other_database(const std::string& named, const char* named_by = "--db");

  // Waits for the answer; what else arrives meanwhile is kept for `take`.
  Outcome<nlohmann::json> call(std::string_view method, const nlohmann::json& params,
                               Duration timeout = std::chrono::seconds(15));
  // Does not wait: the answer comes out of `take`.
  Outcome<std::int64_t> post(std::string_view method, const nlohmann::json& params);
  // The next thing that arrived, without waiting for one. Failure: unreachable, when the daemon
  // closed the connection.
  Outcome<std::optional<ControlNews>> take();
  int fd() const;  // readable when `take` may have something new

 private:
  struct State;
  explicit ControlClient(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// One call of the daemon that `connect` finds.
Outcome<nlohmann::json> call_daemon(const Context& context, std::string_view method,
                                    const nlohmann::json& params,
                                    Duration timeout = std::chrono::seconds(15));

}  // namespace lcrig::cli
