// SPDX-License-Identifier: Apache-2.0
// Input of the commands that read the queue. It asks the daemon; while none runs, it reads the
// daemon's database.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "storage/database.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

class QueueSource {
 public:
  // Failure: no daemon answers, and there is no database.
  static Outcome<QueueSource> open(const Context& context);

  // The members are those of docs/cli-json.md: {"queue":…,"entries":[…]}, an entry, {"acts":[…]}.
  // Failure: also if there is no such entry.
  Outcome<nlohmann::json> list();
  Outcome<nlohmann::json> show(std::int64_t entry);
  Outcome<nlohmann::json> history(std::optional<std::int64_t> entry, std::int64_t most);
  bool is_at_rest() const { return std::holds_alternative<Database>(from_); }
  // Why the database was read instead.
  const char* rest_words() const {
    return written_ ? "as the database has it: the daemon that records into it was not reached; "
                      "name its --socket"
                    : "as the database has it: no daemon answers";
  }

 private:
  explicit QueueSource(std::variant<ControlClient, Database> from, bool written = false)
      : from_(std::move(from)), written_(written) {}
  std::variant<ControlClient, Database> from_;
  bool written_ = false;  // a daemon has it open
};

}  // namespace lcrig::cli
