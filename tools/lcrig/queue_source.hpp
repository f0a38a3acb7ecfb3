// SPDX-License-Identifier: Apache-2.0
// Input of the commands that read the queue: the daemon is asked, and while none runs its database
// is read.
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
  // Failure: no daemon answers, and there is no database either.
  static Outcome<QueueSource> open(const Context& context);

  // As docs/cli-json.md has them: {"queue":…,"entries":[…]}, an entry, {"acts":[…]}. Failure: also
  // no such entry.
  Outcome<nlohmann::json> list();
  Outcome<nlohmann::json> show(std::int64_t entry);
  Outcome<nlohmann::json> history(std::optional<std::int64_t> entry, std::int64_t most);
  bool is_at_rest() const { return std::holds_alternative<Database>(from_); }

 private:
  explicit QueueSource(std::variant<ControlClient, Database> from) : from_(std::move(from)) {}
  std::variant<ControlClient, Database> from_;
};

}  // namespace lcrig::cli
